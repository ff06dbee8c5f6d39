#pragma once

#include <map>
#include <memory>
#include <set>
#include <span>
#include <vector>

#include "host/host_part.hpp"

namespace tanor::detail {

/// The division of a host's islands into parts that are planned together. All islands are one part until `cut`.
///
/// From then on a part holds the islands whose keys lie in one interval of 1024 numbers. An island of more than 1024
/// points and rows is a part by itself. So the parts do not depend on how the constraints came together, and an edit
/// divides anew only the parts of the islands that it touches, with those to which these belong now.
class IslandPartition {
 public:
  /// Points and inventory outlive it. At first all moving points and all constraints are new.
  IslandPartition(const HostPoints& points, const Inventory& inventory);

  /// The parts, ascending by key. Those without a plan are new.
  std::span<const std::unique_ptr<HostPart>> parts() const { return parts_; }
  /// Returns the part of a constraint, or null if it has none yet or the part is going to be divided anew.
  HostPart* part_of(ConstraintId id) const { return id < first_new_ ? part_at(key_of(id)) : nullptr; }

  // ---- what the next `divide_changes` divides anew ----

  /// Adds points that have come.
  void add_points(std::span<const Index> points);
  /// Drops points that have left, which have no number of the host's.
  void drop_left_points();
  void touch(Index key) { touched_.insert(key); }
  void touch_point(Index point);
  void touch_constraint(ConstraintId id);
  void touch_all();
  /// Cuts the islands into parts from now on, or puts them all into one.
  void cut(bool is_cut);
  bool is_cut() const { return is_cut_; }
  /// Starts anew after points and constraints were renumbered; all of them are new.
  void restart();
  /// True if the islands were divided before and something has changed since.
  bool has_edits() const;

  /// Divides what has changed. What the old parts knew goes to `history` and to the new parts.
  void divide_changes(PartHistory* history);

 private:
  HostPart* part_at(Index key) const { return part_of_key_[static_cast<std::size_t>(key)]; }
  Index key_of(ConstraintId id) const;
  Index slot_of(const HostIsland& island) const;
  void collect_changes(PartHistory* history, HostPart* pool);
  void take_in(HostPart* part, PartHistory* history, HostPart* pool);
  void find_islands(HostPart* pool);
  void divide(HostPart* pool);

  const HostPoints& points_;
  const Inventory& inventory_;
  bool is_cut_ = false;
  std::vector<std::unique_ptr<HostPart>> parts_;  // ascending by key
  std::map<Index, HostPart*> part_of_slot_;       // by the slot of their islands
  // [point]
  std::vector<Index> key_of_point_;  // key of the point's island; -1 for supports
  std::vector<HostPart*> part_of_key_;
  std::vector<Index> place_;  // scratch: place of the island with that key in a list
  std::set<Index> touched_;   // keys of islands that have changed
  std::vector<Index> new_points_;
  ConstraintId first_new_ = 0;  // constraints from this id on have no part yet
};

}  // namespace tanor::detail
