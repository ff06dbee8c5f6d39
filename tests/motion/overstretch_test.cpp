/// Motions that come to where an energy ends: the step is rejected, and the run ends and names the tuple and the time.

#include <cmath>
#include <string>

#include <gtest/gtest.h>
#include <tanor/motion.hpp>
#include <tanor/user_kernel.hpp>

#include "methods.hpp"

namespace tanor {
namespace {

/// Makes a bead on the x axis that a rod holds at one support. A bond leads to another support that moves away, so that
/// r = 1 + t/2.
System make_pulled_bond(const Force& bond) {
  System system;
  system.positions = {0, 0, 0, 1, 0, 0, 2, 0, 0};
  system.velocities.assign(9, 0.0);
  system.masses = {1, 1, 1};
  VectorFunction away;
  away.components[0] = ScalarFunction::formula("t/2");
  system.supports = {Support{"held", {0}, {}}, Support{"pull", {2}, away}};
  system.constraints = {Rods{"rod", {{0, 1}}}};
  system.forces = {bond};
  return system;
}

class Overstretch : public testing::TestWithParam<Method> {};

TEST_P(Overstretch, ABondBeyondItsLimitEndsTheRunWithItsPointsAndTheTime) {
  const Bonds bond{"fene", {{1, 2}}, BondLaw::Fene, 5.0, {}, 1.5, {}, {}};
  MotionOptions options{.method = GetParam(), .rtol = 1e-8};
  if (GetParam() == Method::Rattle) options = {.method = Method::Rattle, .step = 0.01};
  Simulation simulation(make_pulled_bond(bond), options);

  const Outcome outcome = simulation.advance_to(2.0);

  ASSERT_FALSE(outcome.ok());
  EXPECT_NE(outcome.what.find("fene: [1, 2]: the distance 1.5"), std::string::npos) << outcome.what;
  EXPECT_NE(outcome.what.find("is not below the limit 1.5 at t = "), std::string::npos) << outcome.what;
  EXPECT_NEAR(simulation.time(), 1.0, 0.02);
  for (const double x : simulation.positions()) EXPECT_TRUE(std::isfinite(x));
}

INSTANTIATE_TEST_SUITE_P(Methods, Overstretch,
                         testing::Values(Method::Dopri5, Method::Dop853, Method::Taylor, Method::Radau5,
                                         Method::Rattle),
                         [](const auto& instance) { return std::string(name_of(instance.param)); });

/// Where two points fall onto each other, forces are finite until they meet.
TEST(Collision, NamesThePairUnderAnUnboundPull) {
  PairForces coulomb{.name = "pull", .law = PairLaw::Coulomb, .strength = 1.0, .charges = {1, -1, 1}};
  PairForces yukawa{.name = "pull", .law = PairLaw::Yukawa, .strength = -1.0, .length = 0.7};
  for (const PairForces& pull : {coulomb, yukawa}) {
    for (const Method method : {Method::Dop853, Method::Dopri5, Method::Radau5}) {
      System system;
      system.positions = {0, 0, 0, 1, 0, 0, 30, 0, 0};
      system.velocities.assign(9, 0.0);
      system.masses = {1, 1, 1};
      system.forces = {pull};
      Simulation simulation(system, {.method = method, .rtol = 1e-8});

      const Outcome outcome = simulation.advance_to(3.0);

      ASSERT_FALSE(outcome.ok()) << name_of(method);
      EXPECT_NE(outcome.what.find("pull: points 0 and 1, which are "), std::string::npos) << outcome.what;
      EXPECT_NE(outcome.what.find(" apart, fall onto each other"), std::string::npos) << outcome.what;
    }
  }
}

/// Within its limit the same bond swings for good and keeps its energy.
TEST(FeneBond, SwingsBelowItsLimit) {
  System system = make_pulled_bond(Bonds{"fene", {{1, 2}}, BondLaw::Fene, 5.0, {}, 1.5, {}, {}});
  system.supports = {Support{"held", {0}, {}}};
  system.constraints.clear();
  system.velocities = {0, 0, 0, -1.2, 0, 0, 1.2, 0, 0};
  Simulation simulation(system, {.method = Method::Taylor, .rtol = 1e-12, .atol = 1e-14});

  ASSERT_TRUE(simulation.advance_to(20.0).ok());

  EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), 1e-10);
}

