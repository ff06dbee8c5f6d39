#pragma once

#include <string>
#include <vector>

#include <tanor/kernel.hpp>
#include <tanor/kinds/kind.hpp>

namespace tanor {

/// An energy U(r_1 … r_p, t) of each tuple, from user_kernel.hpp or formula_potential: f_i = -dU/dr_i. Supports may
/// take part; the force on them is a load that they carry.
struct Potential {
  std::string name{};
  std::vector<std::vector<Index>> points{};
  PotentialKernel kernel{};
  /// [constant] Values of the kernel's own constants: one number for all tuples, or one for each.
  std::vector<std::vector<double>> constants{};
};

template <>
struct KindOf<Potential> {
  static constexpr std::string_view name = "potential";
  static constexpr auto members = &Potential::points;
  static constexpr const char* list = "points";
  static constexpr const char* distinct = "the points of a tuple differ";
  static constexpr std::tuple<> fields{};
};

}  // namespace tanor
