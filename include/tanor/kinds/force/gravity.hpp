#pragma once

#include <string>

#include <tanor/kinds/kind.hpp>

namespace tanor {

struct Gravity {
  std::string name{};
  Vector3 acceleration{};  ///< m/s^2
};

template <>
struct KindOf<Gravity> {
  static constexpr std::string_view name = "gravity";
  static constexpr std::tuple fields{
      FieldOf("acceleration", &Gravity::acceleration, {.unit = "m/s^2", .is_required = true})};
};

}  // namespace tanor
