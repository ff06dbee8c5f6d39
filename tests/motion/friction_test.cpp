#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <tanor/tanor.hpp>

#include "rough_scenes.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

using scenes::g;

// ---- cases/04a: a rough incline ----

double along(const Simulation& simulation) {
  const auto r = simulation.positions();
  return r[0] * std::cos(std::numbers::pi / 6.0) - r[1] * std::sin(std::numbers::pi / 6.0);
}

TEST(RoughIncline, ABeadSlidesDownByTheClosedForm) {
  Simulation simulation(scenes::make_rough_incline(1.0, 0.3), {.rtol = 1e-10, .atol = 1e-12});
  ASSERT_TRUE(simulation.advance_to(2.0).ok()) << simulation.outcome().what;
  EXPECT_NEAR(simulation.positions()[0], 5.813260018694220418279570647, 1e-12);
  EXPECT_NEAR(simulation.positions()[1], -3.356287236662397062574362708, 1e-12);
  EXPECT_EQ(simulation.report().events, 0u);
  EXPECT_LE(std::abs(simulation.report().energy.drift_relative()), 1e-12);
}

TEST(RoughIncline, UphillItStopsAndStaysWhereMuIsAboveTheSlope) {
  const double mu = 0.7, alpha = std::numbers::pi / 6.0;
  const double a = g * (std::sin(alpha) + mu * std::cos(alpha)), stop = 1.0 / a;
  Simulation simulation(scenes::make_rough_incline(-1.0, mu), {.rtol = 1e-10, .atol = 1e-12});
  ASSERT_TRUE(simulation.advance_to(1.0).ok()) << simulation.outcome().what;
  EXPECT_EQ(simulation.report().events, 1u);
  EXPECT_NEAR(simulation.report().last_event, stop, 1e-13);
  EXPECT_NEAR(along(simulation), -0.5 / a, 1e-13);
  for (const double v : simulation.velocities()) EXPECT_NEAR(v, 0.0, 1e-16);
}

TEST(RoughIncline, UphillItStopsAndSlidesBackWhereMuIsBelowTheSlope) {
  // The time of the stop is uphill_stop_time of cases/04a.
  const double mu = 0.3, alpha = std::numbers::pi / 6.0, stop = 0.1341613276163089975121182181;
  const double back = g * (std::sin(alpha) - mu * std::cos(alpha));
  Simulation simulation(scenes::make_rough_incline(-1.0, mu), {.rtol = 1e-10, .atol = 1e-12});
  ASSERT_TRUE(simulation.advance_to(1.0).ok()) << simulation.outcome().what;
  EXPECT_EQ(simulation.report().events, 1u);
  EXPECT_NEAR(simulation.report().last_event, stop, 1e-13);
  EXPECT_NEAR(along(simulation), -0.5 * stop + 0.5 * back * (1.0 - stop) * (1.0 - stop), 1e-12);
  EXPECT_LE(std::abs(simulation.report().energy.drift_relative()), 1e-11);
  EXPECT_LT(simulation.report().energy.work_of_friction, 0.0);
}

TEST(RoughIncline, BelowTheFrictionAngleNothingCreepsInAHundredSeconds) {
  for (const Method method : sampled_methods) {
    MotionOptions options{.method = method};
    if (has_fixed_steps(method)) options.step = 0.01;
    Simulation simulation(scenes::make_rough_incline(0.0, 0.6), options);
    ASSERT_TRUE(simulation.advance_to(100.0).ok()) << simulation.outcome().what;
    EXPECT_NEAR(along(simulation), 0.0, 1e-13);
    for (const double v : simulation.velocities()) EXPECT_NEAR(v, 0.0, 1e-15);
  }
}

TEST(RoughIncline, ARegularisedLawCreepsAsItsVelocitySays) {
  // The speed obeys m g sin = mu m g cos v/sqrt(v^2 + v0^2), so that v = v0 p/sqrt(1 - p^2) with p = tan/mu.
  const double mu = 0.8, v0 = 1e-3, p = std::tan(std::numbers::pi / 6.0) / mu, v = v0 * p / std::sqrt(1.0 - p * p);
  System system = scenes::make_rough_incline(v, mu);
  std::get<Coulomb>(system.friction[0]).regularisation = v0;
  Simulation simulation(system, {.method = Method::Rk4, .step = 1e-4});
  ASSERT_TRUE(simulation.advance_to(0.5).ok()) << simulation.outcome().what;
  EXPECT_NEAR(along(simulation), 0.5 * v, 1e-12);
  EXPECT_EQ(simulation.report().events, 0u);
}

// ---- cases/04b: a rough circle ----

TEST(RoughCircle, SpeedDecaysByTheClosedForm) {
  System system;
  system.positions = {1.0, 0.0, 0.0};
  system.velocities = {0.0, 3.0, 0.0};
  system.masses = {1.0};
  system.constraints = {Circles{"wire", {0}, Vector3{}, Vector3{0.0, 0.0, 1.0}, 1.0}};
  system.friction = {Coulomb{.name = "", .at = {"wire"}, .coefficient = 0.2}};
  Simulation simulation(system, {.rtol = 1e-12, .atol = 1e-14});
  for (const double t : {1.0, 2.0, 5.0}) {
    ASSERT_TRUE(simulation.advance_to(t).ok()) << simulation.outcome().what;
    const double theta = std::log(1.0 + 0.6 * t) / 0.2, v = 3.0 / (1.0 + 0.6 * t);
    EXPECT_NEAR(simulation.positions()[0], std::cos(theta), 1e-10);
    EXPECT_NEAR(simulation.positions()[1], std::sin(theta), 1e-10);
    EXPECT_NEAR(simulation.velocities()[1], v * std::cos(theta), 1e-10);
  }
  EXPECT_LE(std::abs(simulation.report().energy.drift_relative()), 1e-10);
}

