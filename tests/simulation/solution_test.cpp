/// The tests build systems point by point and take solutions as values.

#include <cmath>

#include <gtest/gtest.h>
#include <tanor/tanor.hpp>

namespace tanor {
namespace {

constexpr double g = 9.81;

struct HangingChain {
  System system;
  Point anchor, tip;
  std::vector<Member> rods;
};

/// Makes four rods of 0.5 m with beads of 0.2 kg, straight down.
HangingChain make_hanging_chain() {
  HangingChain chain;
  chain.anchor = chain.tip = chain.system.add_support({1.0, 2.0, 3.0});
  RodGroup rods = chain.system.add_rods("rods");
  for (int i = 1; i <= 4; ++i) {
    const Point bead = chain.system.add_point({.position = {1.0, 2.0 - 0.5 * i, 3.0}, .mass = 0.2});
    chain.rods.push_back(rods.join(chain.tip, bead));
    chain.tip = bead;
  }
  chain.system.add_gravity({0.0, -g, 0.0});
  return chain;
}

/// Rod k carries the beads below it.
void expect_weights(const HangingChain& chain, const Solution& solution) {
  ASSERT_TRUE(solution.outcome.ok()) << solution.outcome.what;
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_NEAR(solution.tension(chain.rods[k]), 0.2 * g * static_cast<double>(4 - k), 1e-13);
  EXPECT_NEAR(solution.load(chain.anchor)[1], -0.8 * g, 1e-13);
  EXPECT_NEAR(solution.reaction(chain.tip)[1], 0.2 * g, 1e-13);
  EXPECT_NEAR(solution.position(chain.tip)[1], 0.0, 1e-15);
  EXPECT_NEAR(solution.acceleration(chain.tip)[1], 0.0, 1e-13);
  EXPECT_LE(solution.position_violation, 1e-15);
}

TEST(Builder, AHangingChainCarriesItsWeight) {
  const HangingChain chain = make_hanging_chain();
  EXPECT_EQ(equation_name(chain.system, 2), "rods[2]");
  EXPECT_TRUE(chain.system.velocities.empty());
  Dynamics dynamics(chain.system);
  expect_weights(chain, dynamics.solution({.time = 0.0, .positions = chain.system.positions}));
  Simulation simulation(chain.system);
  ASSERT_TRUE(simulation.advance_to(0.1).ok());
  expect_weights(chain, simulation.solution());
  EXPECT_EQ(simulation.solution().time, 0.1);
}

TEST(Builder, VelocitiesMayBeginWithAnyPoint) {
  System system;
  (void)system.add_point({});
  (void)system.add_support({1.0, 0.0, 0.0}, VectorFunction(0.0, 0.0, ScalarFunction::formula("0.1*t")), "lift");
  const Point last = system.add_point({.position = {2.0, 0.0, 0.0}, .velocity = {0.0, 3.0, 0.0}, .mass = 2.0});
  EXPECT_EQ(system.velocities, (std::vector<double>{0, 0, 0, 0, 0, 0, 0, 3, 0}));
  EXPECT_EQ(system.masses, (std::vector<double>{1, 1, 2}));
  Simulation simulation(system);
  ASSERT_TRUE(simulation.advance_to(2.0).ok());
  const Solution end = simulation.solution();
  EXPECT_NEAR(end.position(last)[1], 6.0, 1e-12);
  EXPECT_NEAR(end.position({1})[2], 0.2, 1e-15);
  EXPECT_NEAR(end.velocity({1})[2], 0.1, 1e-15);
}

TEST(Solution, StaysWhatItWasWhenTheMotionGoesOn) {
  HangingChain chain = make_hanging_chain();
  chain.system.velocities.assign(chain.system.positions.size(), 0.0);
  chain.system.velocities[12] = 1.0;
  Simulation simulation(chain.system);
  const Solution start = simulation.solution();
  ASSERT_TRUE(simulation.advance_to(0.5).ok());
  EXPECT_EQ(start.position(chain.tip), (Vector3{1.0, 0.0, 3.0}));
  EXPECT_NE(simulation.solution().position(chain.tip), start.position(chain.tip));
}

/// There are groups before the one that is asked for, and groups of two rows a member.
TEST(Solution, MultipliersAreThoseOfTheirMembers) {
  System system;
  const Point bead = system.add_point({.position = {1.0, 0.0, 0.0}}), other = system.add_point({});
  system.constraints = {Lines{"wire", {other.index, bead.index}, Vector3{}, Vector3{1.0, 0.0, 0.0}}};
  const Member rod = system.add_rods("rods").join(bead, other);
  system.forces = {ConstantForce{.name = "pull", .points = {bead.index}, .force = Vector3{0.0, 0.0, -5.0}}};
  const Solution now = Dynamics(system).solution({.time = 0.0, .positions = system.positions});
  ASSERT_TRUE(now.outcome.ok());
  ASSERT_EQ(now.multipliers.size(), 5u);
  EXPECT_EQ(now.tension(rod), -now.multipliers[4]);
  EXPECT_EQ(now.multiplier({0, 1}, 1), now.multipliers[3]);
  EXPECT_NEAR(std::hypot(now.multiplier({0, 1}, 0), now.multiplier({0, 1}, 1)), 5.0, 1e-14);
}

TEST(Solution, UnknownPointsRodsAndRowsAreRefused) {
  const HangingChain chain = make_hanging_chain();
  Dynamics dynamics(chain.system);
  const Solution now = dynamics.solution({.time = 0.0, .positions = chain.system.positions});
  EXPECT_THROW((void)now.position({5}), InputError);
  EXPECT_THROW((void)now.position({}), InputError);
  EXPECT_THROW((void)now.tension({0, 4}), InputError);
  EXPECT_THROW((void)now.tension({1, 0}), InputError);
  EXPECT_THROW((void)now.multiplier({0, 0}, 1), InputError);
  System system;
  EXPECT_THROW((void)system.add_rods("rods")[0], InputError);
}

}  // namespace
}  // namespace tanor
