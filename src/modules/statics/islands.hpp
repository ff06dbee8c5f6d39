#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace tanor::detail {

class EquilibriumEquations;
class Model;

/// Groups the moving points that constraints join: [point] -> number of a point that represents them.
std::vector<int> find_joined_points(const Model& model);

/// Moving points that constraints or forces join.
struct StaticsIsland {
  std::vector<std::size_t> points, rows;
  double stiffness = 1e-150;  ///< largest |W_ij|, N/m; without any, a number whose square is still positive

  /// Returns x, y, z of each point in the order of unknowns.
  std::vector<Eigen::Index> coordinates() const;
};

/// The islands where the equations were linearised last.
struct StaticsIslands {
  explicit StaticsIslands(const EquilibriumEquations& equations);

  std::vector<StaticsIsland> list;
  std::vector<std::size_t> of_point;  ///< [moving point]
};

}  // namespace tanor::detail
