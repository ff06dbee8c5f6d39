#pragma once

#include <string>

#include "statics/equilibrium_equations.hpp"

namespace tanor {

/// Says which island of points a load pulls along without end, because nothing answers to a shift of it: no constraint
/// and no force, wherever it is. Empty: none. r [3 points].
std::string find_unbalanced_load(EquilibriumEquations& equations, const std::vector<double>& r);

}  // namespace tanor
