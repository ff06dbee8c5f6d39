/// In the inner order islands follow one another, chains are tridiagonal, and trees have no fill.

#include "system/numbering.hpp"

#include <algorithm>
#include <numeric>
#include <random>
#include <set>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "assembly/gather_plan.hpp"
#include "factor/cholesky.hpp"
#include "linearised.hpp"

namespace tanor {
using namespace detail;
namespace {

std::vector<Index> any_order(Index n, std::uint32_t seed) {
  std::vector<Index> result(static_cast<std::size_t>(n));
  std::iota(result.begin(), result.end(), 0);
  std::shuffle(result.begin(), result.end(), std::mt19937(seed));
  return result;
}

/// Makes points at random positions, joined by rods in the order given.
System make_system(Index n, const std::vector<std::array<Index, 2>>& pairs) {
  System system;
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  for (Index c = 0; c < 3 * n; ++c) system.positions.push_back(normal(generator));
  system.masses.assign(static_cast<std::size_t>(n), 1.0);
  if (!pairs.empty()) system.constraints = {Rods{"", pairs, {}, {}}};
  return system;
}

/// Makes a graph whose points and rods carry random numbers.
System make_shuffled(Index n, std::vector<std::array<Index, 2>> pairs, std::uint32_t seed) {
  const std::vector<Index> name = any_order(n, seed);
  for (auto& [i, j] : pairs) {
    i = name[static_cast<std::size_t>(i)];
    j = name[static_cast<std::size_t>(j)];
  }
  std::shuffle(pairs.begin(), pairs.end(), std::mt19937(seed + 1));
  return make_system(n, pairs);
}

std::vector<std::array<Index, 2>> chain(Index n) {
  std::vector<std::array<Index, 2>> pairs;
  for (Index i = 0; i + 1 < n; ++i) pairs.push_back({i, i + 1});
  return pairs;
}

std::vector<std::array<Index, 2>> any_tree(Index n, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::vector<std::array<Index, 2>> pairs;
  for (Index i = 1; i < n; ++i) pairs.push_back({std::uniform_int_distribution<Index>(0, i - 1)(generator), i});
  return pairs;
}

/// Returns the lower triangle of S in the inner order.
TrianglePattern pattern_of(const System& system) {
  const Linearised inner(system, 0.0, system.positions, system.positions);
  std::vector<Incidence> moving;
  for (const Incidence& incidence : inner.incidences) {
    if (static_cast<std::size_t>(incidence.point) < inner.numbering.num_moving) moving.push_back(incidence);
  }
  std::stable_sort(moving.begin(), moving.end(),
                   [](const Incidence& a, const Incidence& b) { return a.point < b.point; });
  const GatherPlan plan(list_products(moving, inner.inverse_masses, 0), inner.numbering.first_idle_row(), {},
                        Triangle::Lower);
  return {plan.column_start(), plan.rows()};
}

RC_GTEST_PROP(Numbering, RenamesPointsAndRowsOneToOne, ()) {
  const RandomSystem random = any_system();

  const Numbering numbering = number(random.system);

  const std::size_t n = random.system.num_points(), d = num_equations(random.system);
  RC_ASSERT(numbering.num_points() == n && numbering.num_rows() == d);
  for (std::size_t i = 0; i < n; ++i) {
    RC_ASSERT(numbering.user_point[static_cast<std::size_t>(numbering.inner_point[i])] == static_cast<Index>(i));
  }
  const std::set<Index> rows(numbering.user_row.begin(), numbering.user_row.end());
  RC_ASSERT(rows.size() == d && (d == 0 || (*rows.begin() == 0 && *rows.rbegin() == static_cast<Index>(d) - 1)));
}

/// Hosts have chains one after the other, so that their arrays can be used where they are.
TEST(Numbering, KeepsTheUsersOrderOfChainsOneAfterTheOther) {
  std::vector<std::array<Index, 2>> pairs;
  for (const Index first : {0, 5, 7}) {
    for (const auto& [i, j] : chain(first == 5 ? 2 : 5)) pairs.push_back({first + i, first + j});
  }
  const Numbering numbering = number(make_system(12, pairs));

  EXPECT_TRUE(numbering.is_natural);
  EXPECT_TRUE(std::ranges::is_sorted(numbering.user_point));
  EXPECT_TRUE(std::ranges::is_sorted(numbering.user_row));
  EXPECT_FALSE(number(make_shuffled(12, pairs, 3)).is_natural);
}

/// Where the numbers of points tell no direction, the rods do: those of a chain that follow one another in the user's
/// list do so inside.
RC_GTEST_PROP(Numbering, RodsOfAChainWithRandomNumbersKeepTheUsersDirection, ()) {
  System system;
  constexpr std::size_t count = 5, length = 7;  // chains; rods
  system.masses.assign(count * (length + 1), 1.0);
  system.positions.assign(3 * system.masses.size(), 0.0);
  for (std::size_t k = 0; k < system.positions.size(); ++k) system.positions[k] = static_cast<double>(k);
  std::vector<Index> place(system.masses.size());
  std::iota(place.begin(), place.end(), 0);
  std::ranges::shuffle(place, std::mt19937(*rc::gen::arbitrary<unsigned>()));
  Rods rods{"rods", {}, {}, {}};
  for (std::size_t i = 0; i < place.size(); ++i) {
    if (i % (length + 1) > 0) rods.pairs.push_back({place[i - 1], place[i]});
  }
  system.constraints = {rods};
  const Numbering numbering = number(system);
  for (std::size_t island = 0; island < count; ++island) {
    const auto first = static_cast<std::size_t>(numbering.island_start[island]);
    const std::size_t chain = static_cast<std::size_t>(numbering.user_row[first]) / length;
    std::vector<Index> points(place.begin() + static_cast<std::ptrdiff_t>(chain * (length + 1)),
                              place.begin() + static_cast<std::ptrdiff_t>((chain + 1) * (length + 1)));
    if (std::ranges::is_sorted(points, std::greater())) continue;  // these tell a direction
    for (std::size_t k = 0; k < length; ++k)
      RC_ASSERT(static_cast<std::size_t>(numbering.user_row[first + k]) == chain * length + k);
  }
}

RC_GTEST_PROP(Numbering, SupportsComeLast, ()) {
  const RandomSystem random = any_system();
  const std::vector<char> is_support = reference::find_supports(random.system);

  const Numbering numbering = number(random.system);

  for (std::size_t i = 0; i < numbering.num_points(); ++i) {
    const bool moves = is_support[static_cast<std::size_t>(numbering.user_point[i])] == 0;
    RC_ASSERT(moves == (i < numbering.num_moving));
  }
}

RC_GTEST_PROP(Numbering, IslandsAreTheConnectedPartsOfTheMovingPoints, ()) {
  const RandomSystem random = any_system();
  const Linearised inner(random);
  const Numbering& numbering = inner.numbering;

  // Rows are in one island exactly when a path of shared moving points joins them.
  std::vector<std::size_t> part(numbering.num_rows());
  std::iota(part.begin(), part.end(), std::size_t{0});
  std::vector<std::vector<Index>> rows_of_point(numbering.num_moving);
  for (const Incidence& incidence : inner.incidences) {
    if (static_cast<std::size_t>(incidence.point) < numbering.num_moving) {
      rows_of_point[static_cast<std::size_t>(incidence.point)].push_back(incidence.row);
    }
  }
  for (bool changes = true; changes;) {
    changes = false;
    for (const auto& rows : rows_of_point) {
      for (const Index a : rows) {
        for (const Index b : rows) {
          if (part[static_cast<std::size_t>(b)] > part[static_cast<std::size_t>(a)]) {
            part[static_cast<std::size_t>(b)] = part[static_cast<std::size_t>(a)];
            changes = true;
          }
        }
      }
    }
  }
  for (std::size_t island = 0; island < numbering.num_islands(); ++island) {
    const auto begin = static_cast<std::size_t>(numbering.island_start[island]);
    const auto end = static_cast<std::size_t>(numbering.island_start[island + 1]);
    RC_ASSERT(begin < end);
    for (std::size_t a = 0; a < part.size(); ++a) {
      RC_ASSERT((part[a] == part[begin]) == (begin <= a && a < end));
    }
  }
}

RC_GTEST_PROP(Numbering, GatherAndScatterAreInverse, ()) {
  const RandomSystem random = any_system();
  const Numbering numbering = number(random.system);
  std::vector<double> inner(random.positions.size()), user(random.positions.size());

  numbering.gather_points(random.positions, inner);
  numbering.scatter_points(inner, user);

  RC_ASSERT(user == random.positions);
  for (std::size_t i = 0; i < numbering.num_points(); ++i) {
    RC_ASSERT(inner[3 * i] == random.positions[3 * static_cast<std::size_t>(numbering.user_point[i])]);
  }
}

RC_GTEST_PROP(Numbering, ChainWithRandomNumbersBecomesTridiagonal, ()) {
  const Index n = *rc::gen::inRange<Index>(3, 200).as("points");

  const TrianglePattern pattern = pattern_of(make_shuffled(n, chain(n), *rc::gen::arbitrary<std::uint32_t>()));

  RC_ASSERT(static_cast<Index>(pattern.size()) == n - 1);
  for (std::size_t j = 0; j < pattern.size(); ++j) {
    const int begin = pattern.start[j], entries = pattern.start[j + 1] - begin;
    RC_ASSERT(entries == (j + 1 < pattern.size() ? 2 : 1));
    if (entries == 2) RC_ASSERT(pattern.rows[static_cast<std::size_t>(begin) + 1] == static_cast<int>(j) + 1);
  }
}

RC_GTEST_PROP(Numbering, RingWithRandomNumbersIsNumberedRound, ()) {
  const Index n = *rc::gen::inRange<Index>(3, 200).as("points");
  std::vector<std::array<Index, 2>> pairs = chain(n);
  pairs.push_back({n - 1, 0});

  const System system = make_shuffled(n, pairs, *rc::gen::arbitrary<std::uint32_t>());

  const Linearised inner(system, 0.0, system.positions, system.positions);

  std::vector<std::set<Index>> ends(static_cast<std::size_t>(n));
  for (const Incidence& incidence : inner.incidences)
    ends[static_cast<std::size_t>(incidence.row)].insert(incidence.point);
  for (Index row = 0; row < n; ++row) RC_ASSERT(ends[static_cast<std::size_t>(row)] == (std::set{row, (row + 1) % n}));
}

RC_GTEST_PROP(Numbering, TreeWithRandomNumbersIsEliminatedWithoutFillAsItIs, ()) {
  const Index n = *rc::gen::inRange<Index>(2, 200).as("points");
  const auto seed = *rc::gen::arbitrary<std::uint32_t>().as("seed");
  const TrianglePattern pattern = pattern_of(make_shuffled(n, any_tree(n, seed), seed));

  const SymbolicAnalysis analysis = analyze(pattern, Ordering::Auto);

  RC_ASSERT(analysis.ordering == Ordering::Natural);
  RC_ASSERT(analysis.factor_nonzeros == static_cast<double>(pattern.rows.size()));
}

TEST(Numbering, SupportConnectsNothing) {
  // In 0 - 1 - (2) - 3 - 4 two islands share only the support 2.
  System system = make_system(5, chain(5));
  system.supports = {{"", {2}, {}}};

  const Numbering numbering = number(system);

  EXPECT_EQ(numbering.num_islands(), 2U);
  EXPECT_EQ(numbering.island_start, (std::vector<Index>{0, 2, 4}));
}

TEST(Numbering, FreePointsAreNoIslandsAndComeAfterThem) {
  // Points 3 and 0 are free, 1 - 2 is a rod, and 4 is a support.
  System system = make_system(5, {{1, 2}});
  system.supports = {{"", {4}, {}}};

  const Numbering numbering = number(system);

  EXPECT_EQ(numbering.num_islands(), 1U);
  EXPECT_EQ(numbering.num_moving, 4U);
  EXPECT_EQ((std::set<Index>{numbering.user_point[0], numbering.user_point[1]}), (std::set<Index>{1, 2}));
  EXPECT_EQ((std::vector<Index>(numbering.user_point.begin() + 2, numbering.user_point.end())),
            (std::vector<Index>{0, 3, 4}));
}

TEST(Numbering, RowsOfOneMemberStaySideBySide) {
  // Two points on a circle (2 rows each) are joined by a rod.
  System system = make_system(2, {{0, 1}});
  system.constraints.insert(system.constraints.begin(), Circles{"", {0, 1}, {}, Vector3{0.0, 0.0, 1.0}, {}});

  const Numbering numbering = number(system);

  for (std::size_t member = 0; member < 2; ++member) {
    const auto row = static_cast<std::size_t>(numbering.member_row[member]);
    EXPECT_EQ(numbering.user_row[row], static_cast<Index>(2 * member));
    EXPECT_EQ(numbering.user_row[row + 1], static_cast<Index>(2 * member + 1));
  }
  EXPECT_EQ(numbering.user_row[static_cast<std::size_t>(numbering.member_row[2])], 4);
}

TEST(Numbering, RowsBetweenSupportsAreIdleAndComeLast) {
  // In (0) - (1) - 2 - 3 the first rod joins two supports.
  System system = make_system(4, chain(4));
  system.supports = {{"", {0, 1}, {}}};

  const Numbering numbering = number(system);

  EXPECT_EQ(numbering.num_rows(), 3U);
  EXPECT_EQ(numbering.first_idle_row(), 2U);
  EXPECT_EQ(numbering.user_row.back(), 0);
}

TEST(Numbering, SystemWithoutConstraintsHasNoIslands) {
  const Numbering numbering = number(make_system(3, {}));

  EXPECT_EQ(numbering.num_islands(), 0U);
  EXPECT_EQ(numbering.num_rows(), 0U);
  EXPECT_EQ(numbering.num_moving, 3U);
}

}  // namespace
}  // namespace tanor
