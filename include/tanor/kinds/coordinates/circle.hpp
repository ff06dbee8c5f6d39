#pragma once

#include <limits>
#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// The angle around the circle's axis n, rad, from e1 towards n x e1; e1 is the part orthogonal to n of the coordinate
/// axis that n is farthest from (and does not turn into) at the start.
struct CircleCoordinates {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction center{};
  VectorFunction normal{};
  Parameter radius{};
};

template <>
struct KindOf<CircleCoordinates> {
  static constexpr std::string_view name = "circle";
  static constexpr auto members = &CircleCoordinates::points;
  static constexpr std::tuple fields{
      FieldOf("center", &CircleCoordinates::center, {.unit = "m", .role = FieldRole::Center, .is_required = true}),
      FieldOf("normal", &CircleCoordinates::normal, {.role = FieldRole::Direction, .is_required = true}),
      FieldOf("radius", &CircleCoordinates::radius, {.unit = "m", .range = ValueRange::positive})};

  template <class Points>
  static const char* complaint(const CircleCoordinates& group, const ClockOf<double>& now, const Points& r,
                               std::size_t) {
    const TripleOf<double> normal = now(group.normal), arm = r[0] - now(group.center);
    constexpr double rounding = 8.0 * std::numeric_limits<double>::epsilon();
    const bool is_initial = group.radius.is_initial();
    if (norm(cross(normal, arm)) > (is_initial ? rounding * norm(normal) * norm(arm) : 0.0)) return nullptr;
    return is_initial ? "it is on the axis: the initial radius is 0; a radius is positive"
                      : "it is on the axis and has no angle there";
  }
  static std::size_t num_coordinates(const CircleCoordinates& group) { return group.points.size(); }
};

}  // namespace tanor
