#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "base/pack.hpp"
#include "evaluate/constraints.hpp"
#include "schur/rod_rows.hpp"

namespace tanor::detail {

/// An island of rods without rings, from its leaves to its root in the inner numbering.
struct RodTree {
  /// A rod that joins a point to the next one towards the root. A support may stand in the child's place.
  struct Rod {
    Index row, child, parent;
  };
  Index first_point = 0, end_point = 0;
  std::vector<Rod> rods;  ///< by row

  std::size_t num_points() const { return static_cast<std::size_t>(end_point - first_point); }
  /// Reads an island. Returns nothing if it has other constraints or rings.
  static std::optional<RodTree> read(const RodRows& rods, const Numbering& numbering, Index island);
};

/// A piece of a tree: a point, its root, with rods below it, the lower ones first. Pieces share points only where the
/// root of one, eliminated before, stands among the points of another one: at a joint.
///
/// Eight pieces stand side by side in the lanes. Rod k joins the point at place k to that at its parent's place; the
/// roots are at place `num_rods`. A shorter piece begins with rods of nobody: their lanes have row -1, and they hang on
/// one place more, behind the roots. Where pieces are too few, the last one fills several lanes.
struct PieceGroup {
  std::size_t num_rods = 0, first_rod = 0, first_place = 0;  ///< starts in the arrays of lanes
  std::size_t first_joint = 0, end_joint = 0;                ///< of JointPlace
  std::size_t num_pieces = 0;
  std::array<Index, num_lanes> tree{};              ///< [lane]
  std::array<bool, num_lanes> has_joint_as_root{};  ///< [lane] false at the root of a tree
  bool have_same_parents = true, is_padded = false, has_supports = false;
  bool follow = true;  ///< points, and rows, of a piece follow one another in memory, and all points are its own

  std::size_t num_places() const { return num_rods + (is_padded ? 2 : 1); }
  bool has_joints() const { return end_joint > first_joint; }
};

/// Says which joints are at a place of a group. A joint has the number of the group and lane whose root it is,
/// num_lanes group + lane.
struct JointPlace {
  std::size_t place;
  std::array<Index, num_lanes> joint;  ///< [lane]; -1 where there is none
};

/// Trees that follow one another, with all groups of their pieces. Groves are solved one after the other, each as long
/// as it is in the cache. The groups of level l are [level_start[l], level_start[l + 1]); they wait for lower levels.
struct Grove {
  std::size_t first_tree = 0, end_tree = 0, num_rods = 0;
  std::vector<std::size_t> level_start;

  std::size_t first_group() const { return level_start.front(); }
  std::size_t end_group() const { return level_start.back(); }
};

/// Trees cut into pieces.
struct TreePieces {
  std::vector<RodTree> trees;
  std::vector<PieceGroup> groups;
  std::vector<Grove> groves;
  std::vector<Index> parent;  ///< [rod][lane] place in the group
  std::vector<Index> row;     ///< [rod][lane]
  std::vector<Index> point;   ///< [place][lane]; ~point where the motion of the point is not the piece's to write
  std::vector<JointPlace> joints;
  std::size_t num_rods = 0;

  TreePieces(std::vector<RodTree> trees, std::size_t num_moving);
  std::size_t num_slots() const { return parent.size() / num_lanes; }
  std::size_t num_places() const { return point.size() / num_lanes; }
  /// Returns how many of all lanes of rods have one.
  double fullness() const { return static_cast<double>(num_rods) / static_cast<double>(parent.size()); }
  /// Takes trees out of `islands`: all if `eagerly` is true, else those that leave few lanes empty, of several pieces
  /// each by itself, of one piece all together. The answer and the bits of a tree do not depend on the order of
  /// islands.
  static TreePieces take(const RodRows& rods, const Numbering& numbering, bool eagerly, std::vector<Index>* islands);
};

}  // namespace tanor::detail
