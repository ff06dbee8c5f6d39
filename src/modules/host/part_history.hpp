#pragma once

#include <limits>

#include "host/host_part.hpp"

namespace tanor::detail {

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
