#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "host/constrained_host.hpp"
#include "host/host_points.hpp"
#include "host/inventory.hpp"

namespace tanor::detail {

/// Points and constraints that are connected. The key is the smallest point.
struct HostIsland {
  Index key;
  std::int64_t weight;  ///< points and rows
};

/// The multipliers of a row in the last two steps, from which the next step's are guessed (see StepProjection).
struct MultiplierGuess {
  ConstraintId id;
  std::size_t row;  ///< number of the row in that constraint
  double last, before;
  bool was_checked;  ///< the host's positions were on the constraint
};

/// Some islands of a host that are planned together, by the numbers of HostPoints; the plan itself is `host`.
struct HostPart {
  std::vector<HostIsland> islands;       ///< ascending, like the lists below
  std::vector<Index> moving, places;     ///< points without and with supports
  std::vector<ConstraintId> members;     ///< its constraints
  std::vector<MultiplierGuess> guesses;  ///< kept until there is a plan
  std::unique_ptr<ConstrainedHost> host;
  bool has_own_threads = false;  ///< if false, it shares them with other parts

  Index key() const { return islands.front().key; }
  /// Gives the plan's rows the numbers that the host has for them now.
  void number_rows(const Inventory& inventory);
  /// Gives the plan's points the numbers that the host has for them now.
  void number_points(const HostPoints& points) const;

 private:
  bool has_rows_ = false;                     // the rows have numbers
  std::size_t first_row_ = 0, last_row_ = 0;  // first rows of the first and the last member
};

void add_up(const Counters& more, Counters* sum);

/// The state that parts hand over to those that take their place: where the host's points were, the multipliers from
/// which the next step's are guessed, and the counts of work.
class PartHistory {
 public:
  /// Points and inventory outlive it. Only the positions of the points are written.
  PartHistory(HostPoints* points, const Inventory& inventory) : points_(*points), inventory_(inventory) {}

  /// Sets the positions to where the host's points were when the last call began.
  void read_positions(HostPart* part);
  /// Reads positions, guesses and counts of a part that is going to be divided anew.
  void read(HostPart* part);
  /// Gives the guesses of old parts to their constraints in a new one. Its positions are checked again unless all of
  /// its rows were checked before.
  void hand_over(HostPart* part) const;
  /// Returns the counts of parts that no longer exist.
  const Counters& counters() const { return counters_; }

 private:
  HostPoints& points_;
  const Inventory& inventory_;
  Counters counters_;
  double last_h_ = std::numeric_limits<double>::max(), before_h_ = last_h_;  // last two steps of all parts
};

}  // namespace tanor::detail
