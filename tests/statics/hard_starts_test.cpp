/// Newton's linear model leads nowhere from these starts: rods that are much too short, bodies whose rods pull each
/// other
/// much harder than the load, motions that cost nothing, and configurations that only look like equilibria.

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <tanor/equilibrium.hpp>

#include "scenes.hpp"

namespace tanor {
namespace {

/// Makes rods of `length` between supports `chord` apart, on a straight line but for the shift of the first support.
System make_slack_chain(int count, double length, double chord, const Vector3& first) {
  System system;
  Rods rods{"rods"};
  rods.length.constants = {length};
  for (int i = 0; i <= count; ++i) {
    scenes::add_point({chord * i / count, 0.0, 0.0}, &system);
    if (i > 0) rods.pairs.push_back({i - 1, i});
  }
  for (std::size_t axis = 0; axis < 3; ++axis) system.positions[axis] += first[axis];
  system.constraints = {rods};
  system.supports = {{"", {0, count}, {}}};
  system.forces = {scenes::gravity};
  return system;
}

TEST(Equilibrium, SlackChainIsFoundFromAStraightLine) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> aside(-0.05, 0.05);
  for (const int count : {2, 3, 7, 20, 29}) {
    for (const double slack : {1.001, 1.05, 1.3, 2.0, 4.0}) {
      for (const bool is_bent : {false, true}) {
        const Vector3 first = is_bent ? Vector3{aside(random), aside(random), aside(random)} : Vector3{};
        const double chord = std::hypot(1.0 - first[0], first[1], first[2]);

        const EquilibriumResult found = find_equilibrium(make_slack_chain(count, chord * slack / count, 1.0, first));

        ASSERT_TRUE(found.outcome.ok()) << count << " rods, slack " << slack << ": " << found.outcome.what;
        EXPECT_EQ(found.stability.status, Stability::Stable);
        EXPECT_LE(found.residual_force, 1e-10 * found.largest_force);
        EXPECT_LE(found.violation, 1e-11);
        EXPECT_LT(found.search.iterations, 200);
      }
    }
  }
}

TEST(Equilibrium, RingHungAtOnePointIsFoundFromACircle) {
  for (const int count : {30, 61, 100}) {
    System ring;
    Rods rods{"rods"};
    for (int i = 0; i < count; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / count;
      scenes::add_point({std::cos(angle), 0.0, std::sin(angle)}, &ring);
      rods.pairs.push_back({i, (i + 1) % count});
    }
    ring.constraints = {rods};
    ring.supports = {{"", {0}, {}}};
    ring.forces = {scenes::gravity};

    const EquilibriumResult found = find_equilibrium(ring);

    ASSERT_TRUE(found.outcome.ok()) << count << ": " << found.outcome.what;
    EXPECT_EQ(found.stability.status, Stability::Stable);
  }
}

/// Each point hangs on three others by rods, which pull and push each other a hundred times as hard as its weight.
TEST(Equilibrium, RigidBodyHungAtAPointTakesFewSteps) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  int slow = 0, missed = 0;
  for (int body = 0; body < 60; ++body) {
    System system;
    Rods rods{"rods"};
    const int count = 5 + body % 4;
    for (int i = 0; i < count; ++i) {
      scenes::add_point({normal(random), normal(random), normal(random)}, &system);
      for (int j = 0; j < std::min(i, 3); ++j) rods.pairs.push_back({j, i});
    }
    system.constraints = {rods};
    system.supports = {{"", {0}, {}}};
    system.forces = {Gravity{"", {3.0 * normal(random), 9.81, 3.0 * normal(random)}}};

    const EquilibriumResult found = find_equilibrium(system);

    ASSERT_TRUE(found.outcome.ok()) << "body " << body << ": " << found.outcome.what;
    EXPECT_EQ(found.stability.status, Stability::Stable) << "body " << body;
    if (found.stability.zero_modes != 1u || found.stability.rigid_zero_modes != 1u) ++missed;
    if (found.search.iterations > 100) ++slow;
  }
  // One body is so flat that rounding of its forces gives its turn about the vertical a stiffness of 1e-8 1/s^2.
  EXPECT_LE(missed, 1);
  EXPECT_LE(slow, 3);
}

/// Two masses on a triangle of rods at a support turn about the vertical, whatever line they lie on.
TEST(Equilibrium, TwoPointsThatTurnAsOneAreStable) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int each = 0; each < 40; ++each) {
    System mobile;
    for (int i = 0; i < 3; ++i) scenes::add_point({normal(random), normal(random), normal(random)}, &mobile);
    mobile.masses = {1.0, 0.5, 1.7};
    mobile.constraints = {Rods{"rods", {{0, 1}, {1, 2}, {0, 2}}}};
    mobile.supports = {{"", {0}, {}}};
    mobile.forces = {scenes::gravity};

    const EquilibriumResult found = find_equilibrium(mobile);

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_EQ(found.stability.zero_modes, 1u);
    EXPECT_EQ(found.stability.rigid_zero_modes, 1u);
  }
}

