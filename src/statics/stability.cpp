#include "statics/stability.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "statics/mode_finder.hpp"
#include "statics/rigid_modes.hpp"

namespace tanor {

namespace {

using Rows = Eigen::Index;

/// Bound of the largest omega^2 of W, by rows of M^-1/2 W M^-1/2.
double largest_frequency2(const EquilibriumEquations& equations) {
  const StiffnessMatrix& W = equations.stiffness();
  const Model& model = equations.model();
  double result = 0.0;
  for (std::size_t i = 0; i < W.num_points(); ++i) {
    std::array<double, 3> sums{};
    for (int k = W.start()[i]; k < W.start()[i + 1]; ++k) {
      const auto block = static_cast<std::size_t>(k);
      const double scale = std::sqrt(model.mass[i] * model.mass[static_cast<std::size_t>(W.columns()[block])]);
      for (std::size_t entry = 0; entry < 9; ++entry)
        sums[entry / 3] += std::abs(W.blocks()[block].entries[entry]) / scale;
    }
    for (const double sum : sums) result = std::max(result, sum);
  }
  return result;
}

double zero_tolerance(const EquilibriumEquations& equations, double largest) {
  constexpr double usual = 1e-9, least = 1e-13, short_chain = 100.0;
  const double points = std::max(1.0, static_cast<double>(equations.size()) / 3.0);
  return largest * std::max(least, usual * std::min(1.0, std::pow(short_chain / points, 2)));
}

void keep_lowest(const ModeSet& modes, Rows k, ReducedInertia* result) {
  result->lowest = modes.omega2[k];
  result->shape.assign(modes.shapes.col(k).begin(), modes.shapes.col(k).end());
}

ReducedInertia find_dense(const EquilibriumEquations& equations, ModeFinder* finder) {
  ReducedInertia result;
  const ModeSet modes = finder->find_all();
  result.is_known = modes.outcome.ok();
  if (!result.is_known || modes.omega2.size() == 0) return result;
  const double zero =
      zero_tolerance(equations, std::max(modes.omega2.cwiseAbs().maxCoeff(), 1e-3 * largest_frequency2(equations)));
  for (Rows k = 0; k < modes.omega2.size(); ++k) {
    if (std::abs(modes.omega2[k]) <= zero) {
      ++result.zero;
      continue;
    }
    if (modes.omega2[k] < 0.0) ++result.negative;
    if (result.shape.empty()) keep_lowest(modes, k, &result);
  }
  return result;
}

/// Where a pivot vanishes a bound nearby is asked for.
std::optional<std::size_t> count_near(double omega2, KktSolver* solver) {
  for (const double factor : {1.0, 1.3, 0.7, 2.0}) {
    if (const auto count = solver->count_below(factor * omega2)) return count;
  }
  return std::nullopt;
}

ReducedInertia find_sparse(const EquilibriumEquations& equations, ModeFinder* finder, KktSolver* solver) {
  ReducedInertia result;
  const double largest = largest_frequency2(equations), zero = zero_tolerance(equations, largest);
  double shift = -zero;
  if (!solver->factorize(shift)) {
    const auto below = count_near(-zero, solver), up_to = count_near(zero, solver);
    result.is_known = below && up_to && *up_to >= *below;
    if (!result.is_known) return result;
    result.negative = *below;
    result.zero = *up_to - *below;
    for (shift = zero; !solver->factorize(shift); shift *= 10.0) {
      if (shift > 1e4 * largest) return result;
    }
  }
  // A block of Lanczos' method sees a zero mode as often as it has columns, and then what lies beyond.
  constexpr std::size_t most = 64;
  for (const std::size_t count : {std::size_t{1}, std::clamp(result.zero, ModeFinder::fewest_in_block, most) + 1}) {
    const ModeSet modes = finder->find_some_lowest(shift, count);
    for (Rows k = 0; k < modes.omega2.size(); ++k) {
      if (std::abs(modes.omega2[k]) <= zero) continue;
      keep_lowest(modes, k, &result);
      return result;
    }
  }
  return result;
}

}  // namespace

ReducedInertia find_inertia(const EquilibriumEquations& equations, const std::vector<double>& r, std::size_t freedoms,
                            KktSolver* solver) {
  if (freedoms == 0) return {};
  ModeFinder finder(equations, *solver, freedoms);
  ReducedInertia result = equations.size() <= most_dense_unknowns ? find_dense(equations, &finder)
                                                                  : find_sparse(equations, &finder, solver);
  if (result.zero > 0) result.rigid_zero = std::min(result.zero, count_rigid_modes(equations, r));
  return result;
}

}  // namespace tanor
