#pragma once

#include <limits>

#include "host/host_part.hpp"

namespace tanor {

void add_up(const Counters& more, Counters* sum);

/// What goes over from parts to those that take their place: where the host's points were, the multipliers from which
/// the next step's are guessed, and how much work was done.
class PartHistory {
 public:
  /// Both outlive it. It writes the positions of the points.
  PartHistory(HostPoints* points, const Inventory& inventory) : points_(*points), inventory_(inventory) {}

  /// The positions := where the host's points were when the last call began.
  void read_positions(HostPart* part);
  /// Reads positions, guesses and counts of a part that is going to be divided anew.
  void read(HostPart* part);
  /// The guesses of old parts become those of their constraints in a new one. Only what is new is checked again.
  void hand_over(HostPart* part) const;
  /// Returns what parts that are no more have counted.
  const Counters& counters() const { return counters_; }

 private:
  HostPoints& points_;
  const Inventory& inventory_;
  Counters counters_;
  double last_h_ = std::numeric_limits<double>::max(), before_h_ = last_h_;  // the last steps, of all parts
};

}  // namespace tanor
