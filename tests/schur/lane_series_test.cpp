/// The motion of equal islands, of paths beside others, of trees and of what is left is expanded in time. The series
/// are compared order by order with those of the general solver.

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <tanor/motion.hpp>

#include "schur/compare_series.hpp"
#include "schur/lane_series.hpp"

namespace tanor {
using namespace detail;
namespace {

using series::agreement;
using series::compare;

using Pairs = std::vector<std::array<Index, 2>>;

/// Puts islands beside each other, each with its own places, masses and velocities.
class SetOfIslands {
 public:
  explicit SetOfIslands(std::uint32_t seed) : random_(seed) { system_.forces = {Gravity{"g", {0.3, -0.2, -9.81}}}; }

  double draw() { return std::uniform_real_distribution<double>(-1.0, 1.0)(random_); }

  /// Adds an island of so many points. `held` points are supports.
  void add(std::size_t num_points, const Pairs& pairs, const std::vector<Index>& held = {}) {
    const auto first = static_cast<Index>(system_.masses.size());
    for (std::size_t i = 0; i < num_points; ++i) {
      for (int d = 0; d < 3; ++d) system_.positions.push_back(2.0 * draw());
      const bool rests = std::find(held.begin(), held.end(), static_cast<Index>(i)) != held.end();
      for (int d = 0; d < 3; ++d) system_.velocities.push_back(rests ? 0.0 : draw());
      system_.masses.push_back(std::exp(draw()));
    }
    for (const Index point : held) held_.push_back(first + point);
    for (const auto& [i, j] : pairs)
      rods_.pairs.push_back(draw() > 0.0 ? std::array{first + i, first + j} : std::array{first + j, first + i});
  }
  void add_many(int count, std::size_t num_points, const Pairs& pairs, const std::vector<Index>& held = {}) {
    for (int k = 0; k < count; ++k) add(num_points, pairs, held);
  }
  void shift_images() {
    for (std::size_t k = 0; k < rods_.pairs.size(); ++k) rods_.offsets.push_back({draw(), 0.5 * draw(), draw()});
  }
  System finish() {
    system_.constraints.insert(system_.constraints.begin(), rods_);
    if (!held_.empty()) system_.supports = {Support{"held", held_, {}}};
    return system_;
  }
  System& system() { return system_; }

