#pragma once

#include <cstddef>
#include <string>
#include <variant>

#include <tanor/system.hpp>

#include "base/text.hpp"

/// \file Constraints that act to one side, as a system describes them.
namespace tanor::detail {

/// Returns the first group of constraints that acts to one side; none is the number of groups.
inline std::size_t find_one_sided(const System& system) {
  const auto has_side = [](const auto& group) {
    if constexpr (requires { group.side; }) return group.side.has_value();
    return false;
  };
  std::size_t g = 0;
  while (g < system.constraints.size() && !std::visit(has_side, system.constraints[g])) ++g;
  return g;
}
inline bool has_sides(const System& system) {
  return find_one_sided(system) < system.constraints.size();
}

/// Throws InputError if a constraint acts to one side; `instead` tells what to do.
inline void refuse_sides(const System& system, const std::string& instead) {
  const std::size_t g = find_one_sided(system);
  if (g < system.constraints.size())
    throw InputError("/constraints/" + text(g), constraint_name(system, g) + " acts to one side; " + instead);
}

}  // namespace tanor::detail
