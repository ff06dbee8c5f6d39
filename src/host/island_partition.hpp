#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <set>
#include <span>
#include <vector>

#include "host/dyadic_sums.hpp"
#include "host/part_history.hpp"

namespace tanor {

/// Which islands of a host are planned together: all of them, until `cut` limits what a part holds.
///
/// Islands of no more than that many points and rows are put together by their keys: those of a part are all with keys
/// in the largest interval [k 2^m, (k + 1) 2^m) that has no more in it. A larger island is a part by itself. So parts
/// are the same however the constraints came together, and an edit divides anew the parts of the islands that it
/// touches, no others.
class IslandPartition {
 public:
  /// Both outlive it. All moving points are new, all constraints too.
  IslandPartition(const HostPoints& points, const Inventory& inventory);

  /// Ascending by key. Those without a plan are new.
  std::span<const std::unique_ptr<HostPart>> parts() const { return parts_; }
  /// The part that a constraint has; null: it has none yet, or the part is going to be divided anew.
  HostPart* part_of(ConstraintId id) const { return id < first_new_ ? part_at(key_of(id)) : nullptr; }

  // ---- what the next `divide_changes` divides anew ----

  /// Points that have come.
  void add_points(std::span<const Index> points);
  /// Points without a number of the host's have left.
  void drop_left_points();
  void touch(Index key) { touched_.insert(key); }
  void touch_point(Index point);
  void touch_constraint(ConstraintId id);
  void touch_all();
  /// From now on parts hold no more points and rows than that.
  void cut(std::int64_t most_of_part);
  std::int64_t most_of_part() const { return most_of_part_; }
  /// Points and constraints have other numbers: all is new.
  void restart();
  /// Whether the islands were divided before and something has changed since.
  bool has_edits() const;

  /// What the old parts knew goes to `history` and to the new ones.
  void divide_changes(PartHistory* history);

  static constexpr std::int64_t no_limit = std::numeric_limits<std::int64_t>::max();

 private:
  /// Islands on their way from old parts to new ones.
  struct Pool {
    PartHistory& history;
    std::vector<HostPart*> old{};
    HostPart all{};  // their contents
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
  std::vector<std::unique_ptr<HostPart>> parts_;  // by key
  // [point]
  std::vector<Index> key_of_point_;  // of its island; supports: -1
  std::vector<HostPart*> part_of_key_;
  std::vector<Index> place_;  // scratch: of the island with that key in a list
  DyadicSums sums_;           // by key, of islands that share parts
  std::set<Index> touched_;   // keys of islands that have changed
  std::vector<Index> new_points_;
  ConstraintId first_new_ = 0;  // from it on they have no part yet
};

}  // namespace tanor
