#include "statics/zero_modes.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "statics/rigid_modes.hpp"

namespace tanor {

namespace {

using Rows = Eigen::Index;

/// Bounds of the largest omega^2 of W, by rows of M^-1/2 W M^-1/2: the largest one of each island [point].
std::vector<double> bound_frequencies2(const EquilibriumEquations& equations, const std::vector<int>& island) {
  const StiffnessMatrix& W = equations.stiffness();
  const Model& model = equations.model();
  std::vector<double> result(island.size(), 0.0);
  for (std::size_t i = 0; i < W.num_points(); ++i) {
    std::array<double, 3> sums{};
    for (int k = W.start()[i]; k < W.start()[i + 1]; ++k) {
      const auto block = static_cast<std::size_t>(k);
      const double scale = std::sqrt(model.mass[i] * model.mass[static_cast<std::size_t>(W.columns()[block])]);
      for (std::size_t entry = 0; entry < 9; ++entry)
        sums[entry / 3] += std::abs(W.blocks()[block].entries[entry]) / scale;
    }
    double& own = result[static_cast<std::size_t>(island[i])];
    for (const double sum : sums) own = std::max(own, sum);
  }
  return result;
}

/// The largest |omega^2| of those modes that swing in an island more than elsewhere, but a thousandth of the bound.
std::vector<double> largest_frequencies2(const ModeSet& all, const std::vector<int>& island, const Model& model,
                                         const std::vector<double>& bounds) {
  std::vector<double> result = bounds;
  for (double& each : result) each *= 1e-3;
  for (Rows k = 0; k < all.omega2.size(); ++k) {
    std::vector<double> share(island.size(), 0.0);
    for (std::size_t i = 0; i < island.size(); ++i) {
      share[static_cast<std::size_t>(island[i])] +=
          model.mass[i] * all.shapes.col(k).segment<3>(3 * static_cast<Rows>(i)).squaredNorm();
    }
    const auto own = static_cast<std::size_t>(std::ranges::max_element(share) - share.begin());
    result[own] = std::max(result[own], std::abs(all.omega2[k]));
  }
  return result;
}

}  // namespace

ZeroModes::ZeroModes(const EquilibriumEquations& equations, const ModeSet* all) : model_(equations.model()) {
  constexpr double usual = 1e-9, least = 1e-13, short_chain = 100.0;
  const std::vector<int> island = find_statics_islands(equations);
  std::vector<double> largest = bound_frequencies2(equations, island);
  if (all != nullptr) largest = largest_frequencies2(*all, island, model_, largest);
  std::vector<double> points(island.size(), 0.0);
  for (const int own : island) points[static_cast<std::size_t>(own)] += 1.0;
  for (const int own : island) {
    const auto k = static_cast<std::size_t>(own);
    // Where nothing is stiff, all of them are zero, by whatever number.
    largest_.push_back(largest[k] > 0.0 ? largest[k] : 1.0);
    of_points_.push_back(largest_.back() *
                         std::max(least, usual * std::min(1.0, std::pow(short_chain / points[k], 2))));
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

void ZeroModes::raise(double part) {
  for (std::size_t i = 0; i < of_points_.size(); ++i) of_points_[i] = std::max(of_points_[i], part * largest_[i]);
}

}  // namespace tanor
