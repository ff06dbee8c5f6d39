#pragma once

#include <functional>

#include <Eigen/Core>

namespace tanor::detail {

/// Finds the largest eigenvalues of a symmetric operator A by the block Lanczos method, with full orthogonalisation and
/// thick restarts (Wu & Simon 2000; Stewart's Krylov-Schur form of a symmetric A). A block finds as many copies of a
/// multiple eigenvalue as it has columns.
class BlockLanczos {
 public:
  using Matrix = Eigen::MatrixXd;
  /// `apply` multiplies A by many columns at once, and `start` [size, block] holds any columns. `count` eigenvalues are
  /// wanted, and the Krylov space has at most max(dimension, count + 2 block) columns.
  BlockLanczos(std::function<Matrix(const Matrix&)> apply, const Matrix& start, Eigen::Index count,
               Eigen::Index dimension);

  /// Iterates until |A x - theta x| <= tolerance |theta| for all wanted eigenvalues, or to rounding. Returns false if
  /// fewer have converged after many restarts.
  bool run(double tolerance);

  /// Returns how many of the largest eigenvalues, up to `count`, had converged at the end of the last run.
  Eigen::Index converged() const { return converged_; }
  /// The Ritz values theta of the whole space, the largest first, and the residuals |A x - theta x|.
  const Eigen::VectorXd& values() const { return values_; }
  const Eigen::VectorXd& residuals() const { return residuals_; }
  /// Returns the first orthonormal Ritz vectors.
  Matrix vectors(Eigen::Index columns) const;

 private:
  void span_everything(Eigen::Index size);
  void extend();
  void restart();
  void find_ritz_pairs();
  Eigen::Index count_converged(double tolerance) const;

  std::function<Matrix(const Matrix&)> apply_;
  Eigen::Index count_, block_, size_ = 0, converged_ = 0;  // size_: columns of V_ that are in use
  int restarts_ = 0;
  Matrix V_, T_;     // A V = V T + Q R E', where E has the columns of the last block
  Matrix next_, R_;  // Q, R
  Matrix rotation_;  // T = rotation theta rotation'
  Eigen::VectorXd values_, residuals_;
};

}  // namespace tanor::detail
