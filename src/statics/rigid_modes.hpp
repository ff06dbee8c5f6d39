#pragma once

#include <cstddef>
#include <vector>

#include "statics/equilibrium_equations.hpp"

namespace tanor {

/// The islands of moving points that constraints or forces join: [point] -> the number of a point that stands for all.
std::vector<int> find_statics_islands(const EquilibriumEquations& equations);

/// Dimension of the motions of islands as a whole, free ones and those held at a point or an axis, that no constraint
/// and no force answers to, where the equations were linearised last, at r [3 points].
std::size_t count_rigid_modes(const EquilibriumEquations& equations, const std::vector<double>& r);

}  // namespace tanor
