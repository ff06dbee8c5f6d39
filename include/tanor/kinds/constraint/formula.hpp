#pragma once

#include <optional>
#include <string>
#include <vector>

#include <tanor/kernel.hpp>
#include <tanor/kinds/kind.hpp>

namespace tanor {

/// A user's own function of the points of a tuple, from user_kernel.hpp or formula_constraint. Supports may take part.
struct UserConstraints {
  std::string name{};
  std::vector<std::vector<Index>> tuples{};
  ConstraintKernel kernel{};
  std::optional<OneSide> side{};
  double restitution = 0.0;
};

/// The kernel is the definition.
template <>
struct KindOf<UserConstraints> {
  static constexpr std::string_view name = "formula";
  static constexpr auto members = &UserConstraints::tuples;
  static constexpr const char* list = "points";
  static constexpr const char* distinct = "the points of a tuple differ";
  static constexpr int rows = 1;
  static constexpr auto fields = one_sided_fields<UserConstraints>;
};

}  // namespace tanor
