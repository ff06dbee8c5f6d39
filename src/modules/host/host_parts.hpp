#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <tanor/constrainer.hpp>

#include "base/memory.hpp"
#include "base/parallel.hpp"
#include "base/saved_frame.hpp"
#include "host/island_partition.hpp"

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
  /// Returns the self-stress of Solution, [equations], where the last call stood.
  std::vector<double> find_self_stress();
  /// Returns the text of a part's outcome with the host's names in it.
  std::string with_names(std::size_t part, const std::string& text) const { return with_names(*parts()[part], text); }

  /// Returns what the parts remember from call to call as bytes: "tanor co", the numbers of the format and of the byte
  /// order, a fingerprint of points and constraints, the numbers, and a checksum of everything before.
  std::vector<std::byte> save();
  /// Restores what `save` saved. Throws InputError if the bytes are of another kind or damaged, or belong to other
  /// points or constraints.
  void restore(std::span<const std::byte> bytes);

 private:
  std::span<const std::unique_ptr<HostPart>> parts() const { return partition_.parts(); }
  std::string with_names(const HostPart& part, const std::string& text) const {
    return inventory_.with_host_names(part.members, text);
  }
  void cut(bool is_cut);
  void rename_points(const std::vector<Index>& of_host, std::size_t size);
  std::size_t plan_changes();
  std::unique_ptr<ConstrainedHost> make_host(HostPart* part);
  System make_system_of(HostPart* part);
  SavedHeader header() const;
  void exchange_memory(Memory& memory);
  void summarise();

  HostPoints points_;
  Inventory inventory_;
  std::optional<PeriodicCell> cell_;
  const SolverOptions options_;
  const Parallel parallel_;
  IslandPartition partition_{points_, inventory_};
  PartHistory history_{&points_, inventory_};
  bool has_changed_ = true;  // since the last plan
  std::size_t num_edits_ = 0;
  std::vector<std::size_t> large_, small_;  // numbers of parts
  std::vector<PartReport> reports_;         // [part] of the last call
  std::vector<Index> supports_;
  std::vector<Index> local_;  // scratch [point]: its number in the part that is planned
  PlanSummary summary_;
};

}  // namespace tanor::detail