/// An energy that depends on time does the work of its explicit dU/dt, here in a well of k(t) = 1 + t/2 + sin(3 t)/5.
TEST(WorkOfPotentials, IsTheIntegralOfTheExplicitRate) {
  System system;
  system.positions = {0.3, 0, 0};
  system.velocities = {0.2, 0, 0};
  system.masses = {2.0};
  system.forces = {Potential{"well", {{0}}, formula_potential("(1 + 0.5*t + 0.2*sin(3*t))*x1^2/2", 1), {}}};
  for (const Method method : list_adaptive_methods()) {
    Simulation simulation(system, {.method = method, .rtol = 1e-11, .atol = 1e-13});

    ASSERT_TRUE(simulation.advance_to(3.0).ok());

    const EnergyReport& energy = simulation.report().energy;
    EXPECT_EQ(energy.work_of_forces, 0.0);
    EXPECT_EQ(energy.now, energy.kinetic + energy.potential);
    EXPECT_GT(std::abs(energy.work_of_potentials), 1e-3);
    EXPECT_NEAR(energy.now - energy.start, energy.work_of_potentials, 1e-9) << name_of(method);
  }
}

/// A few smooth pairs have series and a Hessian. Each kind of method steps them, and to the same positions.
TEST(SmoothPairs, AllKindsOfMethodsAgree) {
  System system;
  system.positions = {0, 0, 0, 1, 0.1, 0, 0.2, 1.1, 0.3, -0.7, 0.4, 0.9};
  system.velocities.assign(12, 0.0);
  system.masses = {1, 2, 1, 3};
  system.constraints = {Rods{"rod", {{0, 1}}}};
  for (const PairForces& pairs : {PairForces{.law = PairLaw::Coulomb, .strength = 1.0, .charges = {1, 1, 2, 1}},
                                  PairForces{.law = PairLaw::Yukawa, .strength = 2.0, .length = 0.7},
                                  PairForces{.law = PairLaw::Morse, .depth = 1.0, .width = 1.5, .rest_length = 1.0}}) {
    system.forces = {pairs};
    Simulation reference(system, {.method = Method::Dop853, .rtol = 1e-12, .atol = 1e-14});
    ASSERT_TRUE(reference.advance_to(1.0).ok());
    for (const Method method : {Method::Taylor, Method::Radau5}) {
      Simulation simulation(system, {.method = method, .rtol = 1e-11, .atol = 1e-13});
      ASSERT_TRUE(simulation.advance_to(1.0).ok());
      for (std::size_t i = 0; i < 12; ++i)
        EXPECT_NEAR(simulation.positions()[i], reference.positions()[i], 1e-9) << name_of(method);
      EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), 1e-9);
    }
  }
}

/// Forces of tuples that read velocities and time have series and derivatives, and what they do is work. Dampers join a
/// point to two others, and a force that depends on time drags a point along with a support.
TEST(ForcesOnTuples, AllKindsOfMethodsAgree) {
  System system;
  system.positions = {0, 0, 0, 1, 0.1, 0, 0.2, 1.1, 0.3, -0.7, 0.4, 0.9};
  system.velocities = {0, 0.3, 0, 0.05, -0.2, 0.4, 0.5, 0, 0, 0, 0, 0};
  system.masses = {1, 2, 1, 3};
  system.supports = {Support{"", {3}, {}}};
  system.constraints = {Rods{"rod", {{0, 1}}}};
  const std::vector<std::string> damper{"5*(vx2 - vx1)", "5*(vy2 - vy1)", "5*(vz2 - vz1)",
                                        "5*(vx1 - vx2)", "5*(vy1 - vy2)", "5*(vz1 - vz2)"};
  const std::vector<std::string> drag{"0", "sin(2*t)*(x2 - x1)", "0", "x1*y2", "-(1 + t)*y2", "-z2 + vz1"};
  system.forces = {
      FormulaForce{.name = "damper", .points = {}, .kernel = formula_tuple_force(damper), .tuples = {{0, 2}, {1, 2}}},
      FormulaForce{.name = "drag", .points = {}, .kernel = formula_tuple_force(drag), .tuples = {{3, 0}}}};
  Simulation reference(system, {.method = Method::Dop853, .rtol = 1e-12, .atol = 1e-14});
  ASSERT_TRUE(reference.advance_to(1.0).ok());
  for (const Method method : {Method::Taylor, Method::Radau5}) {
    Simulation simulation(system, {.method = method, .rtol = 1e-11, .atol = 1e-13});
    ASSERT_TRUE(simulation.advance_to(1.0).ok());
    for (std::size_t i = 0; i < 12; ++i)
      EXPECT_NEAR(simulation.positions()[i], reference.positions()[i], 1e-9) << name_of(method);
    EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), 1e-8) << name_of(method);
  }
  // The support carries the force of the tuple on it, (0, sin(2 t) (x2 - x1), 0).
  const auto r = reference.positions();
  EXPECT_NEAR(reference.support_forces()[10], std::sin(2.0) * (r[0] - r[9]), 1e-12);
}

