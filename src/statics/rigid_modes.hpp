#pragma once

#include <cstddef>
#include <vector>

#include "statics/equilibrium_equations.hpp"

namespace tanor {

/// The islands of moving points that constraints or forces join: [point] -> the number of a point that stands for all.
std::vector<int> find_statics_islands(const EquilibriumEquations& equations);

/// [point] the largest |W_ij| in its island, where the equations were linearised last, N/m; 1e-150, whose square is a
/// number, where nothing is stiff.
std::vector<double> find_island_stiffness(const EquilibriumEquations& equations, const std::vector<int>& island);

/// Dimension of the motions of islands as a whole, free ones and those held at a point or an axis, that no constraint
/// and no force answers to, where the equations were linearised last, at r [3 points].
std::size_t count_rigid_modes(const EquilibriumEquations& equations, const std::vector<double>& r);

}  // namespace tanor
