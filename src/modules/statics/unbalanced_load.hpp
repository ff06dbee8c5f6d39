#pragma once

#include <string>

#include "statics/equilibrium_equations.hpp"

namespace tanor::detail {

/// Names the island of points that a load pulls along without end, because no constraint and no force answers to a
/// shift of it anywhere. Returns an empty text if there is none. r is [3 points].
std::string find_unbalanced_load(EquilibriumEquations& equations, const std::vector<double>& r);

}  // namespace tanor::detail
