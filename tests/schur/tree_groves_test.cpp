/// Groves hold each tree and each batch once, and no batch has branches of two groves.

#include "schur/tree_groves.hpp"

#include <algorithm>
#include <optional>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "linearised.hpp"

namespace tanor {
using namespace detail;
namespace {

/// A backbone of points, each with a chain of `length` rods.
struct Comb {
  int num_teeth, length = 5;
};
void add_comb(const Comb& comb, System* system, Rods* rods) {
  Index before = -1;
  for (int tooth = 0; tooth < comb.num_teeth; ++tooth) {
    const auto root = static_cast<Index>(system->masses.size());
    if (before >= 0) rods->pairs.push_back({before, root});
    before = root;
    for (int k = 0; k <= comb.length; ++k) {
      const double x = tooth, y = k, z = static_cast<double>(root);
      system->positions.insert(system->positions.end(), {x, y, z});
      system->velocities.insert(system->velocities.end(), 3, 0.0);
      system->masses.push_back(1.0);
      if (k > 0) rods->pairs.push_back({root + k - 1, root + k});
    }
  }
}

struct Groves {
  std::vector<RodTree> trees;
  std::vector<Grove> groves;
};

/// Lists the groves of combs, and checks what holds for all groves.
Groves find_groves(const std::vector<Comb>& combs) {
  System system;
  Rods rods;
  for (const Comb& comb : combs) add_comb(comb, &system, &rods);
  system.constraints = {rods};
  const Linearised inner(system, 0.0, system.positions, system.velocities);
  const RodRows rows(inner.constraints, inner.numbering.num_rows());
  Groves result;
  for (std::size_t island = 0; island + 1 < inner.numbering.island_start.size(); ++island) {
    std::optional<RodTree> tree = RodTree::read(rows, inner.numbering, static_cast<Index>(island));
    if (tree) result.trees.push_back(*tree);
  }
  EXPECT_EQ(result.trees.size(), combs.size());
  const EqualBranches branches(result.trees);
  result.groves = list_groves(result.trees, branches);

  std::multiset<std::size_t> trees, batches;
  std::size_t num_rods = 0;
  for (const Grove& grove : result.groves) {
    trees.insert(grove.trees.begin(), grove.trees.end());
    batches.insert(grove.batches.begin(), grove.batches.end());
    num_rods += grove.num_rods;
    for (const std::size_t batch : grove.batches) {
      for (const Index point : branches.batches[batch].first_point) {
        EXPECT_EQ(std::ranges::count_if(grove.trees,
                                        [&](std::size_t tree) {
                                          const RodTree& own = result.trees[tree];
                                          return own.first_point <= point && point < own.end_point;
                                        }),
                  1);
      }
    }
  }
  for (std::size_t tree = 0; tree < result.trees.size(); ++tree) EXPECT_EQ(trees.count(tree), 1);
  for (std::size_t batch = 0; batch < branches.batches.size(); ++batch) EXPECT_EQ(batches.count(batch), 1);
  EXPECT_EQ(num_rods, rods.pairs.size());
  return result;
}

TEST(TreeGroves, TreesWithoutEqualBranchesStandAlone) {
  EXPECT_EQ(find_groves({{16, 3}, {5, 0}, {4, 1}}).groves.size(), 3);
}

/// A shape that each tree has once fills the lanes of a batch with eight trees, and other shapes end where it ends.
TEST(TreeGroves, EqualTreesShareBatchesWithSevenOthersAtMost) {
  for (const int num_teeth : {9, 12, 16, 23}) {
    const Groves found = find_groves(std::vector<Comb>(64, Comb{num_teeth}));
    EXPECT_GE(found.groves.size(), 8);
    for (const Grove& grove : found.groves) EXPECT_LE(grove.trees.size(), 8) << num_teeth;
  }
}

TEST(TreeGroves, TreesOfAllSizesKeepTheirBatches) {
  EXPECT_GE(find_groves({{3}, {30}, {7}, {12}, {1}, {19}, {64}, {5}, {8}, {8}, {2}}).groves.size(), 1);
}

TEST(TreeGroves, TreesWithTooFewBranchesHaveNoBatches) {
  const Groves found = find_groves({{2}});
  ASSERT_EQ(found.groves.size(), 1);
  EXPECT_TRUE(found.groves[0].batches.empty());
}

}  // namespace
}  // namespace tanor
