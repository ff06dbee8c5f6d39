#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tanor/tanor.hpp>

#include "motion/rough_guides.hpp"
#include "rough_scenes.hpp"
#include "scenes.hpp"

/// \file A bead on a rough hoop that turns with omega(t) about its vertical diameter. At the angle theta from the
/// bottom its motion is
///
///   m R theta_ddot = m sin theta (omega^2 R cos theta - g) - friction,   friction = mu |N|,
///   N = m (R theta_dot^2 + g cos theta + omega^2 R sin^2 theta) in the plane of the hoop,
///       m R (2 omega theta_dot cos theta + omega_dot sin theta) across it
namespace tanor {
namespace {

using scenes::g;
constexpr double R = 0.7;

double angle(const Simulation& simulation) {
  const auto r = simulation.positions();
  return std::atan2(std::hypot(r[0], r[1]), -r[2]);
}

/// Returns |tangential| - mu |N| of a bead at rest on the hoop, over the mass.
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
    Simulation simulation(scenes::make_rough_hoop(theta, "5*t", omega, mu, mu), {.rtol = 1e-10, .atol = 1e-12});
    ASSERT_TRUE(simulation.advance_to(0.01).ok()) << simulation.outcome().what;
    if (holds)
      EXPECT_NEAR(angle(simulation), theta, 1e-13);
    else
      EXPECT_GT(std::abs(angle(simulation) - theta), 1e-12) << theta;
  }
}

TEST(RoughHoop, StickingBeadDoesNotCreepForAHundredSecondsInTheTangentForm) {
  for (const Method method : {Method::Dopri5, Method::Rk4}) {
    MotionOptions options{.method = method};
    if (has_fixed_steps(method)) options.step = 0.01;
    const double theta = 1.0;
    System system = scenes::make_rough_hoop(theta, "5*t", 5.0, 0.3, 0.3);
    const auto& hoop = std::get<Circles>(system.constraints[0]);
    system.coordinates = {CircleCoordinates{"", {0}, hoop.center, hoop.normal, R}};
    Simulation simulation(system, options, {.form = Form::Tangent});
    ASSERT_TRUE(simulation.advance_to(100.0).ok()) << simulation.outcome().what;
    EXPECT_EQ(simulation.report().events, 0u);
    EXPECT_NEAR(angle(simulation), theta, 1e-10) << name_of(method);
    EXPECT_NEAR(simulation.positions()[0], R * std::sin(theta) * std::cos(500.0), 1e-10) << name_of(method);
  }
}

TEST(RoughHoop, StickingBeadKeepsItsPlaceForAHundredSeconds) {
  const double theta = 1.0;
  for (const Method method : {Method::Auto, Method::Dopri5, Method::Dop853, Method::Rk4, Method::Rattle}) {
    MotionOptions options{.method = method};
    if (has_fixed_steps(method)) options.step = 0.01;
    Simulation simulation(scenes::make_rough_hoop(theta, "5*t", 5.0, 0.3, 0.3), options);
    ASSERT_TRUE(simulation.advance_to(100.0).ok()) << simulation.outcome().what;
    EXPECT_EQ(simulation.report().events, 0u);
    // The angle of the hoop rounds by 500 eps, each step by eps.
    EXPECT_NEAR(angle(simulation), theta, 3e-12) << name_of(method);
    EXPECT_NEAR(simulation.positions()[0], R * std::sin(theta) * std::cos(500.0), 3e-12) << name_of(method);
    EXPECT_NEAR(simulation.positions()[1], R * std::sin(theta) * std::sin(500.0), 3e-12) << name_of(method);
  }
}

/// The hoop is a sphere and a plane that turns, as in examples/rough_hoop.json.
TEST(RoughHoop, StickingBeadOnASphereAndAPlaneKeepsItsPlace) {
  const double theta = 1.0;
  System system = scenes::make_rough_hoop(theta, "5*t", 5.0, 0.3, 0.3);
  const VectorFunction normal = std::get<Circles>(system.constraints[0]).normal;
  system.constraints = {Spheres{"ball", {0}, Vector3{}, R}, Planes{"disk", {0}, normal, 0.0}};
  std::get<Coulomb>(system.friction[0]).at = {"ball", "disk"};
  for (const Method method : {Method::Auto, Method::Rattle}) {
    MotionOptions options{.method = method};
    if (has_fixed_steps(method)) options.step = 0.01;
    Simulation simulation(system, options);
    ASSERT_TRUE(simulation.advance_to(20.0).ok()) << simulation.outcome().what;
    EXPECT_NEAR(angle(simulation), theta, 1e-12) << name_of(method);
    EXPECT_NEAR(simulation.positions()[0], R * std::sin(theta) * std::cos(100.0), 1e-12) << name_of(method);
  }
}

