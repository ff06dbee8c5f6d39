#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "schur/equal_branches.hpp"

namespace tanor {

/// Trees whose branches share batches with those of no other tree. Groves are solved one after the other, each as long
/// as it is in the cache.
struct Grove {
  std::vector<std::size_t> trees, batches;
  std::size_t num_rods = 0;
};

/// Lists the groves by their first trees.
std::vector<Grove> list_groves(std::span<const RodTree> trees, const EqualBranches& branches);

}  // namespace tanor
