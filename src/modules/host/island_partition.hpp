#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <set>
#include <span>
#include <vector>

#include "host/dyadic_sums.hpp"
#include "host/part_history.hpp"

namespace tanor::detail {

/// The division of a host's islands into parts that are planned together. All islands are one part, until `cut` limits
/// what a part holds.
///
/// Islands within that limit of points and rows are put together by their keys. A part holds all those with keys in the
/// largest interval [k 2^m, (k + 1) 2^m) whose sum is within the limit. A larger island is a part by itself. So the
/// parts do not depend on how the constraints came together, and an edit divides anew only the parts of the islands
/// that it touches, with those neighbours that now belong together with them.
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
  /// Limits parts of several islands to this many points and rows from now on.
  void cut(std::int64_t most_of_part);
  std::int64_t most_of_part() const { return most_of_part_; }
  /// Starts anew after points and constraints were renumbered; all of them are new.
  void restart();
  /// True if the islands were divided before and something has changed since.
  bool has_edits() const;

  /// Divides what has changed. What the old parts knew goes to `history` and to the new parts.
  void divide_changes(PartHistory* history);

  static constexpr std::int64_t no_limit = std::numeric_limits<std::int64_t>::max();

 private:
  /// Islands on their way from old parts to new ones.
  struct Pool {
    PartHistory& history;
    std::vector<HostPart*> old{};
    HostPart all{};  // contents of `old`, and what is new
  };

  HostPart* part_at(Index key) const { return part_of_key_[static_cast<std::size_t>(key)]; }
  Index key_of(ConstraintId id) const;
  void collect_changes(Pool* pool);
  void take_in(HostPart* part, Pool* pool);
  void find_islands(HostPart* all);
  void weigh(const std::vector<HostIsland>& islands, int sign);
  bool take_in_neighbours(Pool* pool, const std::vector<Index>& keys);
  bool take_in_interval(Pool* pool, DyadicSums::Interval interval, bool holds_pool);
  void divide(Pool* pool);

  const HostPoints& points_;
  const Inventory& inventory_;
  std::int64_t most_of_part_ = no_limit;
  std::vector<std::unique_ptr<HostPart>> parts_;  // ascending by key
  // [point]
  std::vector<Index> key_of_point_;  // key of the point's island; -1 for supports
  std::vector<HostPart*> part_of_key_;
  std::vector<Index> place_;  // scratch: place of the island with that key in a list
  DyadicSums sums_;           // by key, of islands that share parts
  std::set<Index> touched_;   // keys of islands that have changed
  std::vector<Index> new_points_;
  ConstraintId first_new_ = 0;  // constraints from this id on have no part yet
};

}  // namespace tanor::detail
