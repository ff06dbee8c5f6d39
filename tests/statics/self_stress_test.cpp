/// Bodies have more rods than they need: some results depend on the stress that no load determines, and others do not.

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <tanor/equilibrium.hpp>
#include <tanor/modes.hpp>

namespace tanor {
namespace {

Rods join_all(int count) {
  Rods rods{.name = "body"};
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < i; ++j) rods.pairs.push_back({i, j});
  }
  return rods;
}

/// Makes an octahedron with all its diagonals, hung at a corner.
System make_octahedron() {
  System system;
  system.positions = {0, 0, 0, 0.3, 0, -0.3, -0.3, 0, -0.3, 0, 0.3, -0.3, 0, -0.3, -0.3, 0, 0, -0.6};
  system.masses.assign(6, 1.0);
  system.constraints = {join_all(6)};
  system.supports.push_back({"", {0}, {}});
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  return system;
}

/// The pendulum has omega^2 = m g a/I: five points hang 0.3 m below on the average, about the corner.
TEST(SelfStress, DoesNotChangeHowARigidBodySwings) {
  const System body = make_octahedron();
  const double moment = 2 * (0.3 * 0.3 + 0.3 * 0.3) + 2 * 0.3 * 0.3 + 0.6 * 0.6, arm = 4 * 0.3 + 0.6;
  const double omega = std::sqrt(9.81 * arm / moment);

  const Modes free = modes(body, body.positions, {.count = ModesOptions::all});
  const Modes tight =
      modes(body, body.positions, {.count = ModesOptions::all, .prestress = {{"body", std::vector<double>(15, 50.0)}}});

  for (const Modes* found : {&free, &tight}) {
    ASSERT_TRUE(found->outcome.ok()) << found->outcome.what;
    ASSERT_EQ(found->count(), 3u);
    EXPECT_EQ(found->omega[0], 0.0) << "it turns about the vertical";
    EXPECT_NEAR(found->omega[1], omega, 1e-10);
    EXPECT_NEAR(found->omega[2], omega, 1e-10);
  }
}

/// Its flat shape is rigid with a stress of either sign along the edges, whichever way it warps (Connelly and
/// Whiteley).
TEST(SelfStress, MakesAFreeSquareWithItsDiagonalsStable) {
  System square;
  square.positions = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  square.masses.assign(4, 1.0);
  square.constraints = {join_all(4)};

  const EquilibriumResult found = find_equilibrium(square);

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_EQ(found.stability.status, Stability::Stable);
  EXPECT_EQ(found.stability.zero_modes, 6u);
  EXPECT_GT(found.stability.lowest_omega2, 0.0);
  EXPECT_LT(found.residual_force, 1e-12 * std::abs(found.multipliers[0]));
}

/// A prism's upper triangle over its lower one, untwisted, has a free turn that no stress stiffens.
TEST(SelfStress, LeavesAMechanismMarginal) {
  System system;
  Rods rods{.name = "frame"};
  for (int i = 0; i < 4; ++i) {
    system.positions.insert(system.positions.end(), {i == 1 || i == 2 ? 1.0 : 0.0, i > 1 ? 1.0 : 0.0, 0.0});
    rods.pairs.push_back({i, (i + 1) % 4});
  }
  rods.pairs.push_back({0, 1});  // twice, so that there is a stress
  system.masses.assign(4, 1.0);
  system.constraints = {rods};

  const EquilibriumResult found = find_equilibrium(system, {.accept = AcceptedEquilibria::Any});

  EXPECT_EQ(found.stability.status, Stability::Marginal);
}

/// The wire has no given tensions, which the messages of "modes" and "equilibrium" ask for.
TEST(SelfStress, IsAskedForInAWireWithoutLoad) {
  System wire;
  wire.positions = {0, 0, 0, 1, 0, 0, 2, 0, 0};
  wire.masses.assign(3, 1.0);
  wire.constraints = {Rods{"r", {{0, 1}, {1, 2}}}};
  wire.supports.push_back({"", {0, 2}, {}});

  const Modes found = modes(wire, wire.positions, {.count = ModesOptions::all});

  EXPECT_FALSE(found.outcome.ok());
  EXPECT_NE(found.outcome.what.find("a prestress must be given"), std::string::npos) << found.outcome.what;
}

}  // namespace
}  // namespace tanor
