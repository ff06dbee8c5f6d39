#pragma once

#include <functional>

#include <Eigen/Core>

namespace tanor {

/// The largest eigenvalues of a symmetric operator A by Lanczos' method on blocks, with full orthogonalisation and
/// thick restarts (Wu & Simon 2000; Stewart's Krylov-Schur form of a symmetric A). Of an eigenvalue that stands several
/// times, a block of as many columns sees that many.
class BlockLanczos {
 public:
  using Matrix = Eigen::MatrixXd;
  /// `apply`: A times many columns at once. `start`, [size, block]: any columns. `count` eigenvalues are wanted, and
  /// the Krylov space has `dimension` columns at most, or count and two blocks.
  BlockLanczos(std::function<Matrix(const Matrix&)> apply, const Matrix& start, Eigen::Index count,
               Eigen::Index dimension);

  /// Goes on until |A x - theta x| <= tolerance |theta| for all that are wanted, or to rounding. False: fewer are so
  /// good after many restarts.
  bool run(double tolerance);

  /// How many of the largest ones, up to `count`, were so good when the last run ended.
  Eigen::Index converged() const { return converged_; }
  /// Ritz values theta of the whole space, the largest first, and |A x - theta x|.
  const Eigen::VectorXd& values() const { return values_; }
  const Eigen::VectorXd& residuals() const { return residuals_; }
  /// The first orthonormal Ritz vectors.
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

}  // namespace tanor
