#pragma once

#include <cstddef>
#include <span>

#include "schur/lane_plan.hpp"
#include "schur/lane_transfers.hpp"

namespace tanor::detail {

/// The numbers of a group in the arrays of the system. Lists [place or rod][lane] are as in LanePlan; numbers that
/// follow one another in memory in each lane are moved as sequences.
class GroupTransfers {
 public:
  struct Places {
    Sequences points, rows, blocks;
    Sequences own_points;  ///< those of the first places that are written in all lanes
  };

  /// Keeps references. `places` are those of all groups; those of the next one are prefetched. `blocks` [rod][lane] are
  /// those of all rods.
  GroupTransfers(const LanePlan& plan, std::size_t group, std::span<const Places> places, const Index* blocks)
      : group_(plan.groups[group]),
        places_(places[group]),
        next_(group + 1 < places.size() ? &places[group + 1] : nullptr),
        points_(plan.point.data() + num_lanes * group_.first_place),
        rows_(plan.row.data() + num_lanes * group_.first_rod),
        blocks_(blocks + num_lanes * group_.first_rod) {}

  const Index* point_list() const { return points_; }  ///< ~point if it is not to be written
  void read_points(const double* from, Pack3<>* to) const;
  void write_points(const Pack3<>* from, double* to) const;
  /// Adds numbers to points, of which no two lanes have the same one.
  void add_points(const Pack3<>* from, double* to) const;
  void read_rows(const double* from, Pack<>* to) const;
  void write_rows(const Pack<>* from, double* to) const;
  void read_blocks(const double* from, Pack3<>* to) const;
  void write_blocks(const Pack3<>* from, double* to) const;
  /// Returns the block, or the number, of a rod in one lane that has a member.
  Vec3 block(const double* blocks, std::size_t rod, std::size_t lane) const;
  double row(const double* rows, std::size_t rod, std::size_t lane) const {
    return rows[rows_[rod * num_lanes + lane]];
  }

  /// Prefetches what the next group will read or write, while something else is computed.
  void call_for_points(const double* points) const {
    if (next_ != nullptr) call_for(points, next_->points, 3);
  }
  void call_for_blocks(const double* blocks) const {
    if (next_ != nullptr) call_for(blocks, next_->blocks, 3);
  }
  const Places* next() const { return next_; }

 private:
  const LaneGroup& group_;
  const Places& places_;
  const Places* next_;
  const Index *points_, *rows_, *blocks_;
};

}  // namespace tanor::detail
