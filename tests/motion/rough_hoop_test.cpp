#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tanor/tanor.hpp>

#include "motion/rough_guides.hpp"

/// \file A bead on a rough hoop that turns with omega(t) about its vertical diameter. At the angle theta from the
/// bottom
///
///   m R theta_ddot = m sin theta (omega^2 R cos theta - g) - friction,   friction = mu |N|,
///   N = m (R theta_dot^2 + g cos theta + omega^2 R sin^2 theta) in the plane of the hoop,
///       m R (2 omega theta_dot cos theta + omega_dot sin theta) across it
namespace tanor {
namespace {

constexpr double g = 9.81, R = 0.7;

/// `turn`: the angle of the hoop, a formula; omega its rate at the start.
System make_hoop(double theta, const std::string& turn, double omega, double mu, double mu_s) {
  System system;
  system.positions = {R * std::sin(theta), 0.0, -R * std::cos(theta)};
  system.velocities = {0.0, omega * R * std::sin(theta), 0.0};
  system.masses = {1.3};
  const VectorFunction normal{ScalarFunction::formula("sin(" + turn + ")"),
                              ScalarFunction::formula("-cos(" + turn + ")"), 0.0};
  system.constraints = {Circles{"hoop", {0}, Vector3{}, normal, R}};
  system.forces = {Gravity{"", {0.0, 0.0, -g}}};
  system.friction = {Coulomb{.name = "", .at = {"hoop"}, .coefficient = mu, .static_coefficient = mu_s}};
  return system;
}

double angle(const Simulation& simulation) {
  const auto r = simulation.positions();
  return std::atan2(std::hypot(r[0], r[1]), -r[2]);
}

/// |tangential| - mu |N| at rest on the hoop, over the mass.
long double excess(long double theta, long double omega, long double omega_dot, long double mu) {
  const long double s = std::sin(theta), c = std::cos(theta);
  const long double along = s * (omega * omega * R * c - g);
  return std::abs(along) - mu * std::hypot(g * c + omega * omega * R * s * s, R * omega_dot * s);
}

TEST(RoughHoop, SticksInTheIntervalOfTheClosedForm) {
  const double omega = 5.0, mu = 0.2;
  const double middle = std::acos(g / (omega * omega * R));
  const auto at = [&](long double theta) { return excess(theta, omega, 0.0L, mu); };
  const auto low = static_cast<double>(find_root(at, 0.3, middle)),
             high = static_cast<double>(find_root(at, middle, 1.5));
  ASSERT_LT(low, middle - 0.1);
  ASSERT_GT(high, middle + 0.1);
  for (const auto& [theta, holds] :
       {std::pair{low - 1e-7, false}, {low + 1e-7, true}, {middle, true}, {high - 1e-7, true}, {high + 1e-7, false}}) {
    Simulation simulation(make_hoop(theta, "5*t", omega, mu, mu), {.rtol = 1e-10, .atol = 1e-12});
    ASSERT_TRUE(simulation.advance(0.01).ok()) << simulation.outcome().what;
    if (holds)
      EXPECT_NEAR(angle(simulation), theta, 1e-13);
    else
      EXPECT_GT(std::abs(angle(simulation) - theta), 1e-12) << theta;
  }
}

TEST(RoughHoop, WhatSticksTurnsWithTheHoopForAHundredSecondsAndDoesNotCreepInTheTangentForm) {
  for (const Method method : {Method::Dopri5, Method::Rk4}) {
    MotionOptions options{.method = method};
    if (method != Method::Dopri5) options.step = 0.01;
    const double theta = 1.0;
    System system = make_hoop(theta, "5*t", 5.0, 0.3, 0.3);
    const auto& hoop = std::get<Circles>(system.constraints[0]);
    system.coordinates = {CircleCoordinates{"", {0}, hoop.center, hoop.normal, R}};
    Simulation simulation(system, options, {.form = Form::Tangent});
    ASSERT_TRUE(simulation.advance(100.0).ok()) << simulation.outcome().what;
    EXPECT_EQ(simulation.report().events, 0u);
    EXPECT_NEAR(angle(simulation), theta, 1e-10) << method_name(method);
    EXPECT_NEAR(simulation.positions()[0], R * std::sin(theta) * std::cos(500.0), 1e-10) << method_name(method);
  }
}

TEST(RoughHoop, LeavesWhereTheHoopHasBecomeTooFast) {
  // omega = 3.8 + a t: N has a part across the hoop too
  for (const double a : {0.2, 1.5}) {
    const double theta = 0.9, mu = 0.3;
    const std::string turn = "3.8*t + " + std::to_string(0.5 * a) + "*t^2";
    const long double instant = find_root(
        [&](long double t) { return excess(theta, 3.8L + static_cast<long double>(a) * t, a, mu); }, 0.0L, 20.0L);
    for (const Method method : {Method::Dopri5, Method::Rk4, Method::Rattle}) {
      MotionOptions options{.method = method, .rtol = 1e-11, .atol = 1e-13};
      if (method != Method::Dopri5) options.step = 0.002;
      Simulation simulation(make_hoop(theta, turn, 3.8, 0.25, mu), options);
      const std::vector<double> events = advance_and_list_events(&simulation, static_cast<double>(instant) + 0.05);
      ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
      ASSERT_EQ(events.size(), 1u) << method_name(method);
      const double allowed = method == Method::Rattle ? 1e-3 : 2e-8;  // what the scheme moves along the hoop until then
      EXPECT_NEAR(events[0], static_cast<double>(instant), allowed) << method_name(method);
      EXPECT_GT(angle(simulation), theta + 1e-4);
    }
  }
}

}  // namespace
}  // namespace tanor
