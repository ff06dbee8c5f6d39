/// Nets and lattices that hang from one corner collapse: their rods come to lie on each other, K loses ranks as the
/// points come nearer, and nothing determines how the rods pull against each other. Equilibrium and modes say so.

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <tanor/equilibrium.hpp>
#include <tanor/modes.hpp>

#include "dense_modes.hpp"
#include "dynamics/workspace.hpp"
#include "scenes.hpp"

namespace tanor {
using namespace detail;
namespace {

bool says_self_stress(const EquilibriumResult& found) {
  return std::ranges::any_of(found.left_out,
                             [](const std::string& each) { return each.find("self-stress") != std::string::npos; });
}

TEST(CollapsedNets, ReportSelfStressAndHaveNoModesWithoutAPrestress) {
  for (const std::array<int, 3>& size : {std::array{2, 2, 2}, {2, 2, 3}, {3, 3, 2}, {3, 3, 1}, {4, 3, 2}, {3, 3, 3}}) {
    const std::string name = testing::PrintToString(size);
    const System system = scenes::hang(scenes::make_grid(size), {0});

    const EquilibriumResult found = find_equilibrium(system);

    ASSERT_TRUE(found.outcome.ok()) << name << ": " << found.outcome.what;
    EXPECT_EQ(found.stability.status, Stability::Stable) << name;
    EXPECT_GT(found.self_stress_states, 0u) << name;
    EXPECT_TRUE(says_self_stress(found)) << name;
    EXPECT_EQ(modes(system, found.positions).outcome.status, Status::NotUnique) << name;
  }
}

/// Nets that hang from an inner point fold over it. With the smallest multipliers a motion may gain energy where with
/// others none does, so that the net rests. The reported multipliers are ones that show it.
TEST(CollapsedNets, AreStableWithTheMultipliersThatAreTold) {
  for (const auto& [columns, rows, held] : {std::array{6, 9, 52}, {10, 7, 37}, {10, 7, 16}, {12, 12, 0}}) {
    System net = scenes::make_net(columns, rows);
    net.supports = {{"", {held}, {}}};
    net.forces = {scenes::gravity};
    for (std::size_t i = 0; i < net.positions.size(); ++i)
      net.positions[i] += 0.02 * std::sin(1.0 + 2.3 * static_cast<double>(i));

    const EquilibriumResult found = find_equilibrium(net);

    ASSERT_TRUE(found.outcome.ok()) << columns << " x " << rows << ": " << found.outcome.what;
    EXPECT_EQ(found.stability.status, Stability::Stable);
    ASSERT_GT(found.self_stress_states, 0u);
    // The dense matrices with those multipliers have the same lowest omega^2.
    Workspace work(net, {.threads = 1}, 0.0);
    const Model& model = work.model();
    EquilibriumEquations equations(work, 0.0);
    std::vector<double> r(3 * model.num_points()), lambda(model.num_rows());
    model.numbering.gather_points(found.positions, r);
    for (std::size_t a = 0; a < lambda.size(); ++a)
      lambda[a] = found.multipliers[static_cast<std::size_t>(model.numbering.user_row[a])];
    equations.linearise(r.data(), lambda.data());
    const DenseModes dense(equations, 1e-5);
    ASSERT_GT(dense.freedoms(), 0u);
    EXPECT_NEAR(dense.omega2[0], found.stability.lowest_omega2, 1e-3 * found.stability.lowest_omega2)
        << columns << " x " << rows;
  }
}

/// Where all tensions are determined modes and equilibrium agree.
TEST(HangingNets, ModesAndEquilibriumCountTheSameUnstableDirections) {
  System net = scenes::make_net(4, 3);
  net.supports = {{"", {0, 3, 8}, {}}};
  for (const bool up : {false, true}) {
    if (up) net.forces = {Gravity{"up", {0.0, 0.0, 9.81}}};
    const EquilibriumResult found = find_equilibrium(net, {.accept = AcceptedEquilibria::Any});
    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    ASSERT_EQ(found.self_stress_states, 0u);

    const Modes shaken = modes(net, found.positions, {.count = 2});

    ASSERT_TRUE(shaken.outcome.ok()) << shaken.outcome.what;
    EXPECT_EQ(shaken.unstable_directions, found.stability.unstable_directions);
  }
}

/// A tower of rods stands upside down: every direction grows, and more than were asked for are counted.
TEST(Modes, CountGrowingDirectionsBeyondTheModesAskedFor) {
  for (const int count : {40, 200}) {
    System tower;
    Rods rods{"rods", {}, scenes::spacing, {}};
    for (int i = 0; i <= count; ++i) {
      scenes::add_point({0.0, 0.0, scenes::spacing * i}, &tower);
      if (i > 0) rods.pairs.push_back({i - 1, i});
    }
    tower.constraints = {rods};
    tower.supports = {{"", {0}, {}}};
    tower.forces = {scenes::gravity};

    const Modes growing = modes(tower, tower.positions, {.count = 3});

    ASSERT_TRUE(growing.outcome.ok()) << growing.outcome.what;
    EXPECT_EQ(growing.unstable_directions, 2u * static_cast<unsigned>(count));
  }
}

/// Nothing acts on these beads, few or many: they rest wherever they are.
TEST(Equilibrium, FreeBeadsHaveRigidZeroModesAlone) {
  for (const int count : {20, 150}) {
    System gas;
    for (int i = 0; i < count; ++i) scenes::add_point({0.1 * i, 0.0, 0.0}, &gas);
    System plane = gas;
    plane.constraints = {Planes{.name = "table", .points = {}, .normal = Vector3{0.0, 0.0, 1.0}}};
    for (Index i = 0; i < count; ++i) std::get<Planes>(plane.constraints[0]).points.push_back(i);
    plane.forces = {scenes::gravity};
    for (const auto& [system, each] : {std::pair{gas, 3u}, {plane, 2u}}) {
      const EquilibriumResult found = find_equilibrium(system);

      ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
      EXPECT_EQ(found.stability.status, Stability::Stable);
      EXPECT_EQ(found.stability.zero_modes, each * static_cast<unsigned>(count));
      EXPECT_EQ(found.stability.rigid_zero_modes, found.stability.zero_modes);
      const Modes still = modes(system, found.positions, {.count = 5});
      ASSERT_TRUE(still.outcome.ok()) << still.outcome.what;
      EXPECT_EQ(still.zero_modes, 5u);
    }
  }
}

/// A taut wire between supports has tensions that no load determines.
TEST(Equilibrium, TensionsOfATautWireAreNotTold) {
  System wire;
  for (int i = 0; i <= 4; ++i) scenes::add_point({scenes::spacing * i, 0.0, 0.0}, &wire);
  wire.constraints = {Rods{"wire", {{0, 1}, {1, 2}, {2, 3}, {3, 4}}}};
  wire.supports = {{"", {0, 4}, {}}};
  wire.forces = {scenes::gravity};

  const EquilibriumResult found = find_equilibrium(wire);

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_TRUE(std::ranges::none_of(found.multipliers_unique, [](bool unique) { return unique; }));
  EXPECT_TRUE(std::ranges::all_of(found.multipliers, [](double lambda) { return std::isnan(lambda); }));
  EXPECT_TRUE(std::isnan(found.support_forces[0]));
  EXPECT_TRUE(std::isnan(found.largest_force));
}

}  // namespace
}  // namespace tanor