 private:
  std::mt19937 random_;
  System system_;
  Rods rods_{"rods", {}, {}, {}};
  std::vector<Index> held_;
};

Pairs pairs_of_ring(Index size) {
  Pairs result;
  for (Index i = 0; i < size; ++i) result.push_back({i, (i + 1) % size});
  return result;
}
Pairs ring_with_tail(Index size, Index tail) {
  Pairs result = pairs_of_ring(size);
  for (Index i = 0; i < tail; ++i) result.push_back({i == 0 ? 0 : size + i - 1, size + i});
  return result;
}
const Pairs pairs_of_tetrahedron{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
const Pairs pairs_of_star{{0, 1}, {0, 2}, {0, 3}, {1, 4}, {1, 5}};

LaneSeries make_lanes(const System& system) {
  const Workspace work(system, {.threads = 1}, 0.0);
  const Model& model = work.model();
  return {model.system, work.constraints, model.numbering, model.inverse_mass, 1};
}

TEST(LaneSeries, EqualIslandsAgreeWithTheGeneralSolver) {
  for (std::uint32_t seed = 0; seed < 4; ++seed) {
    for (const int count : {8, 13, 21}) {
      SetOfIslands islands(seed);
      islands.add_many(count, 3, pairs_of_ring(3));
      islands.add_many(count, 6, pairs_of_ring(6));
      islands.add_many(count, 8, ring_with_tail(5, 3));
      islands.add_many(count, 4, pairs_of_tetrahedron);
      islands.add_many(count, 6, pairs_of_star);
      const System system = islands.finish();
      ASSERT_TRUE(make_lanes(system).serves_all()) << count;
      EXPECT_LE(compare(system), agreement) << count << ", " << seed;
    }
  }
}

TEST(LaneSeries, EqualIslandsMayHangFromSupports) {
  for (std::uint32_t seed = 0; seed < 4; ++seed) {
    SetOfIslands islands(seed);
    islands.add_many(8, 6, pairs_of_ring(6), {2});
    islands.add_many(8, 6, pairs_of_star, {4, 5});
    islands.add_many(8, 8, ring_with_tail(5, 3), {7});
    const System system = islands.finish();
    ASSERT_TRUE(make_lanes(system).serves_all());
    EXPECT_LE(compare(system), agreement) << seed;
  }
}

TEST(LaneSeries, EqualIslandsKnowTheImagesOfPeriodicPoints) {
  SetOfIslands islands(3);
  islands.add_many(16, 5, pairs_of_ring(5));
  islands.shift_images();
  const System system = islands.finish();
  ASSERT_TRUE(make_lanes(system).serves_all());
  EXPECT_LE(compare(system), agreement);
}

TEST(LaneSeries, MorePassesAgreeToo) {
  for (std::uint32_t seed = 0; seed < 4; ++seed) {
    SetOfIslands islands(seed);
    islands.add_many(8, 8, ring_with_tail(5, 3), {7});
    islands.add_many(9, 4, {{0, 1}, {1, 2}, {2, 3}});
    EXPECT_LE(compare(islands.finish(), 2), agreement) << seed;
  }
}

// ---- trees ----

/// Makes arms from one point, each rod of which ends where two others begin, `depth` rods long.
Pairs pairs_of_dendrimer(int arms, int depth) {
  Pairs result;
  Index first = 0, end = 1;
  for (int level = 0; level < depth; ++level) {
    const Index next = end;
    for (Index from = first; from < next; ++from) {
      for (int branch = 0; branch < (level == 0 ? arms : 2); ++branch) result.push_back({from, end++});
    }
    first = next;
  }
  return result;
}
/// Makes a backbone on each point of which a tree hangs, which a list of parents describes; -1 is the backbone.
Pairs pairs_of_comb(Index teeth, const std::vector<Index>& parents) {
  Pairs result;
  const auto size = static_cast<Index>(parents.size()) + 1;
  for (Index tooth = 0; tooth < teeth; ++tooth) {
    if (tooth > 0) result.push_back({(tooth - 1) * size, tooth * size});
    for (Index k = 1; k < size; ++k)
      result.push_back({tooth * size + parents[static_cast<std::size_t>(k - 1)] + 1, tooth * size + k});
  }
  return result;
}
const std::vector<Index> fork{-1, 0, 0, 2}, lopsided{-1, 0, 1, 0, 3, 3, 5, 5, 5};

void add_tree(const Pairs& pairs, SetOfIslands* islands) {
  islands->add(pairs.size() + 1, pairs);
}
/// Adds a comb that supports hold at every third point of the backbone and at the first point of the next tooth.
void add_held_comb(Index teeth, const std::vector<Index>& parents, SetOfIslands* islands) {
  Pairs pairs = pairs_of_comb(teeth, parents);
  const auto size = static_cast<Index>(parents.size()) + 1;
  std::vector<Index> held;
  const auto hold = [&](Index point) {
    held.push_back(static_cast<Index>(pairs.size()) + 1);
    pairs.push_back({point, held.back()});
  };
  for (Index tooth = 0; tooth + 1 < teeth; tooth += 3) {
    hold(tooth * size);
    hold((tooth + 1) * size + 1);
  }
  islands->add(pairs.size() + 1, pairs, held);
}

TEST(LaneSeries, TreesOfEqualBranchesAgreeWithTheGeneralSolver) {
  for (std::uint32_t seed = 0; seed < 3; ++seed) {
    for (const Pairs& tree : {pairs_of_dendrimer(3, 6), pairs_of_dendrimer(2, 9), pairs_of_comb(16, fork),
                              pairs_of_comb(19, lopsided), pairs_of_comb(40, {-1, 0, 1})}) {
      SetOfIslands islands(seed);
      add_tree(tree, &islands);
      const System system = islands.finish();
      ASSERT_TRUE(make_lanes(system).serves_all());
      EXPECT_LE(compare(system), agreement) << tree.size() << ", " << seed;
    }
  }
}

/// Some of the supports are joined to the roots of branches.
TEST(LaneSeries, TreesMayHangFromSupports) {
  for (std::uint32_t seed = 0; seed < 4; ++seed) {
    SetOfIslands islands(seed);
    add_held_comb(20, lopsided, &islands);
    const System system = islands.finish();
    ASSERT_TRUE(make_lanes(system).serves_all());
    EXPECT_LE(compare(system), agreement) << seed;
  }
}

/// Trees of several sizes share batches, and some stand alone.
TEST(LaneSeries, TreesSideBySideAgreeWithTheGeneralSolver) {
  SetOfIslands islands(1);
  for (const Index teeth : {12, 9, 14, 12, 11, 19, 12}) add_tree(pairs_of_comb(teeth, fork), &islands);
  add_tree(pairs_of_dendrimer(3, 7), &islands);
  add_held_comb(11, lopsided, &islands);
  const System system = islands.finish();
  ASSERT_TRUE(make_lanes(system).serves_all());
  EXPECT_LE(compare(system), agreement);
}

TEST(LaneSeries, TreesKnowTheImagesOfPeriodicPoints) {
  SetOfIslands islands(2);
  add_held_comb(24, fork, &islands);
  islands.shift_images();
  const System system = islands.finish();
  ASSERT_TRUE(make_lanes(system).serves_all());
  EXPECT_LE(compare(system), agreement);
}

/// A further solve finds what a solve in lanes leaves, next to nothing, and the series do not change but for rounding.
TEST(LaneSeries, MorePassesAgreeOnTreesToo) {
  SetOfIslands islands(3);
  add_tree(pairs_of_dendrimer(3, 7), &islands);
  add_held_comb(20, lopsided, &islands);
  const System system = islands.finish();
  ASSERT_TRUE(make_lanes(system).serves_all());
  const series::Expanded once(system);
  for (const int extra_passes : {1, 2}) {
    EXPECT_LE(compare(system, extra_passes), agreement);
    const series::Expanded more(system, extra_passes);
    for (std::size_t k = 0; k < once.coefficients.size(); ++k) {
      double largest = 0.0, difference = 0.0;
      for (std::size_t i = 0; i < once.coefficients[k].size(); ++i) {
        largest = larger(largest, std::abs(once.coefficients[k][i]));
        difference = larger(difference, std::abs(once.coefficients[k][i] - more.coefficients[k][i]));
      }
      EXPECT_LE(difference, 1e-9 * largest) << k;
    }
  }
}

/// All threads work on the large tree together, and each takes some of the others.
TEST(LaneSeries, TreesGiveTheSameBitsOnAnyThreads) {
  SetOfIslands islands(5);
  for (Index k = 0; k < 90; ++k) add_tree(pairs_of_comb(16 + k % 4, lopsided), &islands);
  add_tree(pairs_of_dendrimer(3, 12), &islands);
  const System system = islands.finish();
  ASSERT_TRUE(make_lanes(system).serves_all());
  for (const int extra_passes : {0, 1}) {
    const series::Expanded one(system, extra_passes, {}, 1);
    ASSERT_TRUE(one.outcome.ok()) << one.outcome.what;
    for (const int threads : {2, 3})
      EXPECT_EQ(series::Expanded(system, extra_passes, {}, threads).coefficients, one.coefficients);
  }
}

TEST(LaneSeries, TreesOfFewEqualBranchesAreLeftToTheGeneralSolver) {
  SetOfIslands islands(6);
  add_tree(pairs_of_comb(9, {-1}), &islands);
  EXPECT_FALSE(make_lanes(islands.finish()).serves_some());
}

RC_GTEST_PROP(LaneSeries, RandomTreesAgreeWithTheGeneralSolver, ()) {
  SetOfIslands islands(*rc::gen::arbitrary<std::uint32_t>());
  for (int tree = *rc::gen::inRange(1, 4); tree > 0; --tree) {
    std::vector<Index> parents{-1};
    for (int k = *rc::gen::inRange(2, 20); k > 0; --k)
      parents.push_back(*rc::gen::inRange(0, static_cast<int>(parents.size())));
    const auto teeth = static_cast<Index>(*rc::gen::inRange(8, 30));
    *rc::gen::arbitrary<bool>() ? add_held_comb(teeth, parents, &islands)
                                : add_tree(pairs_of_comb(teeth, parents), &islands);
  }
  const System system = islands.finish();
  RC_ASSERT(compare(system, *rc::gen::inRange(0, 2)) <= agreement);
}

TEST(LaneSeries, TreesMoveAsByStages) {
  SetOfIslands islands(7);
  add_held_comb(19, lopsided, &islands);
  const System system = islands.finish();
  ASSERT_TRUE(make_lanes(system).serves_all());
  Simulation by_series(system, {.method = Method::Taylor, .rtol = 1e-9, .start = StartMode::Project}, {.threads = 1});
  Simulation by_stages(system, {.method = Method::Dop853, .rtol = 1e-9, .start = StartMode::Project}, {.threads = 1});
  for (Simulation* const each : {&by_series, &by_stages}) {
    const Outcome outcome = each->advance_to(0.1);
    ASSERT_TRUE(outcome.ok()) << outcome.what;
  }
  for (std::size_t k = 0; k < system.positions.size(); ++k)
    EXPECT_NEAR(by_series.positions()[k], by_stages.positions()[k], 1e-7);
}

// ---- mixtures ----

/// Makes paths, rings, bodies, islands of a kind of their own, rods whose lengths move, beads on spheres and free
/// points.
System make_mixture(std::uint32_t seed, bool lengths_move) {
  SetOfIslands islands(seed);
  islands.add_many(9, 6, pairs_of_ring(6));
  islands.add_many(3, 7, {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}, {5, 6}});
  islands.add(5, {{0, 1}, {1, 2}, {2, 0}, {2, 3}, {3, 4}, {4, 2}});  // alone, so it has no lane
  islands.add(1, {});
  islands.add_many(8, 4, pairs_of_tetrahedron);
  islands.add(4, {{0, 1}, {1, 2}, {2, 3}}, {0});
  islands.add(2, {});
  const auto first = static_cast<Index>(islands.system().masses.size());
  islands.add(4, {});
  Spheres spheres{"spheres", {first, first + 1}, VectorFunction(0.0, 0.0, 0.0), {}};
  islands.system().constraints.push_back(spheres);
  if (lengths_move) {
    Rods breathing{"breathing", {{first + 2, first + 3}}, {}, {}};
    breathing.length = ScalarFunction::formula("1.5 + 0.1*sin(3*t)");
    islands.system().constraints.push_back(breathing);
    double* const r = &islands.system().positions[3 * static_cast<std::size_t>(first + 2)];
    r[3] = r[0] + 1.5, r[4] = r[1], r[5] = r[2];
  }
  return islands.finish();
}

TEST(LaneSeries, MixturesAgreeWithTheGeneralSolver) {
  for (const bool lengths_move : {false, true}) {
    for (std::uint32_t seed = 0; seed < 6; ++seed) {
      const System system = make_mixture(seed, lengths_move);
      const LaneSeries lanes = make_lanes(system);
      ASSERT_TRUE(lanes.serves_some() && !lanes.serves_all());
      EXPECT_EQ(std::ranges::count(lanes.left_rows(), 1), lengths_move ? 9 : 8);
      EXPECT_EQ(lanes.left_points().size(), 5U + 3U + 4U);
      EXPECT_LE(compare(system), agreement) << seed;
    }
  }
}

RC_GTEST_PROP(LaneSeries, RandomMixturesAgreeWithTheGeneralSolver, ()) {
  SetOfIslands islands(*rc::gen::arbitrary<std::uint32_t>());
  const auto count = [] { return *rc::gen::inRange(0, 20); };
  islands.add_many(count(), 3, pairs_of_ring(3));
  islands.add_many(count(), 4, {{0, 1}, {1, 2}, {2, 3}}, {0});
  islands.add_many(count(), 7, ring_with_tail(4, 3));
  islands.add_many(count(), 6, pairs_of_star, {5});
  islands.add(3, pairs_of_ring(3), {1});
  islands.add(1, {});
  RC_ASSERT(compare(islands.finish()) <= agreement);
}

/// Rods that are given twice make S singular, which the lanes do not see.
TEST(LaneSeries, SingularIslandsAreLeftToTheGeneralSolver) {
  SetOfIslands islands(5);
  islands.add_many(8, 3, pairs_of_ring(3));
  islands.add_many(8, 2, {{0, 1}, {0, 1}});
  const System system = islands.finish();
  ASSERT_TRUE(make_lanes(system).serves_all());
  const series::Expanded expanded(system);
  EXPECT_TRUE(expanded.outcome.ok()) << expanded.outcome.what;
}

/// A plane that turns about the support through which it goes depends on time, and joins supports alone.
TEST(LaneSeries, RowsOfSupportsMayDependOnTime) {
  SetOfIslands islands(6);
  islands.add(4, {{0, 1}, {1, 2}, {2, 3}}, {0});
  System system = islands.finish();
  std::fill_n(system.positions.begin(), 3, 0.0);
  Planes plane{"plane", {0}, {}, {}};
  plane.normal = VectorFunction(ScalarFunction::formula("cos(t)"), ScalarFunction::formula("sin(t)"), 0.0);
  system.constraints.push_back(plane);
  ASSERT_TRUE(make_lanes(system).serves_all());
  Simulation by_series(system, {.method = Method::Taylor, .start = StartMode::Project}, {.threads = 1});
  Simulation by_stages(system, {.method = Method::Dop853, .start = StartMode::Project}, {.threads = 1});
  for (Simulation* const each : {&by_series, &by_stages}) {
    const Outcome outcome = each->advance_to(0.2);
    ASSERT_TRUE(outcome.ok()) << outcome.what;
  }
  for (std::size_t k = 0; k < system.positions.size(); ++k)
    EXPECT_NEAR(by_series.positions()[k], by_stages.positions()[k], 1e-6);
}

TEST(LaneSeries, AnyOtherForceOrAMovingSupportLeavesAllToTheGeneralSolver) {
  System forced = make_mixture(1, false), moving = forced;
  forced.forces.push_back(Drag{"drag", {0}, 0.1});
  moving.supports[0].displacement = VectorFunction(ScalarFunction::formula("0.1*t"), 0.0, 0.0);
  for (const System& system : {forced, moving}) {
    const LaneSeries lanes = make_lanes(system);
    EXPECT_FALSE(lanes.serves_some());
    EXPECT_EQ(lanes.share_left(), 1.0);
  }
}

}  // namespace
}  // namespace tanor
