#pragma once

#include <string>
#include <vector>

#include <tanor/kernel.hpp>
#include <tanor/kinds/kind.hpp>

namespace tanor {

/// A user's own f(r, v, t) on each point, from formula_force. It has no potential: all that it does is work.
struct FormulaForce {
  std::string name{};
  std::vector<Index> points{};
  ForceKernel kernel{};
};

template <>
struct KindOf<FormulaForce> {
  static constexpr std::string_view name = "formula";
  static constexpr auto members = &FormulaForce::points;
  static constexpr std::tuple<> fields{};
};

}  // namespace tanor
