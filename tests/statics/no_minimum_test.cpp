/// Potentials that flatten have no equilibrium, however small their forces are far out. Yet a force that the start
/// cannot
/// see, as a soft floor far below, is no reason to deny one.

#include <cmath>

#include <gtest/gtest.h>
#include <tanor/equilibrium.hpp>

#include "scenes.hpp"

namespace tanor {
namespace {

using scenes::g;

System make_point(const Vector3& place, const std::string& energy) {
  System system;
  system.positions = {place[0], place[1], place[2]};
  system.masses = {1.0};
  system.forces = {Potential{.name = "field", .points = {{0}}, .kernel = formula_potential(energy, 1)}};
  return system;
}

TEST(Equilibrium, PotentialThatFlattensHasNoEquilibrium) {
  for (const char* energy : {"exp(-x1)+y1^2+z1^2", "exp(-x1)", "exp(-x1^2-y1^2-z1^2)", "1/x1+y1^2+z1^2"}) {
    const EquilibriumResult found = find_equilibrium(make_point({0.3, 0.1, 0.0}, energy));

    EXPECT_FALSE(found.outcome.ok()) << energy;
    EXPECT_EQ(found.stability.status, Stability::None) << energy;
  }
}

TEST(Equilibrium, ForceThatDiesAwayHasNoEquilibrium) {
  System system = make_point({0.1, 0.0, 0.0}, "y1^2+z1^2");
  system.forces.push_back(FormulaForce{.name = "push", .points = {0}, .kernel = formula_force({"exp(-x)", "0", "0"})});

  const EquilibriumResult found = find_equilibrium(system, {.accept = AcceptedEquilibria::Any});

  EXPECT_EQ(found.outcome.status, Status::NoSolution) << found.outcome.what;
  EXPECT_NE(found.outcome.what.find("forces die away"), std::string::npos) << found.outcome.what;
}

/// A rod of 1 m spans supports 3 m apart. With one of 3 m there is nothing to find, and all is well.
TEST(Equilibrium, SupportsThatViolateAConstraintAreNoEquilibrium) {
  System system;
  system.positions = {0.0, 0.0, 0.0, 3.0, 0.0, 0.0};
  system.masses = {1.0, 1.0};
  system.supports = {{"", {0, 1}, {}}};
  for (const double length : {1.0, 3.0}) {
    system.constraints = {Rods{"tie", {{0, 1}}, length}};

    const EquilibriumResult found = find_equilibrium(system);

    EXPECT_EQ(found.outcome.ok(), length == 3.0) << found.outcome.what;
    EXPECT_EQ(found.stability.status, length == 3.0 ? Stability::Stable : Stability::None);
    EXPECT_EQ(found.outcome.what.find("supports alone violate a constraint") != std::string::npos, length == 1.0);
  }
}

/// The charges screen each other and one of them is held: alone, and beside a pendulum whose forces are large.
TEST(Equilibrium, PointsThatRepelEachOtherHaveNoEquilibrium) {
  System system;
  system.positions = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0};
  system.masses = {1.0, 1.0};
  system.supports = {{"", {0}, {}}};
  system.forces = {PairForces{.points = {0, 1}, .law = PairLaw::Yukawa, .strength = 1.0, .length = 1.0}};
  System beside = system;
  beside.positions.insert(beside.positions.end(), {0.0, 5.0, 0.0, 0.0, 5.0, -1.0});
  beside.masses.insert(beside.masses.end(), {1.0, 1.0});
  beside.supports[0].points.push_back(2);
  beside.constraints = {Rods{"rod", {{2, 3}}}};
  beside.forces.push_back(Potential{.points = {{3}}, .kernel = formula_potential("9.81*z1", 1)});
  for (const System& each : {system, beside}) {
    const EquilibriumResult found = find_equilibrium(each);

    EXPECT_FALSE(found.outcome.ok());
    EXPECT_NE(found.stability.status, Stability::Stable);
    EXPECT_NE(found.stability.status, Stability::Marginal);
  }
}

/// Forces are finite where the search starts, and the message must not deny it.
TEST(Equilibrium, OppositeChargesThatMeetAreNamedAsTheEndOfTheSearch) {
  System system;
  system.positions = {0.630783487419836,   1.0393541232237575, 1.0309217445385483,   1.8178460987289433,
                      -0.3851893808502385, 0.5441771887526803, -0.36622168185723664, -1.4248485130063353,
                      -0.7038591205388717, 0.1361623384532617, -0.9151747291399203,  -0.19147101971894068};
  system.masses = {9.33, 2.12, 0.212, 0.616};
  system.forces = {
      Torsions{.quadruples = {{2, 3, 1, 0}}, .law = TorsionLaw::Harmonic, .stiffness = 1.77, .rest = -4.9999},
      PairForces{.points = {0, 1, 2, 3},
                 .law = PairLaw::Coulomb,
                 .strength = 1.234,
                 .charges = {0.8906605576581846, -0.013349239608598712, -0.9480166267677115, 1.3458677531896093}},
      Potential{.points = {{3}}, .kernel = formula_potential("4*((x1-0.5)^2+(y1+0.2)^2+(z1+1.16)^2)", 1)}};

  const EquilibriumResult found = find_equilibrium(system, {.accept = AcceptedEquilibria::Any});

  EXPECT_FALSE(found.outcome.ok());
  EXPECT_EQ(found.outcome.what.find("where it starts"), std::string::npos) << found.outcome.what;
  EXPECT_NE(found.outcome.what.find("no equilibrium was found: after "), std::string::npos) << found.outcome.what;
}

TEST(Equilibrium, SoftFloorIsFoundFromFarAboveAndFromBelow) {
  for (const double start : {50.0, 3.0, -20.0}) {
    System system = make_point({0.0, 0.0, start}, "exp(-z1)+x1^2+y1^2");
    system.add_gravity({0.0, 0.0, -g});

    const EquilibriumResult found = find_equilibrium(system);

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_NEAR(found.positions[2], -std::log(g), 1e-9);
    EXPECT_NEAR(found.stability.lowest_omega2, 2.0, 1e-9);
  }
}

TEST(Equilibrium, WellWithLinearWallsIsFoundFromItsWalls) {
  const EquilibriumResult found = find_equilibrium(make_point({-30.0, 0.0, 0.0}, "log(1+exp(x1))-0.5*x1+y1^2+z1^2"));

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_NEAR(found.positions[0], 0.0, 1e-8);
}

/// There is no stiffness at the kink or near it, so that no equilibrium is found to the tolerance, but the load does
/// not
/// pull without end either.
TEST(Equilibrium, KinkIsNotTakenForAPullWithoutEnd) {
  const EquilibriumResult found = find_equilibrium(make_point({0.0, 3.0, 0.0}, "abs(y1-1)+x1^2+z1^2"));

  EXPECT_EQ(found.outcome.status, Status::NotConverged) << found.outcome.what;
  EXPECT_EQ(found.outcome.what.find("without end"), std::string::npos) << found.outcome.what;
}

/// The stiffness of another part of the system, or of the same one, is no scale for what holds a bead.
TEST(Equilibrium, PendulumBesideStiffSpringsIsStable) {
  for (const double stiffness : {1e6, 1e8, 1e10}) {
    System system;
    system.positions = {0.0, 0.0, 0.0, 0.1, 0.0, -0.9, 5.0, 0.0, 0.0, 6.0, 0.2, 0.1};
    system.masses.assign(4, 1.0);
    system.supports = {{"", {0}, {}}};
    system.constraints = {Rods{"rod", {{0, 1}}}};
    system.forces = {Springs{.name = "stiff", .pairs = {{2, 3}}, .stiffness = stiffness, .rest_length = 1.0},
                     Potential{.points = {{1}}, .kernel = formula_potential("9.81*z1", 1)}};

    const EquilibriumResult found = find_equilibrium(system);

    ASSERT_TRUE(found.outcome.ok()) << stiffness << ": " << found.outcome.what;
    EXPECT_EQ(found.stability.status, Stability::Stable);
    EXPECT_EQ(found.stability.zero_modes, 5u);  // those of the spring, which floats
    EXPECT_EQ(found.stability.rigid_zero_modes, 5u);
    EXPECT_NEAR(found.stability.lowest_omega2, g / std::hypot(0.1, 0.9), 1e-6);
  }
}

}  // namespace
}  // namespace tanor
