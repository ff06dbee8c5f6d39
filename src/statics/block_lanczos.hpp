#pragma once

#include <cstddef>
#include <functional>

#include <Eigen/Core>

namespace tanor {

/// Eigenvalues of a symmetric operator, the largest first, and orthonormal vectors by columns.
struct RitzPairs {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

struct LanczosLimits {
  Eigen::Index count;      ///< of eigenvalues that are wanted
  Eigen::Index dimension;  ///< of the Krylov space, at most; at least count and two blocks
  double tolerance;        ///< |A x - theta x| over theta
  int most_restarts = 300;
};

/// The largest eigenvalues of A, the product of which with many columns at once is `apply`, by Lanczos' method on
/// blocks with full orthogonalisation and thick restarts (Wu & Simon 2000; Stewart's Krylov-Schur form of a symmetric
/// A). `start`, [size, block], is any full set of columns: of an eigenvalue that stands several times, a block of as
/// many columns sees that many. Fewer pairs come back where it does not converge.
RitzPairs find_largest(const std::function<Eigen::MatrixXd(const Eigen::MatrixXd&)>& apply,
                       const Eigen::MatrixXd& start, const LanczosLimits& limits);

}  // namespace tanor