// ---- angles at which a law has no force, where the points are in line ----

/// Makes four free points, the last of which crosses the line of the two before it at the distance `beside`.
System make_torsion(double beside) {
  System system;
  system.positions = {0, 1, 0, 0, 0, 0, 1, 0, 0, 2, 0.3, beside};
  system.velocities = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0};
  system.masses.assign(4, 1.0);
  system.forces = {Torsions{.name = "hinge", .quadruples = {{0, 1, 2, 3}}, .coefficients = {1, 1, 1, 1}}};
  return system;
}

/// Makes three free points whose angle opens to pi and beyond.
System make_bending(double rest, double beside = 0.0) {
  System system;
  system.positions = {-1, 0.3, beside, 0, 0, 0, 1, 0.3, beside};
  system.velocities = {0, -1, 0, 0, 2, 0, 0, -1, 0};
  system.masses.assign(3, 1.0);
  system.forces = {Bendings{.name = "knee", .triples = {{0, 1, 2}}, .stiffness = 1.0, .rest = rest}};
  return system;
}

void expect_end(const System& system, double at, const std::string& wanted) {
  for (const Method method : list_adaptive_methods()) {
    Simulation simulation(system, {.method = method});
    const Outcome outcome = simulation.advance_to(1.0);
    EXPECT_FALSE(outcome.ok()) << name_of(method);
    EXPECT_NE(outcome.what.find(wanted), std::string::npos) << name_of(method) << ": " << outcome.what;
    EXPECT_NEAR(simulation.time(), at, 1e-2) << name_of(method);
  }
}

TEST(AngleEnds, ADihedralThatEndsStopsTheMotion) {
  expect_end(make_torsion(0.0), 0.3,
             "hinge: [0, 1, 2, 3]: its last three points are on a straight line: there is no dihedral");
}

TEST(AngleEnds, TheTipOfABendingStopsTheMotion) {
  expect_end(make_bending(2.0), 0.1, "knee: [0, 1, 2]: its angle is straight, where the force of law harmonic has no");
}

/// The energy has no tip where all angles rest straight.
TEST(AngleEnds, AChainThatRestsStraightPassesTheLine) {
  for (const Method method : list_adaptive_methods()) {
    Simulation simulation(make_bending(std::acos(-1.0)), {.method = method, .rtol = 1e-9});
    ASSERT_TRUE(simulation.advance_to(1.0).ok()) << name_of(method) << ": " << simulation.outcome().what;
    EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), 1e-7) << name_of(method);
  }
}

/// At a small distance from the line the forces are great and short, and the motion goes on.
TEST(AngleEnds, PassingBesideTheLineIsResolved) {
  // The valley of the torsion focuses: a point that comes in at the distance z from its line passes it at about z².
  for (const double beside : {1e-2, 1e-3}) {
    for (const System& system : {make_torsion(beside), make_bending(2.0, beside)}) {
      for (const Method method : {Method::Taylor, Method::Dop853}) {
        Simulation simulation(system, {.method = method, .rtol = 1e-8});
        ASSERT_TRUE(simulation.advance_to(1.0).ok()) << name_of(method) << ": " << simulation.outcome().what;
        EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), 1e-6)
            << name_of(method) << ", " << force_name(system, 0) << " " << beside;
      }
    }
  }
}

}  // namespace
}  // namespace tanor
