#include <gtest/gtest.h>

#include "scenes.hpp"

namespace tanor {
namespace {

constexpr std::size_t steps = 10'000;

/// Runs 1e4 steps of a chain of 5 with the given stabilisation.
Simulation run(Method method, Stabilisation stabilisation) {
  constexpr double step = 5e-4;
  Simulation simulation(scenes::make_chain(5), {.method = method, .step = step, .stabilisation = stabilisation});
  EXPECT_TRUE(simulation.advance_to(step * steps).ok());
  EXPECT_EQ(simulation.report().steps, steps);
  return simulation;
}

/// Violations of positions, and of velocities in m/s, which are computed independently.
struct MeasuredViolation {
  double position, velocity;
};

MeasuredViolation measure_violation(const Simulation& simulation) {
  Dynamics dynamics(simulation.system());
  return {dynamics.position_violation({.time = simulation.time(), .positions = simulation.positions()}),
          dynamics.velocity_violation(
              {.time = simulation.time(), .positions = simulation.positions(), .velocities = simulation.velocities()})};
}

void expect_on_constraints(const Simulation& simulation) {
  const MeasuredViolation violation = measure_violation(simulation);
  EXPECT_LE(violation.position, 1e-12);
  EXPECT_LE(violation.velocity, 1e-12);
  EXPECT_LE(simulation.report().violation.position, 1e-12);
  EXPECT_LE(simulation.report().violation.velocity, 1e-12);
}

TEST(ProjectionTest, HoldsTheConstraintsOver1e4Steps) {
  for (const Method method : {Method::Rk4, Method::Rattle}) {
    const Simulation simulation = run(method, Stabilisation::Projection);

    expect_on_constraints(simulation);
  }
}

TEST(ProjectionTest, ConstraintsDriftWithoutProjectionAndTheReportSaysSo) {
  const Simulation simulation = run(Method::Rk4, Stabilisation::None);

  const MeasuredViolation violation = measure_violation(simulation);
  EXPECT_GT(violation.position, 1e-9);
  EXPECT_GT(violation.velocity, 1e-9);
  EXPECT_GE(simulation.report().violation.position, violation.position);
  EXPECT_GT(simulation.report().violation.velocity, 1e-9);
}

TEST(ProjectionTest, HoldsTheConstraintsOfEveryKindOverALongRun) {
  for (const Method method : sampled_methods) {
    for (System (*build)() : {+[] { return scenes::make_beads(3); }, +[] { return scenes::make_shaken_chain(); },
                              +[] { return scenes::make_breathing_chain(); }}) {
      MotionOptions options{.method = method, .start = StartMode::Project};
      if (has_fixed_steps(method)) options.step = 1e-3;
      Simulation simulation(build(), options);

      ASSERT_TRUE(simulation.advance_to(3.0).ok());

      expect_on_constraints(simulation);
    }
  }
}

}  // namespace
}  // namespace tanor
