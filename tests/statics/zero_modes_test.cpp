/// The tests distinguish motions that cost nothing from slow ones.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Dense>
#include <tanor/equilibrium.hpp>
#include <tanor/modes.hpp>

#include "dense.hpp"

namespace tanor {
namespace {

constexpr double weight = 9.81;

/// Makes a rope of elastic pieces that hangs from its upper end: EA = 2e7 N, 10 m, 2 kg/m.
System make_rope(int pieces) {
  System system;
  Springs springs{.name = "rope"};
  const double length = 10.0 / pieces;
  springs.stiffness = 2e7 / length;
  springs.rest_length.constants = {length};
  for (int i = 0; i <= pieces; ++i) {
    system.positions.insert(system.positions.end(), {0.0, 0.0, -length * i});
    system.masses.push_back(2.0 * length);
    if (i > 0) springs.pairs.push_back({i - 1, i});
  }
  system.supports.push_back({"", {0}, {}});
  system.forces = {springs, Gravity{"", {0.0, 0.0, -weight}}};
  return system;
}

/// Returns omega of the transverse modes by T_i/l_i of the stretched pieces.
std::vector<double> swing_of_rope(const System& rope) {
  const auto pieces = static_cast<Eigen::Index>(rope.masses.size()) - 1;
  const auto& springs = std::get<Springs>(rope.forces[0]);
  const double mass = rope.masses[1], length = 10.0 / static_cast<double>(pieces);
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(pieces, pieces);
  for (Eigen::Index i = 0; i < pieces; ++i) {
    const double tension = mass * weight * static_cast<double>(pieces - i);
    const double by = tension / (length + tension / springs.stiffness);
    stiffness(i, i) += by;
    if (i == 0) continue;
    stiffness(i - 1, i - 1) += by;
    stiffness(i, i - 1) -= by;
    stiffness(i - 1, i) -= by;
  }
  const Eigen::VectorXd omega2 = reference::eigenvalues(stiffness / mass);
  return {omega2.cwiseSqrt().begin(), omega2.cwiseSqrt().end()};
}

class Rope : public testing::TestWithParam<int> {};

/// The slow omega^2 are 1e-9 to 1e-11 of the fastest one.
TEST_P(Rope, SwingsSlowlyAndStably) {
  const System rope = make_rope(GetParam());
  const EquilibriumResult rest = find_equilibrium(rope);
  ASSERT_TRUE(rest.outcome.ok()) << rest.outcome.what;
  EXPECT_EQ(rest.stability.status, Stability::Stable);
  EXPECT_EQ(rest.stability.zero_modes, 0u);

  const Modes found = modes(rope, rest.positions, {.count = 6});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_EQ(found.zero_modes, 0u);
  const std::vector<double> swing = swing_of_rope(rope);
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(found.omega[k], swing[k / 2], 1e-5 * swing[k / 2]) << k;
  EXPECT_NEAR(rest.stability.lowest_omega2, swing[0] * swing[0], 1e-5);
}

INSTANTIATE_TEST_SUITE_P(OfPieces, Rope, testing::Values(50, 100, 400));

/// The stability of a configuration does not depend on masses.
TEST(Stability, IsTheSameForAnyMasses) {
  System system;
  Rods rods{.name = "rods"};
  rods.length.constants = {1.3 / 6.0};
  for (int i = 0; i <= 6; ++i) {
    system.positions.insert(system.positions.end(), {i / 6.0, 0.0, 0.0});
    if (i > 0) rods.pairs.push_back({i - 1, i});
  }
  system.constraints = {rods};
  system.supports.push_back({"", {0, 6}, {}});
  system.forces = {ConstantForce{"", {1, 2, 3, 4, 5}, Vector3{0.0, 0.0, -1.0}}};
  for (const std::vector<double>& masses :
       {std::vector<double>(7, 1.0), std::vector<double>{1.0, 1.0, 1e-5, 1e5, 1.0, 1.0, 1.0}}) {
    system.masses = masses;

    const EquilibriumResult found = find_equilibrium(system);

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_EQ(found.stability.status, Stability::Stable);
    EXPECT_EQ(found.stability.zero_modes, 0u);
  }
}

/// The eigenvalues of the companion matrix have slow modes only to the rounding of the fastest.
TEST(DampedModes, DoNotGrowWithoutDampers) {
  for (const int pieces : {50, 70, 80, 90, 96}) {
    System rope = make_rope(pieces);
    for (double& mass : rope.masses) mass *= 0.39;
    const EquilibriumResult rest = find_equilibrium(rope);
    ASSERT_TRUE(rest.outcome.ok()) << rest.outcome.what;

    const Modes found = modes(rope, rest.positions, {.count = 6, .damped = true});

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    EXPECT_EQ(found.unstable_directions, 0u) << pieces;
    EXPECT_EQ(found.decay, std::vector<double>(6, 0.0)) << pieces;
    const std::vector<double> swing = swing_of_rope(rope);
    for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(found.omega[k], swing[k / 2], 1e-5 * swing[k / 2]) << k;
  }
}

/// Forces that are not quite in balance hide no modes where a support, which has no mass of its own, holds the rope.
TEST(DampedModes, AreFoundAtAPlaceThatIsNotQuiteInBalance) {
  const System rope = make_rope(20);
  const EquilibriumResult rest = find_equilibrium(rope);
  ASSERT_TRUE(rest.outcome.ok()) << rest.outcome.what;
  std::vector<double> near = rest.positions;
  near.back() -= 1e-14 * 10.0 * 1e3;

  const Modes found = modes(rope, near, {.count = 2, .force_tolerance = 1e-2, .damped = true});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_EQ(found.zero_modes, 0u);
  EXPECT_NEAR(found.omega[0], swing_of_rope(rope)[0], 1e-3);
}

TEST(Modes, NameForcesOfAGyroscopeThatDependOnVelocities) {
  System system;
  system.positions = {0.0, 0.0, 0.0};
  system.masses = {2.0};
  system.forces = {FormulaForce{"well", {0}, formula_force({"-50*x", "-50*y", "-50*z"})},
                   FormulaForce{"top", {0}, formula_force({"4*vy", "-4*vx", "0"})}};

  const Modes found = modes(system, system.positions, {.count = 3});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_EQ(found.left_out, std::vector<std::string>{"top: what depends on velocities takes no part in vibrations"});
}

/// Positions far out are rounded, and what forces that leaves, through rods too, is no stiffness.
TEST(TetrahedronFarOut, HasSixRigidModes) {
  const std::vector<std::array<double, 3>> corners{{0, 0, 0}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}};
  using Pairs = decltype(Rods::pairs);
  const Pairs edges{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
  for (const double far : {1e3, 1e5, 2.1e6, 1.4e7}) {
    for (std::size_t num_rods = 0; num_rods <= edges.size(); ++num_rods) {
      System system;
      for (const auto& [x, y, z] : corners)
        system.positions.insert(system.positions.end(), {x - 0.31 * far, y + 0.83 * far, z + 0.46 * far});
      system.masses = {1.0, 0.7, 1.9, 1.3};
      const auto middle = edges.begin() + static_cast<std::ptrdiff_t>(num_rods);
      if (num_rods > 0) system.constraints = {Rods{"rods", Pairs(edges.begin(), middle), std::sqrt(2.0)}};
      Springs springs{.name = "springs", .pairs = Pairs(middle, edges.end()), .stiffness = 1e4};
      springs.rest_length.constants = {std::sqrt(2.0)};
      if (!springs.pairs.empty()) system.forces = {springs};

      const EquilibriumResult rest = find_equilibrium(system);
      const Modes found = modes(system, system.positions, {.count = ModesOptions::all});

      ASSERT_TRUE(rest.outcome.ok()) << far << ", " << num_rods << ": " << rest.outcome.what;
      EXPECT_EQ(rest.stability.rigid_zero_modes, 6u) << far << ", " << num_rods;
      EXPECT_EQ(found.zero_modes, 6u) << far << ", " << num_rods;
      EXPECT_EQ(found.rigid_zero_modes, 6u) << far << ", " << num_rods;
      EXPECT_EQ(found.unstable_directions, 0u) << far << ", " << num_rods;
    }
  }
}

/// One point hangs on two springs to pins, which have their lengths, and another one on a single spring.
TEST(SpringsFarOut, HaveTheZeroModesOfTheOrigin) {
  for (const double far : {0.0, 1e5, 3.3e6}) {
    System system;
    for (const Vector3& place : {Vector3{0, 0, 0}, {1, 0.2, 0}, {0.4, 0.9, 0.1}, {0.7, -0.3, 0.8}})
      system.positions.insert(system.positions.end(), {place[0] + far, place[1] - 2.0 * far, place[2] + 0.5 * far});
    system.masses = {1.0, 1.0, 1.3, 0.8};
    system.supports = {{"", {0, 1}, {}}};
    Springs springs{.name = "springs", .pairs = {{0, 2}, {1, 2}, {0, 3}}, .stiffness = 100.0};
    springs.rest_length.constants = {std::sqrt(0.98), std::sqrt(0.86), std::sqrt(1.22)};
    system.forces = {springs};

    const EquilibriumResult found = find_equilibrium(system);

    EXPECT_EQ(found.stability.status, Stability::Marginal) << far << ": " << found.outcome.what;
    EXPECT_EQ(found.stability.zero_modes, 3u) << far;
    EXPECT_EQ(found.stability.rigid_zero_modes, 0u) << far;
  }
}

/// A given force that balances the weight to rounding leaves no stiffness.
TEST(WeightThatIsBalanced, LeavesAPendulumMarginal) {
  System system;
  system.positions = {0.0, 0.0, 0.0, 0.3, 0.1, -0.9};
  system.masses = {1.0, 0.1};
  system.supports = {{"", {0}, {}}};
  system.constraints = {Rods{"rod", {{0, 1}}}};
  system.forces = {Gravity{"", {0.0, 0.0, -weight}}, ConstantForce{"", {1}, Vector3{0.0, 0.0, 0.981}}};

  const EquilibriumResult found = find_equilibrium(system);

  EXPECT_EQ(found.stability.status, Stability::Marginal) << found.outcome.what;
  EXPECT_EQ(found.stability.zero_modes, 2u);
}

}  // namespace
}  // namespace tanor