// ---- a block on a plane under a force that turns ----

System make_viscous_block(double mu_s, double mu, double omega) {
  System system;
  system.positions = {0.0, 0.0, 0.0};
  system.masses = {1.5};
  system.constraints = {Planes{"floor", {0}, Vector3{0.0, 0.0, 1.0}, 0.0}};
  const Constants constants{{"w", omega}};
  // The force of 12 N points straight down at first.
  const VectorFunction force{ScalarFunction::formula("12*sin(w*t)*0.6", constants),
                             ScalarFunction::formula("12*sin(w*t)*0.8", constants),
                             ScalarFunction::formula("-12*cos(w*t)", constants)};
  system.forces = {ConstantForce{"", {0}, force}};
  system.friction = {Coulomb{.name = "", .at = {"floor"}, .coefficient = mu, .static_coefficient = mu_s}};
  return system;
}

TEST(BlockOnAPlane, StartsToSlideWhereTheForceLeavesTheFrictionCone) {
  for (const double mu : {0.4, 0.25}) {
    const double mu_s = 0.4, omega = 0.7;
    Simulation simulation(make_viscous_block(mu_s, mu, omega), {.rtol = 1e-10, .atol = 1e-12});
    ASSERT_TRUE(simulation.advance_to(0.7).ok()) << simulation.outcome().what;
    EXPECT_EQ(simulation.report().events, 1u);
    EXPECT_NEAR(simulation.report().last_event, std::atan(mu_s) / omega, 1e-9);
    // The speed along (0.6, 0.8) is v = 12/m int (sin - mu cos) dt.
    const double t0 = std::atan(mu_s) / omega, t = 0.7;
    const double v = 12.0 / 1.5 / omega *
                     (-std::cos(omega * t) + std::cos(omega * t0) - mu * (std::sin(omega * t) - std::sin(omega * t0)));
    EXPECT_NEAR(simulation.velocities()[0], 0.6 * v, 1e-9);
    EXPECT_NEAR(simulation.velocities()[1], 0.8 * v, 1e-9);
  }
}

/// Four beads in a row on a rough line are joined by rods and drawn by 20 t. They leave together where the force is the
/// sum of all static limits, and not earlier where its share exceeds the limit of one bead.
TEST(RowOnALine, GivesWayAtTheSumOfItsStaticLimits) {
  const double mass[] = {1.0, 3.0, 2.0, 0.5}, mu[] = {0.2, 0.5, 0.3, 0.4}, mu_s[] = {0.3, 0.6, 0.5, 0.45};
  for (const bool is_weaker : {false, true}) {
    System system;
    Rods rods{"rods", {}, {}, {}};
    double M = 0.0, limit = 0.0, sliding = 0.0;
    for (int k = 0; k < 4; ++k) {
      const double x = k;
      system.positions.insert(system.positions.end(), {x, 0.0, 0.0});
      system.masses.push_back(mass[k]);
      const std::string name = "line" + std::to_string(k);
      system.constraints.push_back(Lines{name, {k}, Vector3{x, 0.0, 0.0}, Vector3{1.0, 0.0, 0.0}});
      Coulomb friction{.name = "", .at = {name}, .coefficient = mu[k]};
      if (is_weaker) friction.static_coefficient = mu_s[k];
      system.friction.push_back(friction);
      if (k > 0) rods.pairs.push_back({k - 1, k});
      M += mass[k];
      sliding += mu[k] * mass[k] * 10.0;
      limit += (is_weaker ? mu_s[k] : mu[k]) * mass[k] * 10.0;
    }
    system.velocities.assign(12, 0.0);
    system.constraints.push_back(rods);
    system.forces = {Gravity{"", {0.0, 0.0, -10.0}},
                     ConstantForce{"", {3}, VectorFunction{ScalarFunction::formula("20*t"), 0.0, 0.0}}};
    Simulation simulation(system, {.rtol = 1e-10, .atol = 1e-12});

    ASSERT_TRUE(simulation.advance_to(3.0).ok()) << simulation.outcome().what;

    // M v' = 20 t - sliding from t0 = limit/20 on. Beads at their limit are held until the force is 4e-6 above it,
    // which costs the difference of the coefficients for that long, or its square where they are equal.
    const double t0 = limit / 20.0, t = 3.0;
    const double v = (10.0 * (t * t - t0 * t0) - sliding * (t - t0)) / M;
    const double late = 5e-6 * t0 * (limit - sliding) / M;
    EXPECT_NEAR(simulation.velocities()[0], v, late + 1e-9);
    EXPECT_NEAR(simulation.report().last_event, t0, 1e-5);
  }
}

}  // namespace
}  // namespace tanor