/// The guide's points move across it alone. A bead that sticks to a ball that grows keeps its direction. On a ball that
/// is carried off it keeps T'v = 0, R theta_dot = -c_dot.t.
TEST(RoughBall, StickingBeadGoesAcrossTheBall) {
  System system;
  const double a = 0.4;
  system.positions = {std::sin(a), 0.0, std::cos(a)};
  system.velocities = {0.3 * std::sin(a), 0.0, 0.3 * std::cos(a)};
  system.masses = {1.0};
  system.constraints = {Spheres{"ball", {0}, Vector3{}, ScalarFunction::formula("1+0.3*t")}};
  system.forces = {Gravity{"", {0.0, 0.0, -g}}};
  system.friction = {Coulomb{.name = "", .at = {"ball"}, .coefficient = 0.8}};
  for (const Method method : {Method::Auto, Method::Dopri5, Method::Rattle}) {
    MotionOptions options{.method = method};
    if (has_fixed_steps(method)) options.step = 0.01;
    Simulation simulation(system, options);
    ASSERT_TRUE(simulation.advance_to(10.0).ok()) << simulation.outcome().what;
    const auto r = simulation.positions();
    // The place along the ball holds to rounding. Across it constraints hold to 1e-13 of the radius, 4.
    EXPECT_NEAR(std::atan2(r[0], r[2]), a, 1e-14) << name_of(method);
    EXPECT_NEAR(std::hypot(r[0], r[2]), 4.0, 4e-13) << name_of(method);
  }
  // With c = (s, 0, 0), s = 0.2 sin t, theta_dot = -s_dot cos theta, so that gd^-1(theta) = gd^-1(a) - s, where
  // gd^-1(x) = asinh(tan x).
  system.velocities = {0.2 * std::sin(a) * std::sin(a), 0.0, 0.2 * std::sin(a) * std::cos(a)};
  system.constraints = {Spheres{"ball", {0}, VectorFunction{ScalarFunction::formula("0.2*sin(t)"), 0.0, 0.0}, 1.0}};
  for (const Method method : {Method::Auto, Method::Dopri5, Method::Rattle}) {
    MotionOptions options{.method = method};
    if (has_fixed_steps(method)) options.step = 0.01;
    Simulation simulation(system, options);
    ASSERT_TRUE(simulation.advance_to(10.0).ok()) << simulation.outcome().what;
    const double s = 0.2 * std::sin(10.0), theta = std::atan(std::sinh(std::asinh(std::tan(a)) - s));
    EXPECT_NEAR(simulation.positions()[0], s + std::sin(theta), 1e-12) << name_of(method);
    EXPECT_NEAR(simulation.positions()[2], std::cos(theta), 1e-12) << name_of(method);
  }
}

/// The place where a bead sticks is a part of the snapshot, so that the motion goes on bit by bit.
TEST(RoughHoop, ARestoredStickingBeadGoesOnBitByBit) {
  for (const Method method : {Method::Auto, Method::Dopri5, Method::Rk4}) {
    MotionOptions options{.method = method};
    if (has_fixed_steps(method)) options.step = 0.01;
    const System system = scenes::make_rough_hoop(1.0, "5*t", 5.0, 0.3, 0.3);
    Simulation whole(system, options), other(system, options);
    ASSERT_TRUE(whole.advance_to(3.7).ok());
    other.restore(whole.save());
    ASSERT_TRUE(whole.advance_to(10.0).ok());
    ASSERT_TRUE(other.advance_to(10.0).ok());
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(other.positions()[k], whole.positions()[k]) << name_of(method);
      EXPECT_EQ(other.velocities()[k], whole.velocities()[k]) << name_of(method);
    }
  }
}

TEST(RoughHoop, LeavesWhereTheHoopHasBecomeTooFast) {
  // With omega = 3.8 + a t, N has a part across the hoop, too.
  for (const double a : {0.2, 1.5}) {
    const double theta = 0.9, mu = 0.3;
    const std::string turn = "3.8*t + " + std::to_string(0.5 * a) + "*t^2";
    const long double instant = find_root(
        [&](long double t) { return excess(theta, 3.8L + static_cast<long double>(a) * t, a, mu); }, 0.0L, 20.0L);
    for (const Method method : sampled_methods) {
      MotionOptions options{.method = method, .rtol = 1e-11, .atol = 1e-13};
      if (has_fixed_steps(method)) options.step = 0.002;
      Simulation simulation(scenes::make_rough_hoop(theta, turn, 3.8, 0.25, mu), options);
      const std::vector<double> events = advance_and_list_events(&simulation, static_cast<double>(instant) + 0.05);
      ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
      ASSERT_EQ(events.size(), 1u) << name_of(method);
      EXPECT_NEAR(events[0], static_cast<double>(instant), 1e-10) << name_of(method);
      EXPECT_GT(angle(simulation), theta + 1e-4);
    }
  }
}

}  // namespace
}  // namespace tanor
