#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "assembly/reactions.hpp"
#include "base/parallel.hpp"
#include "evaluate/constraints.hpp"

namespace tanor::detail {

/// The operator S = K'M^-1K without its entries. It is applied by two products with the blocks of K.
struct GramOperator {
  const Constraints& constraints;
  const ReactionGather& gather;
  const std::vector<double>& inverse_mass;  ///< [point]
  std::size_t num_moving, num_rows;         ///< num_rows: rows that take part, the first ones
};

/// Solves S lambda = -b by preconditioned conjugate gradients (M. R. Hestenes, E. Stiefel 1952).
class ConjugateGradients {
 public:
  explicit ConjugateGradients(const GramOperator& S);

  struct Result {
    bool has_converged = false;
    int iterations = 0;
  };
  /// The ends of `solve`, which replaces a guess `lambda` [d] by the solution and computes dw = M^-1 K lambda [3n].
  /// `precondition(rho, z)` computes z = -P^-1 rho with P ~ S. The iteration ends when sqrt(rho'P^-1 rho), which would
  /// be the error of dw in the M-norm if P were S, is at most `allowed`, or `reduction` times its first value. It does
  /// not converge after `most_iterations`, or if S or P is not positive definite to rounding.
  struct Target {
    double allowed, reduction;
    int most_iterations;
  };
  template <class Precondition>
  Result solve(const Parallel& parallel, const double* blocks, const double* b, const Target& target,
               const Precondition& precondition, double* lambda, double* dw) {
    start(parallel, blocks, b, lambda, dw);
    Result result;
    double allowed2 = target.allowed * target.allowed, before = 0.0, rho2 = dot(parallel, rho_, rho_);
    for (; !result.has_converged && result.iterations < target.most_iterations; ++result.iterations) {
      precondition(rho_.data(), z_.data());
      const double error2 = -dot(parallel, rho_, z_);
      if (result.iterations == 0) allowed2 = std::max(allowed2, target.reduction * target.reduction * error2);
      result.has_converged = error2 >= 0.0 && error2 <= allowed2;
      if (result.has_converged || !(error2 > 0.0)) break;
      if (!advance(parallel, blocks, error2, result.iterations == 0 ? 0.0 : error2 / before, lambda, dw)) break;
      before = error2;
      // The error falls as |rho| does. If it is surely small enough, the preconditioner is not needed once more.
      const double rho2_before = std::exchange(rho2, dot(parallel, rho_, rho_));
      result.has_converged = rho2 / rho2_before * error2 <= surely * allowed2;
    }
    finish(parallel, blocks, lambda, dw);
    return result;
  }

 private:
  static constexpr double surely = 0.3;

  void start(const Parallel& parallel, const double* blocks, const double* b, double* lambda, double* dw);
  double dot(const Parallel& parallel, const std::vector<double>& x, const std::vector<double>& y) const;
  bool advance(const Parallel& parallel, const double* blocks, double error2, double beta, double* lambda, double* dw);
  void finish(const Parallel& parallel, const double* blocks, const double* lambda, double* dw) const;

  GramOperator S_;
  std::vector<double> rho_, z_, p_, q_;  // [d] S lambda + b; -P^-1 rho; direction; S p
};

}  // namespace tanor::detail
