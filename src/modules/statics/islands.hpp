#pragma once

#include <vector>

namespace tanor::detail {

class EquilibriumEquations;
class Model;

/// Groups the moving points that constraints join: [point] -> number of a point that represents them.
std::vector<int> find_joined_points(const Model& model);

/// Groups the moving points that constraints or forces join.
std::vector<int> find_statics_islands(const EquilibriumEquations& equations);

/// Returns for each point the largest |W_ij| in its island, N/m, where the equations were linearised last. Islands
/// without stiffness have 1e-150, whose square is still a positive number.
std::vector<double> find_island_stiffness(const EquilibriumEquations& equations, const std::vector<int>& island);

}  // namespace tanor::detail
