#pragma once

#include <cmath>
#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// Two lengths along two unit vectors of the plane normal.r = offset, m.
struct PlaneCoordinates {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction normal{};
  Parameter offset = 0.0;
};

template <>
struct KindOf<PlaneCoordinates> {
  static constexpr std::string_view name = "plane";
  static constexpr auto members = &PlaneCoordinates::points;
  static constexpr std::tuple fields{
      FieldOf("normal", &PlaneCoordinates::normal, {.role = FieldRole::Direction, .is_required = true}),
      FieldOf("offset", &PlaneCoordinates::offset, {.unit = "m"})};

  static double leverage(const PlaneCoordinates& planes, double t, double) {
    const auto n = planes.normal(t);
    return 1.0 / std::hypot(n[0].value(), n[1].value(), n[2].value());
  }
  static std::size_t num_coordinates(const PlaneCoordinates& group) { return 2 * group.points.size(); }
};

}  // namespace tanor
