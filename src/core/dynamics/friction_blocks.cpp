#include "dynamics/friction_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/text.hpp"
#include "dynamics/split.hpp"

namespace tanor::detail {

Outcome iterate_friction_blocks(MultiplierForm& normal, Workspace& work, const FrictionPlace& place,
                                int most_iterations, FrictionBlocks* result) {
  const Model& model = work.model();
  const std::size_t size = 3 * model.num_points(), num_rows = model.num_rows();
  NormalSpace space(work);
  if (Outcome outcome = space.factorize(place.t, place.r.data(), normal.linearization().blocks().data()); !outcome.ok())
    return outcome;

  // e = S^-1 K'(w_N - M^-1 f) = -S^-1 (phi + K'w0)
  std::vector<double> w0(size), b(num_rows), e(num_rows), points(size);
  (void)work.evaluate_free(place.t, place.r.data(), place.v.data(), w0.data());
  work.constraints.evaluate_right_side(model.parallel, place.r.data(), place.v.data(), w0.data(), b.data(), nullptr);
  normal.linearization().solve_refined(b.data(), e.data(), points.data());

  constexpr double tolerance = 1e-13, holds = 1e-12;
  std::vector<double> lambda = e, next(num_rows), tau(size), tau_N(size), tau_xi(num_rows), part(num_rows);
  bool has_converged = false;
  while (!has_converged && result->iterations < most_iterations) {
    ++result->iterations;
    normal.contacts()->write_at(lambda.data(), tau.data());
    // tau^(xi) = Gamma^-1 K'tau, A tau^(q) = tau_T = tau - K tau^(xi)
    space.project(tau.data(), tau_N.data(), tau_xi.data());
    for (std::size_t i = 0; i < 3 * model.num_moving(); ++i)
      points[i] = model.inverse_mass[i / 3] * (tau[i] - tau_N[i]);
    std::fill(points.begin() + static_cast<std::ptrdiff_t>(3 * model.num_moving()), points.end(), 0.0);
    const double coupling = work.constraints.apply_transposed(model.parallel, normal.linearization().blocks().data(),
                                                              points.data(), nullptr, b.data());
    const double whole = model.largest_norm(points.data());
    if (result->iterations == 1) result->tangent_block_left_out = coupling <= holds * whole;  // (44)
    std::fill(part.begin(), part.end(), 0.0);
    if (!result->tangent_block_left_out) normal.linearization().solve_refined(b.data(), part.data(), points.data());
    for (std::size_t a = 0; a < num_rows; ++a) next[a] = e[a] + part[a] - tau_xi[a];
    normal.linearization().minimize_multiplier_norm(place.r.data(), next.data());
    double scale = 0.0, change = 0.0;
    for (std::size_t a = 0; a < num_rows; ++a) {
      change = larger(change, std::abs(next[a] - lambda[a]));
      scale = larger(scale, std::abs(next[a]));
    }
    std::swap(lambda, next);
    if (!std::isfinite(change)) return model.not_finite(place.t);
    has_converged = change <= tolerance * scale;
  }
  result->multipliers.resize(model.numbering.num_user_rows);
  result->friction.resize(size);
  model.numbering.scatter_rows(lambda, result->multipliers);
  model.numbering.scatter_points(tau, result->friction);
  if (has_converged) return {};
  return {Status::NotConverged, "the iteration of friction does not converge at t = " + text(place.t)};
}

}  // namespace tanor::detail
