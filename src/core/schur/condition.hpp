#pragma once

#include <cmath>
#include <numeric>
#include <vector>

#include "base/numbers.hpp"
#include "schur/schur_solver.hpp"

namespace tanor::detail {

/// Returns |A| of a symmetric matrix A by power iterations x, A x, A^2 x, …; apply() overwrites x by A x. For |S^-1| it
/// solves with S. The answer is 0 if x is empty.
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
double estimate_reciprocal_condition(const SchurProblem& problem, const Parallel& parallel, const double* blocks,
                                     SchurFactor& factor);

}  // namespace tanor::detail
