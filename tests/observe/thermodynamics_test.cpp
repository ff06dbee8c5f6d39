#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include <tanor/equilibrium.hpp>
#include <tanor/modes.hpp>
#include <tanor/motion.hpp>
#include <tanor/observables.hpp>

#include "observe/cable.hpp"

namespace tanor {
namespace {

double ask(const System& system, const std::string& text) {
  Simulation simulation(system);
  simulation.add_observable({.text = text});
  return simulation.observe()[0].values[0];
}

/// Expects 2 K/f from a motion and from the answer at one instant.
void expect_temperature(const System& system, double kinetic, double freedoms) {
  const double wanted = 2.0 * kinetic / freedoms;
  EXPECT_NEAR(ask(system, "temperature()"), wanted, 1e-12);
  const StateView at{.positions = system.positions, .velocities = system.velocities};
  Dynamics dynamics(system);
  const Observable asked{.text = "temperature()"};
  EXPECT_NEAR(observe(system, {&asked, 1}, dynamics.solution(at))[0].values[0], wanted, 1e-12);
  EXPECT_EQ(static_cast<double>(dynamics.rank(at).degrees_of_freedom), freedoms);
}

TEST(Thermodynamics, OpenRowsTakeNoFreedom) {
  System floor;
  floor.add_point({.position = {1.0, 1.0, 0.0}, .velocity = {1.0, 0.0, 0.0}, .mass = 1.0});
  floor.add_point({.position = {2.0, 2.0, 1.0}, .velocity = {0.0, 1.0, 0.0}, .mass = 1.0});
  floor.constraints.push_back(
      Planes{.name = "floor", .points = {0, 1}, .normal = Vector3{0, 0, 1}, .side = OneSide::AtLeast});
  floor.add_gravity({0.0, 0.0, -1.0});
  expect_temperature(floor, 1.0, 5.0);

  System rope;
  rope.add_support({0.0, 0.0, 0.0});
  rope.add_point({.position = {0.5, 0.0, 0.0}, .velocity = {1.0, 0.0, 0.0}, .mass = 1.0});
  rope.constraints.push_back(Ropes{.name = "rope", .paths = {{0, 1}}, .length = 1.0});
  expect_temperature(rope, 0.5, 3.0);
}

/// A double pendulum in the plane has two angles.
TEST(Thermodynamics, CoordinatesAloneAreTheFreedoms) {
  System system;
  const Point hook = system.add_support({0.0, 0.0, 0.0});
  const Point upper = system.add_point({.position = {1.0, 0.0, 0.0}, .velocity = {0.0, 0.0, 1.0}, .mass = 1.0});
  const Point lower = system.add_point({.position = {2.0, 0.0, 0.0}, .velocity = {0.0, 0.0, 2.0}, .mass = 1.0});
  system.coordinates.push_back(
      ChainAngles{.points = {upper.index, lower.index}, .anchor = hook.index, .normal = Vector3{0.0, 1.0, 0.0}});
  expect_temperature(system, 2.5, 2.0);
}

/// The middle of a line of rods between supports does not move; what hangs there swings.
System hang_on_a_line() {
  System system;
  const Point left = system.add_support({0.0, 0.0, 5.0}, {}, "left"), right = system.add_support({2.0, 0.0, 5.0});
  const Point middle = system.add_point({.position = {1.0, 0.0, 5.0}, .mass = 1.0});
  const Point bob = system.add_point({.position = {1.0, 0.0, 4.0}, .mass = 1.0});
  RodGroup rods = system.add_rods("rods");
  rods.join(left, middle);
  rods.join(middle, right);
  rods.join(middle, bob);
  system.forces.push_back(Gravity{"weight", {0.0, 0.0, -of_earth}});
  return system;
}

TEST(Thermodynamics, PointsThatPrestressHoldHaveNoFreedomButTheirWeight) {
  System system = hang_on_a_line();
  system.velocities.resize(system.positions.size());
  system.velocities[9] = 1.0;
  EXPECT_NEAR(ask(system, "temperature()"), 2.0 * 0.5 / 2.0, 1e-12);
  EXPECT_NEAR(ask(system, "potential()"), 9.0 * of_earth, 1e-12);
  EXPECT_NEAR(ask(system, "potential(weight)"), 9.0 * of_earth, 1e-12);
}

/// Breaks take no energy but that of springs: 9 g is that of the weights before and behind them, also of a point that
/// prestress held, and a constant force on it counts as its weight does.
TEST(Thermodynamics, BreaksLeaveTheEnergyOfWhatPrestressHeld) {
  System system = hang_on_a_line();
  system.forces.push_back(ConstantForce{.name = "lift", .points = {2}, .force = Vector3{0.0, 0.0, 1.0}});
  system.forces.push_back(Springs{.name = "spring", .pairs = {{0, 3}}, .stiffness = 8.0, .rest_length = 0.5});
  const double stretch = std::sqrt(2.0) - 0.5, wanted = 9.0 * of_earth - 5.0 + 4.0 * stretch * stretch;
  const double fall = 0.5;  // s after which all has broken
  Simulation simulation(system, {.rtol = 1e-12});
  for (const char* const text : {"energy()", "kinetic() + potential(weight) + potential(lift) + potential(spring)"})
    simulation.add_observable({.text = text});
  simulation.add_event({.when = "t > 0", .action = EventAction::Break, .of = "rods[0]"});
  simulation.add_event({.when = "t > 0", .action = EventAction::Break, .of = "spring"});
  simulation.add_event({.when = "t > 0.25", .action = EventAction::Break, .of = "rods[1]"});
  for (const Observed& each : simulation.observe()) EXPECT_NEAR(each.values[0], wanted, 1e-12) << each.name;

  ASSERT_TRUE(simulation.advance_to(fall).ok()) << simulation.outcome().what;

  EXPECT_NEAR(simulation.passages()[1].energy_lost, 4.0 * stretch * stretch, 1e-12);
  EXPECT_NEAR(simulation.report().energy.start, wanted, 1e-12);
  for (const Observed& each : simulation.observe())
    EXPECT_NEAR(each.values[0], wanted - 4.0 * stretch * stretch, 1e-9) << each.name;
}

/// Motion, one instant, rest and modes tell the same forces, and which one is the largest nobody knows.
TEST(Thermodynamics, EveryAnswerTellsTheSameForcesBesideAPrestress) {
  const System system = hang_on_a_line();
  const EquilibriumResult rest = find_equilibrium(system);
  ASSERT_TRUE(rest.outcome.ok());
  const Modes swinging = modes(system, rest.positions);
  ASSERT_TRUE(swinging.outcome.ok());
  Solution in_modes = state_at_rest(rest);
  in_modes.multipliers = swinging.multipliers;
  in_modes.reactions = swinging.reactions;
  in_modes.support_forces = swinging.support_forces;
  Simulation simulation(system);
  Dynamics dynamics(system);
  const std::vector<Observable> asked{
      {.text = "tension(rods)"}, {.text = "reaction(3)"}, {.text = "max tension(rods)"}, {.text = "load(left)"}};
  for (const Solution& at :
       {simulation.solution(), dynamics.solution({.positions = system.positions}), state_at_rest(rest), in_modes}) {
    const std::vector<Observed> found = observe(system, asked, at);
    EXPECT_TRUE(std::isnan(found[0].values[0]) && std::isnan(found[0].values[1]));
    EXPECT_NEAR(found[0].values[2], of_earth, 1e-9);
    EXPECT_NEAR(found[1].values[2], of_earth, 1e-9);
    EXPECT_TRUE(std::isnan(found[2].values[0]));
    EXPECT_EQ(found[2].member, "");
    EXPECT_TRUE(std::isnan(found[3].values[2]));
    for (const std::size_t k : {0u, 2u, 3u}) EXPECT_EQ(found[k].unknown, "left to a prestress") << k;
    EXPECT_EQ(at.accelerations[8], 0.0);
  }
}

/// An energy of points that prestress holds, and of no others, is a user's right.
TEST(Thermodynamics, EnergiesMayActOnHeldPointsAlone) {
  System system = hang_on_a_line();
  system.forces.push_back(Potential{.name = "pull", .points = {{2}}, .kernel = formula_potential("3*z1", 1)});
  const EquilibriumResult rest = find_equilibrium(system);
  EXPECT_TRUE(rest.outcome.ok()) << rest.outcome.what;
  EXPECT_NEAR(Dynamics(system).solution({.positions = system.positions}).multipliers[2], -of_earth, 1e-12);
  Simulation simulation(system);
  ASSERT_TRUE(simulation.advance_to(0.1).ok());
  EXPECT_NEAR(simulation.multipliers()[2], -of_earth, 1e-12);
}

/// The parts of accelerations and of reactions, and the certificate, belong to the same answer.
TEST(Thermodynamics, PartsAddUpWhereAPrestressHolds) {
  const System system = hang_on_a_line();
  const StateView at{.positions = system.positions};
  Dynamics dynamics(system);
  const Solution whole = dynamics.solution(at);
  const Split split = dynamics.split(at);
  const ReactionsByCause causes = dynamics.reactions_by_cause(at);
  ASSERT_TRUE(split.outcome.ok() && causes.outcome.ok());
  std::size_t num_known = 0;
  for (std::size_t i = 0; i < whole.reactions.size(); ++i) {
    EXPECT_NEAR(split.tangent_accelerations[i] + split.normal_accelerations[i], whole.accelerations[i], 1e-12) << i;
    double sum = 0.0;
    for (const ReactionPart& part : causes.parts) sum += part.reactions[i];
    EXPECT_EQ(std::isnan(sum), std::isnan(whole.reactions[i])) << i;
    if (std::isnan(sum) || i < 6) continue;  // supports
    EXPECT_NEAR(sum, whole.reactions[i], 1e-12) << i;
    num_known += whole.reactions[i] != 0.0 ? 1 : 0;
  }
  EXPECT_GT(num_known, 0u);
  EXPECT_TRUE(dynamics.certify(at).passed()) << dynamics.certify(at).line();
}

/// Prestress that is given decides, and modes tell the loads with it.
TEST(Thermodynamics, ModesTellTheLoadsOfTheirPrestress) {
  System system;
  const Point top = system.add_support({0.0, 0.0, 0.0}),
              middle = system.add_point({.position = {0.0, 0.0, -1.0}, .mass = 1.0}),
              foot = system.add_support({0.0, 0.0, -2.0});
  RodGroup rods = system.add_rods("rods");
  rods.join(top, middle);
  rods.join(middle, foot);
  const std::vector<Prestress> prestress{{.rods = "rods", .tensions = {50.0}}};
  EquilibriumOptions options;
  options.prestress = prestress;
  const EquilibriumResult rest = find_equilibrium(system, options);
  ASSERT_TRUE(rest.outcome.ok()) << rest.outcome.what;
  ModesOptions wanted;
  wanted.prestress = prestress;
  const Modes found = modes(system, rest.positions, wanted);
  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  for (std::size_t k = 0; k < 9; ++k) {
    EXPECT_NEAR(found.support_forces[k], rest.support_forces[k], 1e-9) << k;
    EXPECT_NEAR(found.reactions[k], rest.reactions[k], 1e-9) << k;
  }
  EXPECT_NEAR(rest.support_forces[2], -50.0, 1e-9);
}

/// Rods between supports carry nothing, and loads are known there.
TEST(Thermodynamics, RodsBetweenSupportsCarryNothing) {
  System system;
  const Point left = system.add_support({0.0, 0.0, 0.0}), right = system.add_support({1.0, 0.0, 0.0}),
              bob = system.add_point({.position = {1.0, 0.0, -1.0}, .mass = 1.0});
  RodGroup rods = system.add_rods("rods");
  rods.join(left, right);
  rods.join(right, bob);
  system.add_gravity({0.0, 0.0, -of_earth});
  const EquilibriumResult rest = find_equilibrium(system);
  EXPECT_EQ(rest.multipliers[0], 0.0);
  EXPECT_NEAR(rest.support_forces[5], -of_earth, 1e-9);
  EXPECT_EQ(rest.multipliers_unique, (std::vector<bool>{false, true}));
  Simulation simulation(system);
  EXPECT_EQ(simulation.multipliers()[0], 0.0);
}

System two_in_a_box() {
  System system;
  system.cell = Cell{.xx = 5.0, .yy = 5.0, .zz = 5.0};
  system.add_point({.position = {1.0, 1.0, 1.0}, .mass = 1.0});
  system.add_point({.position = {2.0, 2.0, 3.0}, .mass = 1.0});
  return system;
}

TEST(Thermodynamics, EnergiesFromOutsideHaveNoPressure) {
  System system = two_in_a_box();
  system.forces.push_back(Potential{.points = {{0}, {1}}, .kernel = formula_potential("9.81*z1", 1)});
  EXPECT_EQ(ask(system, "pressure()"), 0.0);
}

/// Two points are pulled apart along z: a rod, a rope, a formula of two points as a constraint and as a force press
/// alike.
TEST(Thermodynamics, WhatJoinsPointsHasTheSamePressure) {
  System pulled = two_in_a_box();
  pulled.forces.push_back(ConstantForce{.points = {0}, .force = {0.0, 0.0, -1.0}});
  pulled.forces.push_back(ConstantForce{.points = {1}, .force = {0.0, 0.0, 1.0}});
  System rod = pulled, rope = pulled, formula = pulled;
  rod.constraints.push_back(Rods{.pairs = {{0, 1}}});
  rope.constraints.push_back(Ropes{.paths = {{0, 1}}});
  formula.constraints.push_back(UserConstraints{
      .tuples = {{0, 1}}, .kernel = formula_constraint("sqrt((x1-x2)^2+(y1-y2)^2+(z1-z2)^2)-sqrt(6)", 2)});
  const double wanted = -(2.0 / std::sqrt(6.0)) * std::sqrt(6.0) / (3.0 * 125.0);  // tension, length, 3 V
  for (const System* each : {&rod, &rope, &formula}) EXPECT_NEAR(ask(*each, "pressure()"), wanted, 1e-12);
}

/// Reading the multipliers of a motion changes no reason, and other observables have theirs.
TEST(Thermodynamics, AReasonStaysAfterALookAtMultipliers) {
  System system;
  const Point hook = system.add_support({0.0, 0.0, 0.0}), upper = system.add_point({.position = {0.0, 0.0, -1.0}}),
              lower = system.add_point({.position = {0.0, 0.0, -2.0}});
  RodGroup rods = system.add_rods("rods");
  rods.join(hook, upper);
  rods.join(upper, lower);
  system.add_gravity({0.0, 0.0, -of_earth});
  Simulation simulation(system);
  simulation.add_observable({.text = "tension(rods)"});
  simulation.add_event({.when = "t > 0.1", .action = EventAction::Break, .of = "rods[1]"});
  ASSERT_TRUE(simulation.advance_to(0.2).ok());
  EXPECT_TRUE(std::isnan(simulation.multipliers()[1]));
  EXPECT_EQ(simulation.observe()[0].unknown, "rods[1] broken at t = 0.1");
  const Observable other{.text = "tension(rods[1])"};
  EXPECT_EQ(simulation.observe(std::span(&other, 1))[0].unknown, "broken at t = 0.1");
  simulation.add_observable({.text = "tension(rods[1]) - tension(rods[1])"});
  EXPECT_EQ(simulation.observe()[1].unknown, "rods[1] broken at t = 0.1") << "told once";
}

}  // namespace
}  // namespace tanor
