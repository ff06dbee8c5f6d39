#pragma once

#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// Two numbers of a stereographic chart around the present place, rad near there: no poles.
struct SphereCoordinates {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction center{};
  Parameter radius{};
};

template <>
struct KindOf<SphereCoordinates> {
  static constexpr std::string_view name = "sphere";
  static constexpr auto members = &SphereCoordinates::points;
  static constexpr std::tuple fields{
      FieldOf("center", &SphereCoordinates::center, {.unit = "m", .role = FieldRole::Center, .is_required = true}),
      FieldOf("radius", &SphereCoordinates::radius, {.unit = "m", .range = ValueRange::positive})};

  template <class Points>
  static const char* complaint(const SphereCoordinates& group, const ClockOf<double>& now, const Points& r,
                               std::size_t) {
    if (norm(r[0] - now(group.center)) > 0.0) return nullptr;
    return group.radius.is_initial() ? "it is at the center: the initial radius is 0; a radius is positive"
                                     : "it is at the center and has no direction there";
  }
  static std::size_t num_coordinates(const SphereCoordinates& group) { return 2 * group.points.size(); }
};

}  // namespace tanor
