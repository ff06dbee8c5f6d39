#include <gtest/gtest.h>

#include "scenes.hpp"

namespace tanor {
namespace {

void expect_finite_state(const Simulation& simulation) {
  EXPECT_TRUE(all_finite(simulation.positions()));
  EXPECT_TRUE(all_finite(simulation.velocities()));
  EXPECT_TRUE(all_finite(simulation.accelerations()));
  EXPECT_TRUE(all_finite(simulation.multipliers()));
  EXPECT_TRUE(all_finite(simulation.reactions()));
  EXPECT_TRUE(std::isfinite(simulation.report().energy.drift_relative()));
}

class FailuresTest : public testing::TestWithParam<Method> {
 protected:
  static MotionOptions options(double step) {
    MotionOptions result{.method = GetParam()};
    if (has_fixed_steps(GetParam())) result.step = step;
    return result;
  }
};

/// Makes a bead between two supports on rods that shorten. They are straight at t = 0.5 and too short afterwards.
///
///   |--- l(t) ---o--- l(t) ---|     1 m,  l = 0.75 - t/2
System make_impossible_at_half() {
  System system;
  scenes::add_point({0, 0, 0}, &system);
  scenes::add_point({1, 0, 0}, &system);
  scenes::add_point({0.5, 0, -std::sqrt(0.75 * 0.75 - 0.25)}, &system);
  system.supports = {{"walls", {0, 1}, {}}};
  system.constraints = {Rods{"ropes", {{0, 2}, {1, 2}}, ScalarFunction::formula("0.75 - 0.5*t"), {}}};
  system.forces = {scenes::gravity};
  return system;
}

TEST_P(FailuresTest, AGeometryThatBecomesImpossibleStopsAtTheLastGoodStep) {
  MotionOptions motion = options(1e-3);
  motion.start = StartMode::Project;
  Simulation simulation(make_impossible_at_half(), motion);
  ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;

  const Outcome outcome = simulation.advance_to(1.0);

  EXPECT_FALSE(outcome.ok());
  EXPECT_EQ(simulation.outcome().status, outcome.status);
  EXPECT_NE(outcome.what.find("t = 0."), std::string::npos) << outcome.what;
  EXPECT_GT(simulation.time(), 0.45);
  EXPECT_LE(simulation.time(), 0.5);
  EXPECT_EQ(simulation.report().time, simulation.time());
  EXPECT_LE(simulation.report().violation.position, 1e-11);
  expect_finite_state(simulation);
  EXPECT_EQ(simulation.advance_to(1.0).status, outcome.status) << "a failed simulation stays failed";
}

/// A force on a free bead grows like 1/(1 - t)^2. The run ends before the pole, in a finite state.
TEST_P(FailuresTest, ASingularForceEndsBeforeItsPole) {
  System system;
  scenes::add_point({0, 0, 0}, &system);
  system.forces = {ConstantForce{"pole", {0}, {ScalarFunction::formula("0.1/(1 - t)^2"), 0.0, 0.0}}};
  Simulation simulation(system, options(1.0 / 64));

  const Outcome outcome = simulation.advance_to(2.0);

  EXPECT_FALSE(outcome.ok());
  EXPECT_LE(simulation.time(), 1.0);
  EXPECT_GT(simulation.time(), 0.9);
  expect_finite_state(simulation);
}

INSTANTIATE_TEST_SUITE_P(Methods, FailuresTest, testing::ValuesIn(sampled_methods),
                         [](const auto& instance) { return std::string(name_of(instance.param)); });

/// Two beads of 0.1 kg, 1 m apart, attract each other with 0.1/D. With D'' = -2/D they meet at t = sqrt(pi)/2.
TEST(PairFailuresTest, BeadsThatFallIntoEachOtherEndWhereTheyMeet) {
  System system;
  scenes::add_point({0, 0, 0}, &system);
  scenes::add_point({1, 0, 0}, &system);
  system.forces = {PairForces{.law = PairLaw::Log, .strength = -0.1}};
  Simulation simulation(system, {.method = Method::Dopri5, .rtol = 1e-10, .atol = 1e-12});

  const Outcome outcome = simulation.advance_to(2.0);

  EXPECT_EQ(outcome.status, Status::StepTooSmall) << outcome.what;
  EXPECT_NEAR(simulation.time(), 0.5 * std::sqrt(M_PI), 1e-6);
  expect_finite_state(simulation);
}

/// Without an error estimate nothing keeps a step small.
class FixedStepFailuresTest : public FailuresTest {};

/// A chain that turns within a tenth of a second takes steps of ten seconds. Halving them does not lead back onto the
/// constraints.
TEST_P(FixedStepFailuresTest, AFarTooLargeStepIsAnOutcome) {
  Simulation simulation(scenes::make_chain(5), options(10.0));

  const Outcome outcome = simulation.advance_to(20.0);

  EXPECT_EQ(outcome.status, Status::NotConverged);
  EXPECT_NE(outcome.what.find("t = "), std::string::npos) << outcome.what;
  EXPECT_LT(simulation.time(), 20.0);
  EXPECT_GT(simulation.report().rejected, 0u);
  EXPECT_LE(simulation.report().violation.position, 1e-11);
  expect_finite_state(simulation);
}

/// A pendulum with a period of 0.6 s takes a step of 1 s. A failed attempt must not spoil the smaller ones.
TEST(SplitStepTest, AStepThatFailsIsTriedAgainInHalves) {
  Simulation simulation(scenes::make_pendulum(), {.method = Method::Rattle, .step = 1.0});

  const Outcome outcome = simulation.advance_to(1.0);

  EXPECT_TRUE(outcome.ok()) << outcome.what;
  EXPECT_GT(simulation.report().rejected, 0u);
  EXPECT_EQ(simulation.time(), 1.0);
  EXPECT_LE(simulation.report().violation.position, 1e-11);
}

/// Some halves of the first steps succeed before one fails.
TEST_P(FixedStepFailuresTest, AccelerationsAndMultipliersAreThoseOfTheLastGoodState) {
  Simulation simulation(scenes::make_chain(5), options(4.0));
  EXPECT_FALSE(simulation.advance_to(20.0).ok());
  ASSERT_GT(simulation.report().steps, 0u);
  Dynamics dynamics(simulation.system());
  std::vector<double> w(18), lambda(5);

  ASSERT_TRUE(
      dynamics
          .solve(
              {.time = simulation.time(), .positions = simulation.positions(), .velocities = simulation.velocities()},
              {.accelerations = w, .multipliers = lambda})
          .outcome.ok());

  EXPECT_LT(largest_difference(simulation.accelerations(), w), 1e-10 * largest(w));
  EXPECT_LT(largest_difference(simulation.multipliers(), lambda), 1e-10 * largest(lambda));
}

/// Far beyond the stable step the amplitude grows until it leaves the range of double.
TEST_P(FixedStepFailuresTest, ABlowUpIsNamedAndLeavesTheLastFiniteState) {
  System system;
  scenes::add_point({0, 0, 0}, &system);
  scenes::add_point({0, 0, -0.2}, &system);
  system.supports = {{"ceiling", {0}, {}}};
  system.forces = {Springs{"spring", {{0, 1}}, 1e6, 0.0, 0.1}};
  Simulation simulation(system, options(0.1));

  const Outcome outcome = simulation.advance_to(100.0);

  EXPECT_EQ(outcome.status, Status::NotFinite);
  EXPECT_NE(outcome.what.find("t = "), std::string::npos) << outcome.what;
  EXPECT_GT(simulation.report().steps, 0u);
  EXPECT_LT(simulation.time(), 100.0);
  expect_finite_state(simulation);
}

INSTANTIATE_TEST_SUITE_P(Methods, FixedStepFailuresTest, testing::Values(Method::Rk4, Method::Rattle),
                         [](const auto& instance) { return std::string(name_of(instance.param)); });

TEST(StartTest, ADoubledRodSwingsAsOneAndSharesItsLoad) {
  const System single = scenes::make_pendulum();
  System system = single;
  std::get<Rods>(system.constraints[0]).pairs.push_back({0, 1});
  // The series take other steps where K may lose rank.
  const MotionOptions options{.rtol = 1e-13, .atol = 1e-13};
  Simulation simulation(system, options), reference(single, options);

  ASSERT_TRUE(simulation.advance_to(0.5).ok()) << simulation.outcome().what;
  ASSERT_TRUE(reference.advance_to(0.5).ok());

  EXPECT_LT(largest_difference(simulation.positions(), reference.positions()), 1e-12);
  EXPECT_NEAR(simulation.multipliers()[0], 0.5 * reference.multipliers()[0], 1e-9);
  EXPECT_NEAR(simulation.multipliers()[1], 0.5 * reference.multipliers()[0], 1e-9);
  EXPECT_EQ(simulation.rank().rank, 1u);
}

}  // namespace
}  // namespace tanor
