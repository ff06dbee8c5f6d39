#pragma once

/// \file Checks that a constraint and the coordinates of the same name share: both lists of points on one surface or
/// curve. Throw InputError with the JSON pointer of the value.

#include <limits>
#include <span>
#include <string>

#include <tanor/system.hpp>

#include "base/text.hpp"
#include "base/vec3.hpp"
#include "system/value_checks.hpp"

namespace tanor {

[[noreturn]] inline void fail_point(Index point, std::size_t k, const std::string& where, const std::string& problem) {
  throw InputError(element(where + "/points", k), "point " + text(point) + ": " + problem);
}

/// Normal and offset of Planes or PlaneCoordinates.
template <class Group>
void check_plane(const Group& planes, double t, const std::string& where) {
  check_direction(planes.normal, t, where + "/normal", "normal");
  check_parameter(planes.offset, planes.points.size(), Rule::any, t, where + "/offset", "offset");
}

template <class Group>
void check_line(const Group& lines, double t, const std::string& where) {
  check_function(lines.origin, t, where + "/origin", "origin");
  check_direction(lines.direction, t, where + "/direction", "direction");
}

/// `positions`: 3n, of the start.
template <class Group>
void check_sphere(const Group& spheres, std::span<const double> positions, double t, const std::string& where) {
  const Vec3 center = make_vec3(check_function(spheres.center, t, where + "/center", "center"));
  check_parameter(spheres.radius, spheres.points.size(), Rule::positive, t, where + "/radius", "radius");
  if (!spheres.radius.is_initial()) return;
  for (std::size_t k = 0; k < spheres.points.size(); ++k) {
    const Index point = spheres.points[k];
    if (!(norm(load(positions.data(), point) - center) > 0.0)) {
      fail_point(point, k, where, "it is at the center: the initial radius is 0; a radius is positive");
    }
  }
}

template <class Group>
void check_circle(const Group& circles, std::span<const double> positions, double t, const std::string& where) {
  constexpr double rounding = 8.0 * std::numeric_limits<double>::epsilon();
  const Vec3 center = make_vec3(check_function(circles.center, t, where + "/center", "center"));
  const Vec3 normal = make_vec3(check_direction(circles.normal, t, where + "/normal", "normal"));
  check_parameter(circles.radius, circles.points.size(), Rule::positive, t, where + "/radius", "radius");
  if (!circles.radius.is_initial()) return;
  for (std::size_t k = 0; k < circles.points.size(); ++k) {
    // |n x (r - c)| = |n| (distance from the axis), zero up to rounding on the axis
    const Vec3 arm = load(positions.data(), circles.points[k]) - center;
    if (!(norm(cross(normal, arm)) > rounding * norm(normal) * norm(arm))) {
      fail_point(circles.points[k], k, where, "it is on the axis: the initial radius is 0; a radius is positive");
    }
  }
}

}  // namespace tanor
