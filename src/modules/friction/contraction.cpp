#include "friction/contraction.hpp"

#include <Eigen/Core>
#include <cmath>
#include <limits>

namespace tanor::detail {

double ContractionBound::amplification(const ContactProblem& problem) {
  const Eigen::Index m = problem.size();
  R_.resize(m, m);
  for (Eigen::Index c = 0; c < m; ++c)
    R_.row(c) = problem.contacts[static_cast<std::size_t>(c)].mu * problem.W.middleRows<3>(3 * c).colwise().norm();
  return amplification(R_);
}

/// For R >= 0, rho(R) < 1 exactly if I - R is a nonsingular M-matrix, that is, if elimination without exchanges has
/// positive pivots (Berman and Plemmons 1994, ch. 6). Then x = (I - R)^-1 1 >= 1, and |e| <= (I - R)^-1 |F(s) - s|.
double ContractionBound::amplification(const Eigen::MatrixXd& R) {
  constexpr double unproven = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Index m = R.rows();
  // A = L U
  A_ = -R;
  A_.diagonal().array() += 1.0;
  for (Eigen::Index k = 0; k < m; ++k) {
    const Eigen::Index rest = m - k - 1;
    if (!(A_(k, k) > 0.0)) return unproven;
    A_.col(k).tail(rest) /= A_(k, k);
    A_.bottomRightCorner(rest, rest).noalias() -= A_.col(k).tail(rest) * A_.row(k).tail(rest);
  }
  x_.setOnes(m);
  A_.triangularView<Eigen::UnitLower>().solveInPlace(x_);
  A_.triangularView<Eigen::Upper>().solveInPlace(x_);
  // If I - R is nearly singular, x has no correct digits and proves nothing.
  double largest = 1.0;
  for (Eigen::Index c = 0; c < m; ++c) {
    const double rest = x_(c) - 1.0 - R.row(c).dot(x_);
    if (!(std::abs(rest) < 1e-3 && x_(c) >= 1.0 - 1e-9)) return unproven;
    largest = std::max(largest, x_(c));
  }
  return std::isfinite(largest) ? largest : unproven;
}

}  // namespace tanor::detail
