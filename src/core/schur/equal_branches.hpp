#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "base/pack.hpp"
#include "base/vec3.hpp"
#include "evaluate/constraints.hpp"
#include "schur/rod_rows.hpp"
#include "schur/tree_kernels.hpp"

namespace tanor::detail {

/// An island of rods without rings, from its leaves to its root in the inner numbering.
struct RodTree {
  Index first_point = 0, end_point = 0;
  std::vector<trees::Rod> rods;  ///< by row; a rod to a support has the support as its child

  std::size_t num_points() const { return static_cast<std::size_t>(end_point - first_point); }
  /// Reads an island. Returns nothing if it has other constraints or rings.
  static std::optional<RodTree> read(const RodRows& rods, const Numbering& numbering, Index island);
};

/// Branches of one shape, eight at once. A branch is a point, its root, with all that hangs on it away from the tree's
/// root. Its points and its rods follow one another in the inner numbering. None of its rods ends at a support.
struct BranchBatch {
  std::size_t shape;
  std::array<Index, num_lanes> first_point{}, first_row{};
  std::size_t first_rod = 0, first_place = 0;  ///< starts of its rods and points in arrays of lanes
};

/// All batches of some trees, and the points that they leave to the trunks.
struct EqualBranches {
  std::vector<std::vector<Index>> parents;  ///< [shape][rod] point of the branch towards its root
  std::vector<BranchBatch> batches;
  std::vector<std::vector<char>> is_inside;  ///< [tree][point] true in a branch, but not at its root

  /// Takes the largest branches first, as many of a shape as fill all lanes.
  explicit EqualBranches(std::span<const RodTree> trees);

  trees::Shape shape(const BranchBatch& batch) const {
    return {parents[batch.shape].data(), parents[batch.shape].size()};
  }
  std::size_t num_rods() const;
  /// Returns the share of a tree's points that stand in lanes.
  double share_in_lanes(std::size_t tree) const;
};

/// The trees among some islands, and their branches.
struct TreesInLanes {
  std::vector<RodTree> trees;
  EqualBranches branches;

  /// Takes trees out of `islands`: those that consist of equal branches for the most part, or all if `eagerly` is true.
  TreesInLanes(const RodRows& rods, const Numbering& numbering, bool eagerly, std::vector<Index>* islands);
};

}  // namespace tanor::detail
