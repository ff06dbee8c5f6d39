/// The constraints act to one side: floors that do not hold down, ropes that may be slack.

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <tanor/equilibrium.hpp>
#include <tanor/modes.hpp>

#include "errors.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

using scenes::g;

std::vector<Index> all_but_first(std::size_t points) {
  std::vector<Index> result;
  for (std::size_t i = 1; i < points; ++i) result.push_back(static_cast<Index>(i));
  return result;
}

/// Makes a chain from a support at the height h whose other end rests on a table z = 0, where a force H pulls it along
/// x. The rods that lie have V_i = 0, and the pull alone keeps them stretched.
System make_chain_on_table(int count, double length, double mass, double height, double pull) {
  System system;
  Rods rods{.name = "rods"};
  for (int i = 0; i <= count; ++i) {
    system.positions.insert(system.positions.end(), {i * length, 0.0, std::max(0.0, height - 0.7 * i * length)});
    system.masses.push_back(mass);
    if (i > 0) rods.pairs.push_back({i - 1, i});
  }
  rods.length.constants = {length};
  system.constraints = {rods, Planes{"table", all_but_first(system.num_points()), Vector3{0.0, 0.0, 2.0}, 0.0}};
  system.supports = {Support{"", {0}}};
  system.add_gravity({0.0, 0.0, -g});
  system.forces.push_back(ConstantForce{.name = "pull", .points = {count}, .force = Vector3{pull, 0.0, 0.0}});
  return system;
}

const EquilibriumOptions on_table{
    .accept = AcceptedEquilibria::Marginal, .one_sided = {{"table", OneSide::AtLeast}}, .solver = {.threads = 1}};

// Rod k = 1, 2, … from the table carries V = V_1 + (k - 1) m g with 0 <= V_1 < m g, and rises l V/sqrt(H^2 + V^2).
TEST(OneSided, ChainThatLiesPartlyOnATableHangsAsADiscreteCatenary) {
  constexpr double length = 0.1, mass = 0.2, H = 3.0;
  constexpr int hanging = 7, count = 20;
  const double V1 = 0.4 * mass * g;
  double height = 0.0, reach = 0.0;
  for (int k = 0; k < hanging; ++k) {
    const double V = V1 + k * mass * g;
    height += length * V / std::hypot(H, V);
    reach += length * H / std::hypot(H, V);
  }

  const EquilibriumResult found = find_equilibrium(make_chain_on_table(count, length, mass, height, H), on_table);

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  for (int k = 0; k < count; ++k) {
    const double V = k < hanging ? V1 + (hanging - 1 - k) * mass * g : 0.0;
    EXPECT_NEAR(-found.multipliers[static_cast<std::size_t>(k)], std::hypot(H, V), 1e-9) << k;
    // Bead k + 1 is the first that lies: the table carries what the last rod leaves of its weight.
    const std::size_t bead = static_cast<std::size_t>(count + k);
    EXPECT_EQ(found.open[bead], k + 1 < hanging) << k;
    const double carried = k + 1 < hanging ? 0.0 : k + 1 == hanging ? mass * g - V1 : mass * g;
    EXPECT_NEAR(found.multipliers[bead], carried, 1e-9) << k;
    EXPECT_FALSE(found.open[static_cast<std::size_t>(k)]);
  }
  EXPECT_NEAR(found.positions[3 * count], reach + (count - hanging) * length, 1e-10);
}

/// The chain would hang through the table from a level start, where no step of Newton's method lays it down again.
TEST(OneSided, ChainThatStartsAboveTheTableComesToLie) {
  System system = make_chain_on_table(30, 0.1, 0.2, 0.5, 2.0);
  for (std::size_t i = 0; i <= 30; ++i) system.positions[3 * i + 2] = 0.5;

  const EquilibriumResult found = find_equilibrium(system, on_table);

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_NEAR(-found.multipliers[29], 2.0, 1e-9);
  EXPECT_NEAR(found.positions[3 * 30 + 2], 0.0, 1e-12);
  // The support carries the hanging part, up to the bead that lies first, and the table carries the rest.
  double weight = 0.0;
  for (std::size_t row = 30; row < 60; ++row) weight += found.multipliers[row];
  EXPECT_NEAR(weight - found.support_forces[2], 30 * 0.2 * g, 0.2 * g + 1e-9);
}

