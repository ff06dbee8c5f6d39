#include "statics/zero_modes.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "statics/rigid_modes.hpp"

namespace tanor {

namespace {

using Rows = Eigen::Index;

/// Returns for each moving point the largest sum of |W_ij| over one of its rows, N/m. |q_i'Wq| is at most this sum
/// times |q_i| if all |q_j| are equal.
std::vector<double> sum_rows(const StiffnessMatrix& W) {
  std::vector<double> result(W.num_points());
  for (std::size_t i = 0; i < result.size(); ++i) {
    std::array<double, 3> sums{};
    for (int k = W.start()[i]; k < W.start()[i + 1]; ++k) {
      const Block3& block = W.blocks()[static_cast<std::size_t>(k)];
      for (std::size_t entry = 0; entry < 9; ++entry) sums[entry / 3] += std::abs(block.entries[entry]);
    }
    result[i] = std::ranges::max(sums);
  }
  return result;
}

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

}  // namespace

ZeroModes::ZeroModes(const EquilibriumEquations& equations, Found found) : model_(equations.model()) {
  constexpr double soft = 1e-3;  // relative to the stiffest row of the island, whose moves the point shares
  const std::vector<int> island = find_statics_islands(equations);
  const std::vector<double> stiffness = sum_rows(equations.stiffness());
  const std::vector<Island> islands = describe(equations, island, stiffness);
  for (std::size_t i = 0; i < island.size(); ++i) {
    const Island& own = islands[static_cast<std::size_t>(island[i])];
    // If nothing is stiff, all modes are zero modes whatever the bound is.
    const double of_row = own.stiffness > 0.0 ? std::max(stiffness[i], soft * own.stiffness) / model_.mass[i] : 1.0;
    of_points_.push_back(find_rounding(own, found) * of_row);
  }
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

void ZeroModes::raise(double force) {
  for (std::size_t i = 0; i < of_points_.size(); ++i)
    of_points_[i] = std::max(of_points_[i], share_of_residual * force / (model_.smallest_length * model_.mass[i]));
}

}  // namespace tanor
