#pragma once

#include <span>
#include <string>

#include <tanor/equilibrium.hpp>
#include <tanor/system.hpp>

namespace tanor::detail {

/// Returns the corner of a formula in which points rest, no further from it than a part of the largest coordinate of a
/// scene: "the corner of abs(x1) in wire"; empty if they rest in none. No side of the formula holds there.
std::string find_standing_corner(const System& system, double t, std::span<const double> positions,
                                 std::span<const double> scene, double part = 1e-9);
/// Returns the result, refused if its points rest in a corner. A search that failed may lead there as well.
EquilibriumResult refuse_standing_corner(const System& system, double t, EquilibriumResult result);

}  // namespace tanor::detail
