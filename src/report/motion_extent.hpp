#pragma once

#include <vector>

#include "report/stored_frame.hpp"

namespace tanor::report {

/// Common properties of all pictures of one motion, so that they can be compared side by side.
struct MotionExtent {
  Vector3 least{}, most{};         ///< box around all points, and around round guides that are not much larger, m
  std::vector<Vector3> outline{};  ///< farthest positions in all directions, m: they must be in a picture
  double least_tension = 0.0;      ///< N, without the extreme 3 % of the rods; 0 if no rod pushes
  double most_tension = 0.0;       ///< N, likewise; 0 if no rod pulls
  double largest_force = 0.0;      ///< N, of guides, supports and friction, likewise
  bool has_friction = false;       ///< true if friction acts somewhere
  double rod_length = 0.0;         ///< median, m; 0 without rods
  std::vector<Vector3> held{};     ///< m, points of attack of the forces
  std::vector<Vector3> forces{};   ///< N, at these points
};

/// Measures the frames of a motion; there must be at least one.
MotionExtent measure_motion(const std::vector<StoredFrame>& frames);

}  // namespace tanor::report
