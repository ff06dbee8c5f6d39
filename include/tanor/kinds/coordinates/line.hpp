#pragma once

#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// r = origin + q direction/|direction|, one a point, m.
struct LineCoordinates {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction origin{};
  VectorFunction direction{};
};

template <>
struct KindOf<LineCoordinates> {
  static constexpr std::string_view name = "line";
  static constexpr auto members = &LineCoordinates::points;
  static constexpr std::tuple fields{
      FieldOf("origin", &LineCoordinates::origin, {.unit = "m", .role = FieldRole::Place, .is_required = true}),
      FieldOf("direction", &LineCoordinates::direction, {.role = FieldRole::Direction, .is_required = true})};

  static std::size_t num_coordinates(const LineCoordinates& group) { return group.points.size(); }
};

}  // namespace tanor
