#include "statics/zero_modes.hpp"

#include <algorithm>
#include <cmath>

#include "statics/islands.hpp"

namespace tanor::detail {

namespace {

using Rows = Eigen::Index;

/// Size and stiffness of an island, and whether constraints act on it.
struct Island {
  double points = 0.0, stiffness = 0.0;  // the stiffest row, N/m
  bool has_rows = false;
};

std::vector<Island> describe(const EquilibriumEquations& equations, const std::vector<int>& island,
                             const std::vector<double>& stiffness) {
  std::vector<Island> result(island.size());
  for (std::size_t i = 0; i < island.size(); ++i) {
    Island& own = result[static_cast<std::size_t>(island[i])];
    own.points += 1.0;
    own.stiffness = std::max(own.stiffness, stiffness[i]);
  }
  for (const Incidence& incidence : equations.model().incidences) {
    const auto point = static_cast<std::size_t>(incidence.point);
    if (point < island.size()) result[static_cast<std::size_t>(island[point])].has_rows = true;
  }
  return result;
}

double find_rounding(const Island& island, ZeroModes::Found found) {
  constexpr double of_dense_matrices = 1e-12, of_multipliers = 1e-9, least = 1e-13, short_chain = 100.0;
  if (!island.has_rows) return found == ZeroModes::Found::ByDenseMatrices ? of_dense_matrices : least;
  return std::max(least, of_multipliers * std::min(1.0, std::pow(short_chain / island.points, 2)));
}

/// Returns the forces that act at each point of islands where all of them are rounding of the places, as of springs at
/// their lengths far out, else 0.
std::vector<double> find_forces_of_rounding(const EquilibriumEquations& equations, const std::vector<int>& island) {
  std::vector<double> largest(island.size(), 0.0), rounding(island.size(), 0.0), result(island.size(), 0.0);
  const auto own = [&](std::size_t i) { return static_cast<std::size_t>(island[i]); };
  for (std::size_t i = 0; i < island.size(); ++i) {
    largest[own(i)] = std::max(largest[own(i)], equations.acting_force(i));
    rounding[own(i)] = std::max(rounding[own(i)], equations.rounding_of_forces(i));
  }
  for (std::size_t i = 0; i < island.size(); ++i) {
    if (largest[own(i)] <= rounding[own(i)]) result[i] = equations.acting_force(i);
  }
  return result;
}

}  // namespace

ZeroModes::ZeroModes(const EquilibriumEquations& equations, Found found)
    : model_(equations.model()), island_(find_statics_islands(equations)) {
  constexpr double soft = 1e-3;  // relative to the stiffest row of the island, whose moves the point shares
  constexpr double beyond_blur = 100.0;
  const std::vector<double> stiffness = equations.stiffness().sum_rows();
  const std::vector<Island> islands = describe(equations, island_, stiffness);
  for (std::size_t i = 0; i < island_.size(); ++i) {
    const Island& own = islands[static_cast<std::size_t>(island_[i])];
    // If nothing is stiff, all modes are zero modes whatever the bound is.
    const double of_row = own.stiffness > 0.0 ? std::max(stiffness[i], soft * own.stiffness) / model_.mass[i] : 1.0;
    of_points_.push_back(std::max({find_rounding(own, found) * of_row, beyond_blur * equations.blur(i) / model_.mass[i],
                                   equations.rounding_of_loads(i) / (model_.smallest_length * model_.mass[i])}));
  }
  raise(find_forces_of_rounding(equations, island_));
}

double ZeroModes::of_mode(const Eigen::Ref<const Eigen::VectorXd>& shape) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < of_points_.size(); ++i)
    sum += of_points_[i] * model_.mass[i] * shape.segment<3>(3 * static_cast<Rows>(i)).squaredNorm();
  return sum;
}

bool ZeroModes::are_equal() const {
  return std::ranges::all_of(of_points_, [&](double each) { return each == of_points_[0]; });
}

double ZeroModes::least() const {
  return std::ranges::min(of_points_);
}

void ZeroModes::raise(const std::vector<double>& forces) {
  std::vector<double> largest(island_.size(), 0.0);
  const auto own = [&](std::size_t i) { return static_cast<std::size_t>(island_[i]); };
  for (std::size_t i = 0; i < forces.size(); ++i) largest[own(i)] = std::max(largest[own(i)], forces[i]);
  for (std::size_t i = 0; i < of_points_.size(); ++i) {
    const double length = model_.smallest_length;
    of_points_[i] = std::max(of_points_[i], share_of_residual * largest[own(i)] / (length * model_.mass[i]));
  }
}

}  // namespace tanor::detail
