#include "statics/zero_modes.hpp"

#include <algorithm>
#include <cmath>

namespace tanor::detail {

namespace {

using Rows = Eigen::Index;

double find_rounding(const StaticsIsland& island, ZeroModes::Found found) {
  constexpr double of_dense_matrices = 1e-12, of_multipliers = 1e-9, least = 1e-13, short_chain = 100.0;
  if (island.rows.empty()) return found == ZeroModes::Found::ByDenseMatrices ? of_dense_matrices : least;
  return std::max(least,
                  of_multipliers * std::min(1.0, std::pow(short_chain / static_cast<double>(island.points.size()), 2)));
}

/// Returns the forces that act at each point of islands where all of them are rounding of the places, as of springs at
/// their lengths far out, else 0.
std::vector<double> find_forces_of_rounding(const EquilibriumEquations& equations,
                                            const std::vector<StaticsIsland>& islands) {
  std::vector<double> result(equations.size() / 3, 0.0);
  for (const StaticsIsland& island : islands) {
    double largest = 0.0, rounding = 0.0;
    for (const std::size_t i : island.points) {
      largest = std::max(largest, equations.acting_force(i));
      rounding = std::max(rounding, equations.rounding_of_forces(i));
    }
    for (const std::size_t i : island.points) result[i] = largest <= rounding ? equations.acting_force(i) : 0.0;
  }
  return result;
}

}  // namespace

ZeroModes::ZeroModes(const EquilibriumEquations& equations, Found found)
    : model_(equations.model()), islands_(StaticsIslands(equations).list), of_points_(equations.size() / 3) {
  constexpr double soft = 1e-3;  // relative to the stiffest row of the island, whose moves the point shares
  constexpr double beyond_blur = 100.0;
  const std::vector<double> stiffness = equations.stiffness().sum_rows();
  for (const StaticsIsland& island : islands_) {
    double stiffest = 0.0;  // N/m
    for (const std::size_t i : island.points) stiffest = std::max(stiffest, stiffness[i]);
    for (const std::size_t i : island.points) {
      // If nothing is stiff, all modes are zero modes whatever the bound is.
      const double of_row = stiffest > 0.0 ? std::max(stiffness[i], soft * stiffest) / model_.mass[i] : 1.0;
      of_points_[i] = std::max({find_rounding(island, found) * of_row, beyond_blur * equations.blur(i) / model_.mass[i],
                                equations.rounding_of_loads(i) / (model_.smallest_length * model_.mass[i])});
    }
  }
  raise(find_forces_of_rounding(equations, islands_));
}

double ZeroModes::of_mode(const Eigen::Ref<const Eigen::VectorXd>& shape) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < of_points_.size(); ++i)
    sum += of_points_[i] * model_.mass[i] * shape.segment<3>(3 * static_cast<Rows>(i)).squaredNorm();
  return sum;
}

void ZeroModes::raise(const std::vector<double>& forces) {
  for (const StaticsIsland& island : islands_) {
    double largest = 0.0;
    for (const std::size_t i : island.points) largest = std::max(largest, forces[i]);
    for (const std::size_t i : island.points)
      of_points_[i] = std::max(of_points_[i], share_of_residual * largest / (model_.smallest_length * model_.mass[i]));
  }
}

}  // namespace tanor::detail
