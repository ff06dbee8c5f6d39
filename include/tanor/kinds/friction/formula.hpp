#pragma once

#include <string>
#include <vector>

#include <tanor/kernel.hpp>
#include <tanor/kinds/kind.hpp>

namespace tanor {

/// A user's own law of position, sliding velocity, time and the multipliers of the guides at the point, from
/// make_friction_kernel.
struct UserFriction {
  std::string name{};
  std::vector<std::string> at{};
  FrictionKernel kernel{};
  VectorFunction velocity{};
};

template <>
struct KindOf<UserFriction> {
  static constexpr std::string_view name = "formula";
  static constexpr std::tuple fields{FieldOf("velocity", &UserFriction::velocity, {.unit = "m/s"})};
};

}  // namespace tanor
