#pragma once

#include <Eigen/Core>

#include "friction/contact_problem.hpp"

namespace tanor::detail {

/// Proves by contraction (rho(R) < 1) that (43) has one solution. The workspace is kept, since every step asks.
class ContractionBound {
 public:
  /// Returns the largest row sum of (I - R)^-1, R_cj = mu_c |W_cj|, if rho(R) < 1, else NaN.
  double amplification(const ContactProblem& problem);
  /// Returns the same for any R >= 0 [m, m].
  double amplification(const Eigen::MatrixXd& R);

 private:
  Eigen::MatrixXd R_, A_;  // [m][m]; A = I - R, then its factors
  Eigen::VectorXd x_;      // [m]
};

}  // namespace tanor::detail
