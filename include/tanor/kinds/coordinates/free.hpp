#pragma once

#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// q = r, three a point.
struct FreeCoordinates {
  std::string name{};
  std::vector<Index> points{};
};

template <>
struct KindOf<FreeCoordinates> {
  static constexpr std::string_view name = "free";
  static constexpr auto members = &FreeCoordinates::points;
  static constexpr std::tuple<> fields{};
  static std::size_t num_coordinates(const FreeCoordinates& group) { return 3 * group.points.size(); }
};

}  // namespace tanor
