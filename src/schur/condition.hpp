#pragma once

#include <cmath>
#include <numeric>
#include <vector>

#include "base/numbers.hpp"
#include "schur/schur_solver.hpp"

namespace tanor {

/// Returns |S^-1| of a symmetric S by power iterations x, S^-1 x, S^-2 x, …; solve() overwrites x by S^-1 x. The answer
/// is 0 if x is empty.
template <class Solve>
double estimate_norm_of_inverse(std::vector<double>* x, int iterations, const Solve& solve) {
  const auto norm = [&] { return std::sqrt(std::inner_product(x->begin(), x->end(), x->begin(), 0.0)); };
  double inverse = 0.0;
  for (std::size_t k = 0; k < x->size(); ++k) (*x)[k] = irregular(k);
  double before = norm();
  for (int i = 0; i < iterations && !x->empty(); ++i) {
    solve();
    const double after = norm();
    inverse = after / before;
    for (double& each : *x) each /= after;
    before = 1.0;
  }
  return inverse;
}

/// Estimates 1/cond(D S D), D = diag(S)^-1/2, from the largest eigenvalues of D S D and of its inverse by power
/// iterations. It serves factors that hold no matrix. `factor` is that of the S of `blocks`.
double estimate_reciprocal_condition(const SchurProblem& problem, const Parallel& parallel, const double* blocks,
                                     SchurFactor& factor);

}  // namespace tanor