TEST(OneSided, ChainThatIsPulledOffTheTableHangsAsWithoutATable) {
  System system = make_chain_on_table(10, 0.1, 0.2, 0.9, 0.0);
  system.supports = {Support{"", {0, 10}}};
  for (std::size_t i = 0; i <= 10; ++i) system.positions[3 * i + 2] = 1.0;
  for (std::size_t i = 0; i <= 10; ++i) system.positions[3 * i] *= 0.8;
  System free = system;
  free.constraints.pop_back();

  const EquilibriumResult with = find_equilibrium(system, on_table), without = find_equilibrium(free);

  ASSERT_TRUE(with.outcome.ok()) << with.outcome.what;
  for (std::size_t i = 0; i < with.positions.size(); ++i) EXPECT_NEAR(with.positions[i], without.positions[i], 1e-10);
  EXPECT_EQ(std::ranges::count(with.open, true), 10);
  EXPECT_EQ(with.stability.status, Stability::Stable);
}

TEST(OneSided, BallFallsOntoASphereOrATableFromAbove) {
  System system;
  system.positions = {0.0, 0.0, 0.7, 0.1, 0.0, -0.2};
  system.masses = {2.0, 3.0};
  system.constraints = {Planes{"table", {0}, Vector3{0.0, 0.0, 1.0}, 0.25},
                        Spheres{"bowl", {1}, Vector3{0.0, 0.0, 0.0}, 1.0}};
  system.add_gravity({0.0, 0.0, -g});

  const EquilibriumResult found = find_equilibrium(
      system,
      {.accept = AcceptedEquilibria::Marginal, .one_sided = {{"table", OneSide::AtLeast}, {"bowl", OneSide::AtMost}}});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_NEAR(found.positions[2], 0.25, 1e-12);
  EXPECT_NEAR(found.multipliers[0], 2.0 * g, 1e-9);
  EXPECT_NEAR(found.positions[5], -1.0, 1e-12);
  EXPECT_NEAR(found.multipliers[1], -3.0 * g, 1e-9);
}

/// A weight hangs on two ropes, at_most, so that one of them is slack: it hangs below the other alone.
TEST(OneSided, RopeIsSlackWhereTheOtherCarriesAll) {
  System system;
  system.positions = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.2, 0.0, -0.4};
  system.masses = {1.0, 1.0, 2.0};
  system.supports = {Support{"", {0, 1}}};
  system.constraints = {Rods{"ropes", {{0, 2}, {1, 2}}, std::vector<double>{0.5, 2.0}}};
  system.add_gravity({0.0, 0.0, -g});

  const EquilibriumResult found = find_equilibrium(system, {.one_sided = {{"ropes", OneSide::AtMost}}});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_NEAR(found.positions[8], -0.5, 1e-12);
  EXPECT_EQ(found.open, (std::vector<bool>{false, true}));
  EXPECT_NEAR(-found.multipliers[0], 2.0 * g, 1e-9);
  EXPECT_NEAR(found.stability.lowest_omega2, g / 0.5, 1e-8);
  const Modes vibrations = modes(without_open_constraints(system, found.open), found.positions);
  ASSERT_TRUE(vibrations.outcome.ok()) << vibrations.outcome.what;
  EXPECT_NEAR(vibrations.omega[0], std::sqrt(g / 0.5), 1e-9);
}

/// Rows that depend on each other are named as the user counts them.
TEST(OneSided, MembersKeepTheirNumbersWhereOthersAreOpen) {
  System system;
  system.positions = {0.0, 0.0, 3.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0};
  system.masses = {1.0, 1.0, 1.0};
  system.supports = {Support{"", {0}}};
  system.constraints = {Rods{"rope", {{0, 1}}}, Planes{"table", {1, 2, 2}, Vector3{0.0, 0.0, 1.0}, 0.0}};
  system.add_gravity({0.0, 0.0, -g});

  const EquilibriumResult found = find_equilibrium(system, on_table);

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  ASSERT_EQ(found.dependences.size(), 1u);
  EXPECT_EQ(found.dependences[0], "table[2] depends on table[1]");
  EXPECT_EQ(found.multipliers_unique, (std::vector<bool>{true, true, false, false}));
}

