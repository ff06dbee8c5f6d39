#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include <tanor/constrainer.hpp>

#include "base/memory.hpp"
#include "base/parallel.hpp"
#include "host/constrained_host.hpp"
#include "host/dyadic_sums.hpp"
#include "host/inventory.hpp"

namespace tanor {

/// The points of a host by numbers that never change, while the host's own may: at first they are the same. The number
/// of a point that has left is given to the next one that comes.
struct HostPoints {
  std::vector<Index> of_host;     ///< [host's number] the number here
  std::vector<Index> host_point;  ///< [number] the host's; -1: there is none
  std::vector<double> mass;       ///< [number] infinite: a support
  std::vector<double> positions;  ///< [3 number] where parts are planned
  PeriodicCell cell;              ///< of these, where there is one

  std::size_t size() const { return host_point.size(); }
  bool is_support(Index point) const { return !(mass[static_cast<std::size_t>(point)] < infinite_mass); }

  static constexpr double infinite_mass = std::numeric_limits<double>::infinity();
};

/// to [3 numbers] := the host's points; `number` [host's number] says which is which.
void copy_points(const ConstPointArray& from, std::span<const Index> number, double* to);

/// The islands of a host: one part, which fills lanes and threads best, until `expect_edits` or the first edit of what
/// was planned cuts it into parts that are planned one by one.
///
/// An island's key is its smallest point. Islands of no more than `most_of_part` points and rows are put together by
/// their keys: those of a part are all with keys in the largest interval [k 2^m, (k + 1) 2^m) that has no more in it. A
/// larger island is a part by itself. So parts are the same however the constraints came together, and an edit plans
/// the parts of the islands that it touches, no others.
class HostParts {
 public:
  HostParts(HostPoints points, std::optional<PeriodicCell> cell, const SolverOptions& options);
  HostParts(const HostParts&) = delete;  // parts know where their names are
  HostParts& operator=(const HostParts&) = delete;

  const HostPoints& points() const { return points_; }
  const Inventory& inventory() const { return inventory_; }
  const PeriodicCell* cell() const { return cell_ ? &*cell_ : nullptr; }
  std::size_t num_points() const { return points_.of_host.size(); }
  std::span<const Index> supports() const { return supports_; }

  // ---- edits, already checked; the next `plan` plans them ----

  /// On points by their numbers in `points`, see Inventory::add.
  ConstraintId add(Constraint group, std::vector<std::array<int, 3>> images);
  void remove(std::span<const ConstraintId> ids);
  void set_length(ConstraintId id, double length, double rate);
  void set_mass(Index point, double mass);
  /// [host's number] the number of that point, -1: of a new one. Those that are missing have left.
  void renumber(std::vector<Index> of_host, std::span<const double> masses);
  /// Where the host's points are, in the present cell.
  void set_positions(const ConstPointArray& at);
  /// The same from the last call.
  void read_positions();
  /// Throws InputError where it is too small; then nothing has changed.
  void set_cell(const PeriodicCell& cell);

  /// Cuts into parts; the next `plan` plans those that this has touched.
  void expect_edits();
  /// Returns how many islands were planned. Throws InputError where that is impossible; what has changed then waits.
  std::size_t plan();
  const PlanSummary& summary() const { return summary_; }
  Counters counters() const;
  bool closes_ways() const;

  // ---- the parts ----

  std::size_t size() const { return parts_.size(); }
  ConstrainedHost& operator[](std::size_t k) { return *parts_[k]->host; }
  /// body(part, its report) for each part: small ones are shared among the threads, large ones have them all.
  template <class Body>
  void for_each(const Body& body) {
    for (const std::size_t k : large_) body(*parts_[k]->host, &reports_[k]);
    parallel_.for_tasks(small_.size(), [&](std::size_t s) { body(*parts_[small_[s]]->host, &reports_[small_[s]]); });
  }
  std::span<PartReport> reports() { return reports_; }
  RankReport find_rank(const ConstPointArray& positions, double time);
  /// The text of a part's outcome with the host's names in it.
  std::string with_names(std::size_t part, const std::string& text) const { return with_names(*parts_[part], text); }

  /// What parts remember from call to call, and the numbers of points: into `memory` or from it.
  void exchange_memory(Memory& memory);

 private:
  struct Island {
    Index key;
    std::int64_t weight;  // points and rows
  };
  /// Multipliers of the last steps, see StepProjection::exchange_memory.
  struct Guess {
    ConstraintId id;
    std::size_t row;  // of that constraint
    double last, before;
    bool was_checked;  // the host's positions were on the constraint
  };
  struct Part {
    std::vector<Island> islands;        // ascending, like the lists below
    std::vector<Index> moving, places;  // points without and with supports
    std::vector<ConstraintId> members;
    std::vector<Guess> guesses;  // until there is a host
    std::unique_ptr<ConstrainedHost> host;
    bool has_rows = false;                    // the host's numbers of them
    std::size_t first_row = 0, last_row = 0;  // of the first and the last member

    Index key() const { return islands.front().key; }
  };
  /// Islands on their way from old parts to new ones.
  struct Pool {
    std::vector<Part*> old;
    Part all;  // their contents
  };

  static constexpr std::int64_t no_limit = std::numeric_limits<std::int64_t>::max();
  static constexpr std::int64_t most_after_edits = 2048;
  static constexpr std::int64_t least_for_threads = 16384;

  Part* part_of(Index key) const { return part_of_key_[static_cast<std::size_t>(key)]; }
  Index key_of(ConstraintId id) const;
  void touch(Index key);
  void cut(std::int64_t most_of_part);
  void list_points();
  void rename_points(const std::vector<Index>& of_host, std::size_t size);

  std::size_t plan_changes();
  Pool collect_changes();
  void take_in(Part* part, Pool* pool);
  void find_islands(Part* all);
  void weigh(const std::vector<Island>& islands, int sign);
  bool take_in_neighbours(Pool* pool, const std::vector<Index>& keys);
  bool take_in_interval(Pool* pool, DyadicSums::Interval interval, bool holds_pool);
  void divide(Pool* pool);

  void read_positions(Part* part);
  void read_guesses(Part* part);
  void build(Part* part);
  std::unique_ptr<ConstrainedHost> make_host(Part* part);
  System make_system(Part* part);
  void go_on(Part* part) const;
  /// A text of the part with the host's names.
  std::string with_names(const Part& part, const std::string& text) const;
  void number_rows(Part* part) const;
  void set_host_points(const Part& part) const;
  void summarise();

  HostPoints points_;
  Inventory inventory_;
  std::optional<PeriodicCell> cell_;
  const SolverOptions options_;
  const Parallel parallel_;
  std::int64_t most_of_part_ = no_limit;
  std::vector<std::unique_ptr<Part>> parts_;  // by key
  std::vector<std::size_t> large_, small_;    // their numbers
  std::vector<PartReport> reports_;
  PlanSummary summary_;
  Counters left_counters_;                                                   // of parts that are no more
  double last_h_ = std::numeric_limits<double>::max(), before_h_ = last_h_;  // the last steps, of all parts
  std::vector<Index> supports_;
  // [point]
  std::vector<Index> key_of_point_;  // of its island; supports: -1
  std::vector<Part*> part_of_key_;
  std::vector<Index> local_;  // scratch: its number in the part at hand
  DyadicSums sums_;           // by key, of islands that share parts
  std::set<Index> touched_;   // keys of islands that have changed
  std::vector<Index> new_points_;
  ConstraintId first_new_ = 0;  // from it on they have no part yet
  bool has_changed_ = true;
};

}  // namespace tanor
