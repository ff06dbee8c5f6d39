#pragma once

#include <vector>

#include "report/stored_frame.hpp"

namespace tanor::report {

/// What the pictures of one motion have in common, so that they can stand side by side.
struct MotionExtent {
  Vector3 least{}, most{};         ///< the box around all points, and round guides that are not much larger, m
  std::vector<Vector3> outline{};  ///< m, the farthest places in directions all around: what must be in a picture
  double least_tension = 0.0;      ///< N, but for the thirtieth part of outliers; 0 where no rod pushes
  double most_tension = 0.0;       ///< N, likewise; 0 where no rod pulls
  double largest_force = 0.0;      ///< N, of guides, supports and friction, likewise
  bool has_friction = false;       ///< that acts somewhere
  double rod_length = 0.0;         ///< m, that of half of the rods is less; 0: there are none
  std::vector<Vector3> held{};     ///< m, places at which these act
  std::vector<Vector3> forces{};   ///< N, there
};

/// Measures frames of a motion; there must be one.
MotionExtent measure_motion(const std::vector<StoredFrame>& frames);

}  // namespace tanor::report
