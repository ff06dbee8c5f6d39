#pragma once

#include "schur/schur_solver.hpp"

namespace tanor {

/// 1/cond(D S D), D = diag(S)^-1/2, from the largest eigenvalues of D S D and of its inverse by power iterations: for
/// factors that hold no matrix. `factor`: of the S of `blocks`.
double estimate_reciprocal_condition(const SchurProblem& problem, const Parallel& parallel, const double* blocks,
                                     SchurFactor& factor);

}  // namespace tanor
