#pragma once

#include <cstddef>
#include <vector>

#include "statics/equilibrium_equations.hpp"

namespace tanor {

/// Finds the islands of moving points that constraints or forces join: [point] -> number of a point that represents
/// them.
std::vector<int> find_statics_islands(const EquilibriumEquations& equations);

/// Returns for each point the largest |W_ij| in its island, N/m, where the equations were linearised last. Islands
/// without stiffness have 1e-150, whose square is still a positive number.
std::vector<double> find_island_stiffness(const EquilibriumEquations& equations, const std::vector<int>& island);

/// Returns the dimension of the motions of whole islands, free or about a fixed point or axis, that no constraint and
/// no force answers to, over a finite distance too. Islands that could move likewise to first order alone, as a crank
/// with its coupler could, count none. The equations must have been linearised last at r [3 points].
std::size_t count_rigid_modes(const EquilibriumEquations& equations, const std::vector<double>& r);

}  // namespace tanor
