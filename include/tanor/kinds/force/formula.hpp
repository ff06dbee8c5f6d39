#pragma once

#include <string>
#include <vector>

#include <tanor/kernel.hpp>
#include <tanor/kinds/kind.hpp>

namespace tanor {

/// A user's own f(r, v, t) on each point, from formula_force, or on the points of each tuple, from formula_tuple_force.
/// It has no potential, so that all its effect on the energy is work.
struct FormulaForce {
  std::string name{};
  std::vector<Index> points{};  ///< for kernels of one point
  ForceKernel kernel{};
  std::vector<std::vector<Index>> tuples{};  ///< for kernels of several points
};

template <>
struct KindOf<FormulaForce> {
  static constexpr std::string_view name = "formula";
  static constexpr auto members = &FormulaForce::points;
  static constexpr std::tuple<> fields{};
};

}  // namespace tanor
