#include "picture/camera.hpp"

#include <algorithm>
#include <cmath>

namespace tanor::picture {

namespace {

constexpr double margin = 1.04;
constexpr double tan_of_half_angle = 0.24;  // vertical; the perspective spans 27 degrees in all

}  // namespace

Camera::Camera(const Eye& eye, std::span<const Vec3> places, double radius, const Area& area)
    : eye_(eye), center_x_(area.left + 0.5 * area.width), center_y_(area.top + 0.5 * area.height) {
  const bool sees_depth = eye.is_perspective;
  const double high = sees_depth ? tan_of_half_angle / margin : 0.0, wide = high * area.width / area.height;
  // A point p is inside the view of an eye at (x, y, z) if |p_x - x| <= wide (z - p_z), and likewise for y with high.
  double left = -HUGE_VAL, right = -HUGE_VAL, low = -HUGE_VAL, top = -HUGE_VAL, front = -HUGE_VAL, rear = -HUGE_VAL;
  for (const Vec3& place : places) {
    const double x = dot(eye.right, place), y = dot(eye.up, place), z = dot(eye.back, place);
    right = std::max(right, x + radius + wide * (z + radius));
    left = std::max(left, radius - x + wide * (z + radius));
    top = std::max(top, y + radius + high * (z + radius));
    low = std::max(low, radius - y + high * (z + radius));
    front = std::max(front, z + radius);
    rear = std::max(rear, radius - z);
  }
  double distance = front + (front + rear);  // in front of everything
  if (sees_depth) {
    constexpr double least = 0.3;  // from the eye to the nearest ball; nearer ones would not look round
    distance = std::max({front + least, 0.5 * (left + right) / wide, 0.5 * (low + top) / high});
    scale_ = 2.0 * tan_of_half_angle / area.height;
  } else {
    scale_ = margin * std::max((left + right) / area.width, (low + top) / area.height);
  }
  position_ = 0.5 * (right - left) * eye.right + 0.5 * (top - low) * eye.up + distance * eye.back;
  nearest_ = distance - front;
  farthest_ = distance + rear;
}

Vec3 Camera::turn(Vec3 place) const {
  return turn_direction(place - position_);
}

Ray Camera::ray(double x, double y) const {
  const double u = (x - center_x_) * scale_, v = (center_y_ - y) * scale_;
  return eye_.is_perspective ? Ray{{}, {u, v, 1.0}} : Ray{{u, v, 0.0}, {0.0, 0.0, 1.0}};
}

std::array<double, 2> Camera::project(Vec3 turned) const {
  const double side = pixel(turned.z);
  return {center_x_ + turned.x / side, center_y_ - turned.y / side};
}

std::array<double, 4> Camera::bound(Vec3 c, double r) const {
  const double near = pixel(std::max(c.z - r, 1e-3)), far = pixel(c.z + r);
  const auto least = [&](double x) { return std::min((x - r) / near, (x - r) / far); };
  const auto most = [&](double x) { return std::max((x + r) / near, (x + r) / far); };
  return {center_x_ + least(c.x), center_x_ + most(c.x), center_y_ - most(c.y), center_y_ - least(c.y)};
}

}  // namespace tanor::picture
