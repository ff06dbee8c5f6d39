#include <array>

#include <gtest/gtest.h>

#include "scenes.hpp"

namespace tanor {
namespace {

class SupportsTest : public testing::TestWithParam<Method> {
 protected:
  static MotionOptions options() {
    MotionOptions result{.method = GetParam()};
    if (has_fixed_steps(GetParam())) result.step = 1.0 / 300;
    return result;
  }
};

TEST_P(SupportsTest, FixedSupportsDoNotMoveByABit) {
  System system = scenes::make_net(6, 6);
  system.velocities[0] = 7.0;  // what velocities say about supports is ignored
  Simulation simulation(system, options());

  for (int k = 1; k <= 20; ++k) {
    ASSERT_TRUE(simulation.advance_to(0.01 * k).ok());

    for (const Index corner : system.supports[0].points) {
      for (std::size_t i = 3 * static_cast<std::size_t>(corner); i < 3 * static_cast<std::size_t>(corner) + 3; ++i) {
        ASSERT_EQ(simulation.positions()[i], system.positions[i]);
        ASSERT_EQ(simulation.velocities()[i], 0.0);
        ASSERT_EQ(simulation.accelerations()[i], 0.0);
      }
    }
  }
}

/// Supports agree with their formula bit for bit at the time of the simulation, be it the end of a step or an output.
TEST_P(SupportsTest, MovingSupportsStandWhereTheirFormulaSays) {
  const System system = scenes::make_shaken_chain();
  const VectorFunction& displacement = system.supports[0].displacement;
  Simulation simulation(system, options());
  const auto expect_at_formula = [&] {
    const std::array<Jet<2>, 3> wanted = displacement(simulation.time());
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ASSERT_EQ(simulation.positions()[axis], system.positions[axis] + wanted[axis].value());
      ASSERT_EQ(simulation.velocities()[axis], wanted[axis].derivative(1));
      ASSERT_EQ(simulation.accelerations()[axis], wanted[axis].derivative(2));
    }
  };

  for (int k = 1; k <= 100; ++k) {
    ASSERT_TRUE(simulation.advance_to(0.007 * k).ok());
    expect_at_formula();
    ASSERT_TRUE(simulation.advance_to(1.0, scenes::stop_after(1)).ok());
    expect_at_formula();
    if (simulation.time() >= 0.007 * (k + 1)) break;
  }
  ASSERT_TRUE(simulation.advance_to(1.5).ok());
  expect_at_formula();
}

/// Two supports at a distance of sigma push each other by 24 epsilon/sigma (WCA) or by strength/sigma (log). A third
/// one lies where the first lies and makes no pair with it. The far bead feels next to nothing, and the energy stays.
TEST(SupportsTest, CarryTheirPairForcesOnEachOther) {
  for (const PairLaw law : {PairLaw::Wca, PairLaw::Log}) {
    System system;
    system.positions = {0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1e6, 0, 0};
    system.masses = {1, 1, 1, 1};
    system.supports = {{"", {0, 1}, {}}, {"hoist", {2}, {0.0, 0.0, 0.0}}};
    system.forces = {PairForces{.law = law, .epsilon = 2.0, .sigma = 0.5, .strength = 2.0}};
    const double push = law == PairLaw::Wca ? 24.0 * 2.0 / 0.5 : 2.0 / 0.5;
    Simulation simulation(system, {.method = Method::Dop853});
    ASSERT_TRUE(simulation.advance_to(0.1).ok()) << simulation.outcome().what;
    Dynamics dynamics(system);
    std::vector<double> load(12);
    ASSERT_TRUE(dynamics.solve({.time = 0.0, .positions = system.positions}, {.support_forces = load}).outcome.ok());

    for (const std::span<const double> carried : {simulation.support_forces(), std::span<const double>(load)}) {
      EXPECT_NEAR(carried[1], -push, 1e-5 * push);
      EXPECT_NEAR(carried[4], 2.0 * push, 1e-5 * push);
      EXPECT_NEAR(carried[7], -push, 1e-5 * push);
    }
    EXPECT_NEAR(simulation.report().energy.start, law == PairLaw::Wca ? 0.0 : -3.0 * 2.0 * std::log(1e6), 1e-9);
  }
}

/// A bead hangs on a support that is pulled up with 3 m/s^2 along a straight line, so that the rod carries m (g + 3).
TEST_P(SupportsTest, CarryWhatTheyAccelerate) {
  System system;
  scenes::add_point({0, 0, 0}, &system);
  scenes::add_point({0, 0, -0.1}, &system);
  system.supports = {{"hoist", {0}, {0.0, 0.0, ScalarFunction::formula("1.5*t^2")}}};
  system.constraints = {Rods{"rope", {{0, 1}}, 0.1, {}}};
  system.forces = {scenes::gravity};
  Simulation simulation(system, options());

  ASSERT_TRUE(simulation.advance_to(0.5).ok());

  EXPECT_NEAR(simulation.positions()[5], -0.1 + 1.5 * 0.25, 1e-12);
  EXPECT_NEAR(simulation.accelerations()[5], 3.0, 1e-12);
  EXPECT_NEAR(-simulation.multipliers()[0], 0.1 * (9.81 + 3.0), 1e-12);
  EXPECT_NEAR(simulation.support_forces()[2], -0.1 * (9.81 + 3.0), 1e-12);
}

/// Every method integrates x = x0 + v0 t + g t^2/2 without error.
TEST_P(SupportsTest, AFreePointFallsAlongItsParabola) {
  System system;
  scenes::add_point({1, 2, 3}, &system);
  system.velocities = {0.5, -1, 2};
  system.forces = {scenes::gravity};
  Simulation simulation(system, options());

  ASSERT_TRUE(simulation.advance_to(2.0).ok());

  const double wanted[]{1.0 + 0.5 * 2, 2.0 - 2.0, 3.0 + 2.0 * 2 - 0.5 * 9.81 * 4};
  EXPECT_LT(largest_difference(simulation.positions(), wanted), 1e-12);
  EXPECT_NEAR(simulation.velocities()[2], 2.0 - 9.81 * 2, 1e-12);
  EXPECT_EQ(simulation.plan().equations, 0u);
}

INSTANTIATE_TEST_SUITE_P(Methods, SupportsTest, testing::ValuesIn(sampled_methods),
                         [](const auto& instance) { return std::string(name_of(instance.param)); });

}  // namespace
}  // namespace tanor
