#pragma once

#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

struct ConstantForce {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction force{};  ///< N on each point
};

template <>
struct KindOf<ConstantForce> {
  static constexpr std::string_view name = "constant";
  static constexpr auto members = &ConstantForce::points;
  static constexpr std::tuple fields{FieldOf("force", &ConstantForce::force, {.unit = "N", .is_required = true})};
};

}  // namespace tanor
