#pragma once

#include <cstddef>
#include <vector>

#include <tanor/constrainer.hpp>

#include "host/incoming_points.hpp"
#include "host/point_transfer.hpp"

namespace tanor::detail {

/// Points of a host that a call moves. Those that are packed in the inner order may be moved in place, and a copy keeps
/// what they were; else the copy is moved, and written to the host once the call has succeeded.
class MovedPoints {
 public:
  /// `transfer` outlives the object. If `keeps_copy` is true, nothing is moved in place.
  MovedPoints(const PointTransfer& transfer, std::size_t size, bool keeps_copy)
      : transfer_(transfer), keeps_copy_(keeps_copy), copy_(size) {}

  /// The points that are moved, [3n] in the inner order.
  double* data() { return moved_; }
  /// Moves the copy, which the caller fills. Returns it.
  double* use_copy();
  /// Moves the host's points. `incoming` copies them, and measures the largest one if `measures` is true.
  void take(const PointArray& host, bool in_place, IncomingPoints* incoming, bool measures = false);
  /// Tells that points were moved, all of which had been copied before.
  void note_moved() { has_moved_ = true; }
  /// Leaves the first `count` inner points in the host's array as they were moved. Returns the largest change if that
  /// is wanted, else 0.
  double give_back(const PointArray& host, std::size_t count, bool measures);
  /// Undoes a move in place. Does nothing after `give_back`.
  void restore();

 private:
  const PointTransfer& transfer_;
  const bool keeps_copy_;
  std::vector<double> copy_;
  double* moved_ = copy_.data();  // that, or the host's
  bool has_moved_ = false;
};

}  // namespace tanor::detail