/// Nets of springs and rods over tables, walls and bowls are complementary: each row either carries or keeps its
/// distance.
TEST(OneSided, RandomSystemsAreComplementary) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int trial = 0; trial < 40; ++trial) {
    System system;
    Springs springs{.name = "springs"};
    Rods rods{.name = "rods"};
    const int side = 3 + trial % 3;
    for (int i = 0; i < side * side; ++i) {
      const int x = i % side, y = i / side;
      system.positions.insert(system.positions.end(), {0.3 * x, 0.3 * y, 0.3 + 0.2 * any(random)});
      system.masses.push_back(0.5 + 0.4 * any(random));
      if (x > 0) (i % 5 == 1 ? rods.pairs : springs.pairs).push_back({i - 1, i});
      if (y > 0) springs.pairs.push_back({i - side, i});
    }
    springs.stiffness = 20.0;
    springs.rest_length.constants = {0.25};
    const std::vector<Index> points = all_but_first(system.num_points());
    const Vector3 slope{0.4 * any(random), 0.4 * any(random), 1.0}, wall{-1.0, 0.2 * any(random), 0.1 * any(random)};
    system.constraints = {rods, Planes{"floor", points, slope, 0.1 * any(random)},
                          Planes{"wall", points, wall, -0.3 * side + 0.35 + 0.1 * any(random)},
                          Spheres{"ball", points, Vector3{0.4, 0.4, 0.0}, 0.25}};
    system.supports = {Support{"", {0}}};
    system.forces = {springs, Gravity{"", {0.0, 0.0, -g}}};

    const EquilibriumResult found = find_equilibrium(
        system, {.accept = AcceptedEquilibria::Any,
                 .one_sided = {{"floor", OneSide::AtLeast}, {"wall", OneSide::AtLeast}, {"ball", OneSide::AtLeast}},
                 .solver = {.threads = 1}});

    ASSERT_TRUE(found.outcome.ok()) << trial << ": " << found.outcome.what;
    EXPECT_LE(found.residual_force, 1e-10 * found.largest_force);
    std::size_t row = rods.pairs.size(), closed = 0;
    for (int kind = 0; kind < 3; ++kind) {
      for (const Index point : points) {
        const double* r = &found.positions[3 * static_cast<std::size_t>(point)];
        const auto* planes = std::get_if<Planes>(&system.constraints[static_cast<std::size_t>(kind + 1)]);
        const Vector3 n = kind == 0 ? slope : wall;
        const double gap = planes != nullptr ? n[0] * r[0] + n[1] * r[1] + n[2] * r[2] - planes->offset.constants[0]
                                             : std::hypot(r[0] - 0.4, r[1] - 0.4, r[2]) - 0.25;
        if (found.open[row]) {
          EXPECT_EQ(found.multipliers[row], 0.0);
          EXPECT_GE(gap, -1e-9);
        } else {
          EXPECT_GE(found.multipliers[row], -1e-8 * found.largest_force);
          EXPECT_NEAR(gap, 0.0, 1e-9);
          ++closed;
        }
        ++row;
      }
    }
    EXPECT_GT(closed, 0u);
  }
}

TEST(OneSided, SystemThatNothingHoldsHasNoEquilibrium) {
  System system;
  system.positions = {0.0, 0.0, 1.0};
  system.masses = {1.0};
  system.constraints = {Planes{"table", {0}, Vector3{0.0, 0.0, -1.0}, 0.0}};
  system.add_gravity({0.0, 0.0, -g});

  const EquilibriumResult found = find_equilibrium(system, on_table);

  EXPECT_EQ(found.outcome.status, Status::NoSolution);
  EXPECT_NE(found.outcome.what.find("without end"), std::string::npos) << found.outcome.what;
}

TEST(OneSided, ConstraintsAreNamedAndHaveOneEquation) {
  System system;
  system.positions = {0.0, 0.0, 1.0};
  system.masses = {1.0};
  system.constraints = {Lines{"wire", {0}, Vector3{0.0, 0.0, 0.0}, Vector3{0.0, 0.0, 1.0}}};

  const auto complaint = [&](const char* name) {
    return error_of([&] { (void)find_equilibrium(system, {.one_sided = {{name}}}); });
  };

  EXPECT_EQ(complaint("floor"), "/equilibrium/one_sided/floor: no constraint has the name \"floor\"");
  EXPECT_EQ(complaint("wire"),
            "/equilibrium/one_sided/wire: constraints of kind line have 2 equations a member; "
            "one-sided ones have one");
}

}  // namespace
}  // namespace tanor
