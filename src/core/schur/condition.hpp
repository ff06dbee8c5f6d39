#pragma once

#include <cmath>
#include <numeric>
#include <vector>

#include "base/numbers.hpp"
#include "schur/schur_solver.hpp"

namespace tanor::detail {

/// Returns |A| of a symmetric matrix A by power iterations; apply() overwrites x by A x. The answer is 0 if x is empty.
template <class Apply>
double estimate_norm(std::vector<double>* x, int iterations, const Apply& apply) {
  const auto norm = [&] { return std::sqrt(std::inner_product(x->begin(), x->end(), x->begin(), 0.0)); };
  double result = 0.0;
  for (std::size_t k = 0; k < x->size(); ++k) (*x)[k] = irregular(k);
  double before = norm();
  for (int i = 0; i < iterations && !x->empty(); ++i) {
    apply();
    const double after = norm();
    result = after / before;
    for (double& each : *x) each /= after;
    before = 1.0;
  }
  return result;
}

/// Estimates 1/cond(D S D), D = diag(S)^-1/2, from the largest eigenvalues of D S D and of its inverse by power
/// iterations. It serves factors that hold no matrix. `factor` is that of the S of `blocks`.
inline double estimate_reciprocal_condition(const SchurProblem& problem, const Parallel& parallel, const double* blocks,
                                            SchurFactor& factor) {
  constexpr int iterations = 4;
  std::vector<double> scale(problem.constraints.num_rows(), 0.0), x(scale.size());
  std::vector<double> dw(3 * problem.inverse_mass.size(), 0.0);
  for (const auto& [point, row, block, sign] : problem.incidences) {
    const Vec3 g = load(blocks, block);
    scale[static_cast<std::size_t>(row)] += problem.inverse_mass[static_cast<std::size_t>(point)] * dot(g, g);
  }
  for (double& each : scale) each = each > 0.0 ? std::sqrt(each) : 1.0;  // 1 for rows that move nothing
  const double largest = estimate_norm(&x, iterations, [&] {
    for (std::size_t a = 0; a < x.size(); ++a) x[a] /= scale[a];
    problem.gather.write_scaled(parallel, blocks, x.data(), problem.inverse_mass.data(), problem.numbering.num_moving,
                                dw.data());
    problem.constraints.apply_transposed(parallel, blocks, dw.data(), nullptr, x.data());
    for (std::size_t a = 0; a < x.size(); ++a) x[a] /= scale[a];
  });
  const double largest_of_inverse = estimate_norm(&x, iterations, [&] {
    for (std::size_t a = 0; a < x.size(); ++a) x[a] *= scale[a];
    factor.solve_negative(parallel, x.data(), x.data());
    for (std::size_t a = 0; a < x.size(); ++a) x[a] *= scale[a];
  });
  return 1.0 / (largest * largest_of_inverse);
}

}  // namespace tanor::detail
