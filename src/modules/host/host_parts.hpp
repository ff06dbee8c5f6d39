#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <tanor/constrainer.hpp>

#include "base/memory.hpp"
#include "base/parallel.hpp"
#include "host/island_partition.hpp"
#include "host/part_builder.hpp"

namespace tanor::detail {

/// The islands of a host. They are one part, which fills lanes and threads best, until `expect_edits` or the first edit
/// of what was planned cuts it into parts that are planned one by one (see IslandPartition).
class HostParts {
 public:
  HostParts(HostPoints points, std::optional<PeriodicCell> cell, const SolverOptions& options);
  HostParts(const HostParts&) = delete;  // members refer to one another
  HostParts& operator=(const HostParts&) = delete;

  const HostPoints& points() const { return points_; }
  const Inventory& inventory() const { return inventory_; }
  const PeriodicCell* cell() const { return cell_ ? &*cell_ : nullptr; }
  std::size_t num_points() const { return points_.of_host.size(); }
  std::span<const Index> supports() const { return supports_; }

  // ---- edits, already checked; the next `plan` plans them ----

  /// Returns how often constraints or the numbers of points have changed.
  std::size_t num_edits() const { return num_edits_; }
  /// Adds a group on points by their numbers in `points`, see Inventory::add.
  ConstraintId add(Constraint group, std::vector<std::array<int, 3>> images);
  void remove(std::span<const ConstraintId> ids);
  void set_length(ConstraintId id, double length, double rate);
  void set_mass(Index point, double mass);
  /// Renumbers the host's points: `of_host` [host's number] is the number of that point, -1 for a new one. Those that
  /// are missing have left.
  void renumber(std::vector<Index> of_host, std::span<const double> masses);
  /// Sets the host's positions, in the present cell.
  void set_positions(const ConstPointArray& at);
  /// Sets the positions to those with which the last call began.
  void read_positions();
  /// Throws InputError if the cell is too small; then nothing has changed.
  void set_cell(const PeriodicCell& cell);

  /// Cuts the islands into parts of limited size; the next `plan` plans those that have changed.
  void expect_edits();
  /// Returns how many islands were planned. Throws InputError if that is impossible; what has changed then waits.
  std::size_t plan();
  const PlanSummary& summary() const { return summary_; }
  Counters counters() const;

  // ---- the parts ----

  std::size_t size() const { return parts().size(); }
  ConstrainedHost& operator[](std::size_t k) { return *parts()[k]->host; }
  /// Calls body(part, its report) for each part. Small parts are shared among the threads; large ones use them all.
  template <class Body>
  void for_each(const Body& body) {
    for (const std::size_t k : large_) body(*parts()[k]->host, &reports_[k]);
    parallel_.for_tasks(small_.size(), [&](std::size_t s) { body(*parts()[small_[s]]->host, &reports_[small_[s]]); });
  }
  std::span<PartReport> reports() { return reports_; }
  RankReport find_rank(const ConstPointArray& positions, double time);
  /// Returns the text of a part's outcome with the host's names in it.
  std::string with_names(std::size_t part, const std::string& text) const { return with_names(*parts()[part], text); }

  /// Writes what parts remember from call to call, and the numbers of points, to `memory`, or reads it from there.
  void exchange_memory(Memory& memory);

 private:
  std::span<const std::unique_ptr<HostPart>> parts() const { return partition_.parts(); }
  std::string with_names(const HostPart& part, const std::string& text) const;
  void cut(std::int64_t most_of_part);
  void rename_points(const std::vector<Index>& of_host, std::size_t size);
  std::size_t plan_changes();
  void summarise();

  HostPoints points_;
  Inventory inventory_;
  std::optional<PeriodicCell> cell_;
  const Parallel parallel_;
  IslandPartition partition_{points_, inventory_};
  PartBuilder builder_;
  PartHistory history_{&points_, inventory_};
  bool has_changed_ = true;  // since the last plan
  std::size_t num_edits_ = 0;
  std::vector<std::size_t> large_, small_;  // numbers of parts
  std::vector<PartReport> reports_;         // [part] of the last call
  std::vector<Index> supports_;
  PlanSummary summary_;
};

}  // namespace tanor::detail