/// No force strains the three bonds at a support: the triangle turns freely about the support, a mechanism.
TEST(Equilibrium, TriangleOfBondsAtASupportIsMarginal) {
  System triangle;
  for (const Vector3& place : {Vector3{0.0, 0.0, 0.0}, {1.2, 0.3, 0.0}, {2.2, 0.0, 0.5}})
    scenes::add_point(place, &triangle);
  triangle.supports = {{"", {0}, {}}};
  triangle.forces = {Potential{.name = "bonds",
                               .points = {{0, 1}, {1, 2}, {0, 2}},
                               .kernel = formula_potential("5*(sqrt((x1-x2)^2+(y1-y2)^2+(z1-z2)^2)-1)^2", 2)}};

  const EquilibriumResult found = find_equilibrium(triangle);

  EXPECT_EQ(found.outcome.status, Status::NoSolution) << found.outcome.what;
  EXPECT_EQ(found.stability.status, Stability::Marginal);
  EXPECT_EQ(found.stability.zero_modes, 3u);
  EXPECT_EQ(found.stability.rigid_zero_modes, 0u);
}

/// Opposite charges fall into each other. Where they have met, rounding of their positions makes a force of any size.
TEST(Equilibrium, ChargesThatAttractEachOtherHaveNoEquilibrium) {
  System charges;
  charges.positions = {0.0, 0.0, 0.0, 1.0, 0.2, 0.1};
  charges.masses = {1.0, 1.0};
  charges.forces = {Potential{
      .name = "charges", .points = {{0, 1}}, .kernel = formula_potential("-1/sqrt((x1-x2)^2+(y1-y2)^2+(z1-z2)^2)", 2)}};
  for (const bool is_held : {false, true}) {
    if (is_held) charges.supports = {{"", {0}, {}}};
    for (const AcceptedEquilibria accept : {AcceptedEquilibria::Any, AcceptedEquilibria::Stable}) {
      const EquilibriumResult found = find_equilibrium(charges, {.accept = accept});

      EXPECT_FALSE(found.outcome.ok());
      EXPECT_EQ(found.stability.status, Stability::None) << found.residual_force << " of " << found.largest_force;
    }
  }
}

/// With f = (3 (y - 1), -(y - 1), -z) nothing resists a move along x, but the force along x depends on y.
TEST(Equilibrium, ForceWithoutPotentialIsFoundWhereItsPullEnds) {
  for (const Vector3& start : {Vector3{0.2, 1.0, 0.1}, {0.0, 0.0, 0.0}, {-3.0, 4.0, 1.0}}) {
    System system;
    scenes::add_point(start, &system);
    system.forces = {
        FormulaForce{.name = "field", .points = {0}, .kernel = formula_force({"3*(y-1)", "-(y-1)", "-z"})}};

    const EquilibriumResult found = find_equilibrium(system, {.accept = AcceptedEquilibria::Any});

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_EQ(found.stability.status, Stability::NotConservative);
    EXPECT_NEAR(found.positions[1], 1.0, 1e-12);
    EXPECT_NEAR(found.positions[2], 0.0, 1e-12);
  }
}

/// Two ends of a rod coincide, so that it has no direction there, and descent finds one.
TEST(HardStarts, DescentLeavesAPlaceWherePointsCoincide) {
  System system;
  system.positions = {0, 0, 0, 0.5, 0, 0, 0.5, 0, 0, 1, 0, 0};
  system.masses.assign(4, 1.0);
  Rods rods{"r", {{0, 1}, {1, 2}, {2, 3}}};
  rods.length.constants = {0.5};
  system.constraints = {rods};
  system.supports.push_back({"", {0, 3}, {}});
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};

  const EquilibriumResult found = find_equilibrium(system);
  const EquilibriumResult stopped = find_equilibrium(system, {.method = EquilibriumMethod::Newton});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_EQ(found.stability.status, Stability::Stable);
  EXPECT_NEAR(found.positions[5], -0.5 * std::sqrt(0.75), 1e-9) << "a trapezium that hangs";
  EXPECT_EQ(stopped.outcome.status, Status::NotFinite);
  EXPECT_NE(stopped.outcome.what.find("do points lie on each other?"), std::string::npos) << stopped.outcome.what;
}

}  // namespace
}  // namespace tanor
