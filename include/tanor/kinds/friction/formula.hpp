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

  static int num_multipliers(const UserFriction& law) { return law.kernel.num_multipliers; }
  static bool is_thread_safe(const UserFriction& law) { return law.kernel.thread_safe; }
  /// Computes tau, N, of points that slide, and its derivative in their multipliers if that is wanted.
  static void forces(const UserFriction& law, const FrictionBatch& batch) {
    law.kernel.evaluate(law.kernel.context.get(), batch);
  }

  template <class Check>
  static void check(const UserFriction& law, const Check& check) {
    if (law.kernel.evaluate == nullptr) check.fail("/law", "is missing: there is no function to call");
  }
};

}  // namespace tanor
