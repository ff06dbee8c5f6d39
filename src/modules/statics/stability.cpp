#include "statics/stability.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "statics/mode_finder.hpp"
#include "statics/rigid_modes.hpp"
#include "statics/zero_modes.hpp"

namespace tanor::detail {

namespace {

using Rows = Eigen::Index;

void keep_lowest(const ModeSet& modes, Rows k, ReducedInertia* result) {
  result->lowest = modes.omega2[k];
  result->shape.assign(modes.shapes.col(k).begin(), modes.shapes.col(k).end());
}

ReducedInertia find_dense(const ZeroModes& zero, ModeFinder* finder) {
  ReducedInertia result;
  const ModeSet modes = finder->find_all();
  result.is_known = modes.outcome.ok();
  if (!result.is_known || modes.omega2.size() == 0) return result;
  for (Rows k = 0; k < modes.omega2.size(); ++k) {
    if (std::abs(modes.omega2[k]) <= zero.of_mode(modes.shapes.col(k))) {
      ++result.zero;
      continue;
    }
    if (modes.omega2[k] < 0.0) ++result.negative;
    if (result.shape.empty()) keep_lowest(modes, k, &result);
  }
  return result;
}

/// Finds the lowest omega^2 that is no zero mode, with the factor of the least shift that has one.
void find_lowest(const ZeroModes& zero, ModeFinder* finder, KktSolver* solver, ReducedInertia* result) {
  const double least = std::ranges::min(zero.of_points());
  double shift = result->negative + result->zero > 0 ? least : -least;
  while (!solver->factorize(shift)) {
    shift = 10.0 * std::abs(shift);
    if (shift > 1e4 * finder->scale()) return;
  }
  // Rounding tells zero modes apart, so that Lanczos' method may find all of them before the mode beyond.
  constexpr std::size_t fewest = 4, most = 64;
  for (const std::size_t count : {std::size_t{1}, std::clamp(result->zero, fewest, most) + 1}) {
    const ModeSet modes = finder->find_some_lowest(shift, count);
    for (Rows k = 0; k < modes.omega2.size(); ++k) {
      if (std::abs(modes.omega2[k]) > zero.of_mode(modes.shapes.col(k))) return keep_lowest(modes, k, result);
    }
  }
}

ReducedInertia find_sparse(const ZeroModes& zero, std::size_t freedoms, ModeFinder* finder, KktSolver* solver) {
  ReducedInertia result;
  std::vector<double> shifts = zero.of_points();
  for (double& each : shifts) each = -each;
  if (!solver->factorize(std::move(shifts))) {
    const auto below = count_near(-1.0, zero, solver), up_to = count_near(1.0, zero, solver);
    result.is_known = below && up_to && *up_to >= *below;
    if (!result.is_known) return result;
    result.negative = *below;
    result.zero = *up_to - *below;
  }
  if (result.zero < freedoms) find_lowest(zero, finder, solver, &result);
  return result;
}

}  // namespace

std::optional<std::size_t> count_near(double part, const ZeroModes& zero, KktSolver* solver) {
  for (const double factor : {1.0, 1.3, 0.7, 2.0}) {
    std::vector<double> bounds = zero.of_points();
    for (double& each : bounds) each *= factor * part;
    if (const auto count = solver->count_below(std::move(bounds))) return count;
  }
  return std::nullopt;
}

ReducedInertia find_inertia(const EquilibriumEquations& equations, const std::vector<double>& r, std::size_t freedoms,
                            const std::vector<std::size_t>& dependent, KktSolver* solver) {
  if (freedoms == 0) return {};
  const bool is_dense = equations.size() <= most_dense_unknowns;
  const ZeroModes zero(equations, is_dense ? ZeroModes::Found::ByDenseMatrices : ZeroModes::Found::ByFactor);
  ModeFinder finder(equations, *solver, freedoms, dependent);
  ReducedInertia result = is_dense ? find_dense(zero, &finder) : find_sparse(zero, freedoms, &finder, solver);
  if (result.zero > 0) result.rigid_zero = std::min(result.zero, count_rigid_modes(equations, r));
  return result;
}

}  // namespace tanor::detail
