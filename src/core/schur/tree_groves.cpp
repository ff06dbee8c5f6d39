#include "schur/tree_groves.hpp"

#include <algorithm>
#include <numeric>

#include "base/disjoint_sets.hpp"

namespace tanor::detail {

std::vector<Grove> list_groves(std::span<const RodTree> trees, const EqualBranches& branches) {
  const auto tree_of = [&](Index point) {
    const auto after = std::ranges::upper_bound(trees, point, {}, &RodTree::first_point);
    return static_cast<Index>(after - trees.begin()) - 1;
  };
  std::vector<Index> parent(trees.size());  // sets of trees whose branches share batches
  std::iota(parent.begin(), parent.end(), Index{0});
  for (const BranchBatch& batch : branches.batches) {
    for (const Index point : batch.first_point) join_sets(parent.data(), tree_of(batch.first_point[0]), tree_of(point));
  }
  std::vector<Grove> result;
  std::vector<std::size_t> number(trees.size());  // by the root of its set
  for (std::size_t tree = 0; tree < trees.size(); ++tree) {
    const auto root = static_cast<std::size_t>(find_root(parent.data(), static_cast<Index>(tree)));
    if (root == tree) {
      number[tree] = result.size();
      result.emplace_back();
    }
    Grove& grove = result[number[root]];
    grove.trees.push_back(tree);
    grove.num_rods += trees[tree].rods.size();
  }
  for (std::size_t batch = 0; batch < branches.batches.size(); ++batch) {
    const Index root = find_root(parent.data(), tree_of(branches.batches[batch].first_point[0]));
    result[number[static_cast<std::size_t>(root)]].batches.push_back(batch);
  }
  return result;
}

TreeGroves::TreeGroves(std::span<const RodTree> trees, const EqualBranches& branches)
    : groves_(list_groves(trees, branches)), rods_before_{0} {
  for (const Grove& grove : groves_) rods_before_.push_back(rods_before_.back() + grove.num_rods);
}

}  // namespace tanor::detail
