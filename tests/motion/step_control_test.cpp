#include <gtest/gtest.h>

#include "motion/step_control.hpp"
#include "scenes.hpp"

namespace tanor {
using namespace detail;
namespace {

/// Returns the error at t = 0.5 against a much finer run.
double measure_error(double rtol) {
  const auto run = [](double tolerance) {
    Simulation simulation(scenes::make_chain(3),
                          {.method = Method::Dopri5, .rtol = tolerance, .atol = 0.01 * tolerance});
    EXPECT_TRUE(simulation.advance_to(0.5).ok());
    return std::vector<double>(simulation.positions().begin(), simulation.positions().end());
  };
  return largest_difference(run(rtol), run(1e-13));
}

TEST(ToleranceTest, ErrorFollowsTheTolerance) {
  double before = measure_error(1e-4);
  for (const double rtol : {1e-6, 1e-8, 1e-10}) {
    const double error = measure_error(rtol);
    EXPECT_LT(error, rtol);
    EXPECT_NEAR(std::log10(before / error), 2.0, 0.7) << rtol;
    before = error;
  }
}

/// In x'' = c t^3 the estimate of v is of order 4 and sees no error; the estimate of x does.
TEST(ToleranceTest, PositionsAreHeldToTheTolerance) {
  System system;
  scenes::add_point({0, 0, 0}, &system);
  system.forces = {ConstantForce{"push", {0}, {ScalarFunction::formula("1e3*t^3"), 0.0, 0.0}}};
  Simulation simulation(system, {.method = Method::Dopri5, .rtol = 1e-10, .atol = 1e-12});

  ASSERT_TRUE(simulation.advance_to(1.0).ok());

  EXPECT_GT(simulation.report().steps, 50u);
  EXPECT_NEAR(simulation.positions()[0], 1e4 / 20, 1e-8);
}

/// Makes a bead of 0.1 kg on a spring of 1e7 N/m that swings with 1e4 rad/s. A step of the size that the fall alone
/// would allow has to be rejected.
System make_stiff_spring() {
  System system;
  scenes::add_point({0, 0, 0}, &system);
  scenes::add_point({0, 0, -0.1}, &system);
  system.supports = {{"ceiling", {0}, {}}};
  system.forces = {scenes::gravity, Springs{"spring", {{0, 1}}, 1e7, 0.0, 0.1}};
  return system;
}

TEST(StepControlTest, AStiffSpringIsIntegratedByRejectingSteps) {
  Simulation simulation(make_stiff_spring(), {.method = Method::Dopri5, .rtol = 1e-6, .atol = 1e-9});

  const Outcome outcome = simulation.advance_to(0.05);

  EXPECT_TRUE(outcome.ok()) << outcome.what;
  EXPECT_GT(simulation.report().rejected, 0u);
  EXPECT_TRUE(all_finite(simulation.positions()));
  EXPECT_NEAR(simulation.positions()[5], -0.1, 1e-6);
}

/// Nothing but the end limits the step at rest, and the first step must not be 0 or NaN.
TEST(StepControlTest, ASystemAtRestIsDoneInFewSteps) {
  System system = scenes::make_pendulum();
  system.positions = {0, 0, 0, 0, 0, -0.1};
  Simulation simulation(system);

  ASSERT_TRUE(simulation.advance_to(10.0).ok());

  EXPECT_LT(simulation.report().steps, 30u);
  EXPECT_EQ(simulation.velocities()[5], 0.0);
}

TEST(StepControlTest, AShortLastStepCostsAFewMoreSteps) {
  const MotionOptions options{.method = Method::Dopri5, .rtol = 1e-8, .atol = 1e-10};
  Simulation free(scenes::make_chain(3), options), cut(scenes::make_chain(3), options);

  ASSERT_TRUE(free.advance_to(1.0).ok());
  ASSERT_TRUE(cut.advance_to(0.5).ok());
  ASSERT_TRUE(cut.advance_to(0.5 + 1e-7).ok());
  ASSERT_TRUE(cut.advance_to(1.0).ok());

  EXPECT_LE(cut.report().steps, free.report().steps + 12);
}

TEST(StepControlTest, StaysWithinItsBounds) {
  StepControl control(5);

  EXPECT_LE(control.accept(0.0), 5.0);
  EXPECT_GE(control.accept(1.0), 0.2);
  EXPECT_LE(control.reject(1.0 + 1e-12), 0.9);
  EXPECT_GE(control.reject(1e300), 0.1);
  EXPECT_LE(control.accept(1e-8), 1.0) << "no growth right after a rejection";
  EXPECT_GT(control.accept(1e-8), 1.0);
}

}  // namespace
}  // namespace tanor
