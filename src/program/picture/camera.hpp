#pragma once

#include <array>
#include <span>

#include "base/vec3.hpp"

namespace tanor::picture {
using namespace detail;

/// The direction from which the middle of a motion is seen.
struct Eye {
  Vec3 right, up, back;  ///< orthonormal; `back` points from the middle to the eye
  bool is_perspective = true;
};

/// The part of the picture that shows the motion, pixels.
struct Area {
  double left = 0.0, top = 0.0, width = 1.0, height = 1.0;
};

/// A ray o + depth * d through a point of the picture.
struct Ray {
  Vec3 origin, direction;
};

/// The projection from space to the picture. Turned positions have the coordinates (right, up, depth).
class Camera {
 public:
  /// Places the eye so that balls of the given radius at the given positions fill the area.
  Camera(const Eye& eye, std::span<const Vec3> places, double radius, const Area& area);

  Vec3 turn(Vec3 place) const;
  Vec3 turn_direction(Vec3 v) const { return {dot(eye_.right, v), dot(eye_.up, v), -dot(eye_.back, v)}; }
  Ray ray(double x, double y) const;
  /// Returns the point of a turned position in the picture, pixels.
  std::array<double, 2> project(Vec3 turned) const;
  /// Returns the bounds of a turned sphere in the picture: least x, most x, least y, most y.
  std::array<double, 4> bound(Vec3 center, double radius) const;
  /// Returns the side of a pixel at a depth.
  double pixel(double depth) const { return eye_.is_perspective ? depth * scale_ : scale_; }

  double nearest() const { return nearest_; }  ///< depths between which all positions lie
  double farthest() const { return farthest_; }
  double middle_depth() const { return 0.5 * (nearest_ + farthest_); }

 private:
  Eye eye_;
  Vec3 position_;  ///< position of the eye
  double center_x_, center_y_;
  double nearest_ = 0.0, farthest_ = 0.0;
  double scale_ = 1.0;  ///< side of a pixel at depth 1
};

}  // namespace tanor::picture
