#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/pack.hpp"
#include "schur/factor_summary.hpp"
#include "schur/island_schedule.hpp"
#include "schur/rod_rows.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// Says how S is eliminated, see lane_kernels.hpp.
enum class Program { Islands, Trees, Paths };

/// Eight members side by side: equal islands of rods, or pieces of trees or of a path. The last of fewer fills lanes.
///
/// A piece of a tree is a point, its root, with rods below it, the lower ones first. Pieces share points only where the
/// root of one, eliminated before, stands among the points of another one: at a joint. Rod k joins the point at place k
/// to that at its parent's place; the roots are at place `num_rods`. A shorter piece begins with rods of nobody: their
/// lanes have row -1, and they hang on one place more, behind the roots.
///
/// Pieces of a path follow one another. Rod k joins the points at the places k and k + 1; the last rod is a separator,
/// the last point the next piece's to write, but for the end of the path. Other lanes have a rod of nobody, row -1.
struct LaneGroup {
  std::size_t num_rods = 0, num_places = 0;
  std::size_t first_rod = 0, first_place = 0, first_factor = 0, first_offset = 0;  ///< starts in the arrays of lanes
  std::size_t first_joint = 0, end_joint = 0;                                      ///< of JointPlace
  std::size_t num_members = 0;
  const IslandSchedule* schedule = nullptr;  ///< of equal islands; null for pieces
  std::array<Index, num_lanes> behind{};     ///< [lane] the lane of the next piece of a path, as in JointPlace, or -1
  std::array<Index, num_lanes> island{};     ///< [lane] that of the member
  std::array<bool, num_lanes> ends_tree{};   ///< [lane] true at the root of a tree
  bool have_same_parents = true, is_padded = false, has_supports = false;
  bool stands_alone = true;  ///< is a grove by itself

  bool has_joints() const { return end_joint > first_joint; }
};

/// The joints at a place of a group. A joint has the number of the group and lane of its root, num_lanes group + lane.
struct JointPlace {
  std::size_t place;
  std::array<Index, num_lanes> joint;  ///< [lane]; -1 where there is none
};

/// Islands of rods in lanes. What is solved at once, while it is in the cache, is a grove: a group that needs no other
/// one, pieces of trees that follow one another, or those of a path. The groups of a level wait for lower levels.
struct LanePlan {
  struct Island {
    Index first_point, end_point;
  };
  Program program = Program::Islands;
  std::vector<Island> islands;
  std::vector<std::unique_ptr<const IslandSchedule>> schedules;  ///< of equal islands
  std::vector<LaneGroup> groups;
  std::vector<std::size_t> level_start{0}, grove_start{0};  ///< the first group of a level; the first level of a grove
  std::vector<std::size_t> island_start{0};  ///< [grove] its first island; its islands follow one another
  std::vector<Index> parent;                 ///< [rod][lane] place in the group, of trees
  std::vector<Index> row;                    ///< [rod][lane]
  std::vector<Index> point;  ///< [place][lane]; ~point where the motion of the point is not the member's to write
  std::vector<JointPlace> joints;
  std::vector<Index> separators;  ///< the lanes, as in JointPlace, of pieces of paths, whose last rods they are
  /// A path or ring has the separators [first, end).
  struct Path {
    std::size_t first_separator, end_separator;
    bool is_ring;
  };
  std::vector<Path> paths;  ///< [island] of paths
  std::size_t num_rods = 0, size_of_factor = 0;
  std::string reason;    ///< as in SchurSolver::Summary
  FactorSummary factor;  ///< what it costs

  bool is_of_paths() const { return program == Program::Paths; }
  bool is_of_trees() const { return program == Program::Trees; }
  std::size_t num_slots() const { return row.size() / num_lanes; }
  std::size_t num_places() const { return point.size() / num_lanes; }
  std::size_t num_groves() const { return grove_start.size() - 1; }
  /// Returns the first group of each level of a grove, then the end.
  std::span<const std::size_t> levels(std::size_t grove) const {
    return std::span(level_start).subspan(grove_start[grove], grove_start[grove + 1] - grove_start[grove] + 1);
  }
  /// Returns how much room a grove takes in arrays of lanes.
  struct Extent {
    std::size_t groups, rods, places;
  };
  Extent extent(std::size_t grove) const {
    const LaneGroup &first = groups[levels(grove).front()], &last = groups[levels(grove).back() - 1];
    return {static_cast<std::size_t>(&last - &first) + 1, last.first_rod + last.num_rods - first.first_rod,
            last.first_place + last.num_places - first.first_place};
  }
  /// Returns how many of all lanes of rods have one.
  double fullness() const { return static_cast<double>(num_rods) / static_cast<double>(row.size()); }

  /// Appends a group with room for its rods and places, and for so many packs of its factor.
  LaneGroup& add(const LaneGroup& given, std::size_t packs_of_factor) {
    LaneGroup& group = groups.emplace_back(given);
    group.first_rod = num_slots();
    group.first_place = num_places();
    group.first_factor = size_of_factor;
    group.first_joint = joints.size();
    row.resize(row.size() + num_lanes * group.num_rods, -1);
    point.resize(point.size() + num_lanes * group.num_places);
    size_of_factor += packs_of_factor;
    return group;
  }
  void end_level() { level_start.push_back(groups.size()); }
  void end_grove() {
    grove_start.push_back(level_start.size() - 1);
    island_start.push_back(islands.size());
  }
};

/// Takes islands of rods out of `islands` and groups them by their topologies. It takes islands of at most
/// `plan::most_rods_of_batch` rods if their topology has little fill and fills half of its lanes or more (long paths:
/// nearly all). If `eagerly` is true, it takes all islands of rods.
LanePlan take_equal_islands(const RodRows& rods, const Numbering& numbering, bool eagerly, std::vector<Index>* islands);

/// Takes the islands that are paths or rings of rods out of `islands`, and cuts them into pieces.
LanePlan take_paths(const RodRows& rods, const Numbering& numbering, bool eagerly, std::vector<Index>* islands);

/// Takes trees of rods out of `islands`: all if `eagerly` is true, else those that leave few lanes empty, of several
/// pieces each by itself, of one piece all together. The bits of a tree do not depend on the order of islands.
LanePlan take_trees(const RodRows& rods, const Numbering& numbering, bool eagerly, std::vector<Index>* islands);

}  // namespace tanor::detail
