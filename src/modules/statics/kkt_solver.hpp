#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "factor/multifrontal.hpp"
#include "statics/augmented_stiffness.hpp"
#include "statics/equilibrium_equations.hpp"

namespace tanor::detail {

/// Solves  [ W + s M  K ] [ x ]   [ a ]
///         [ K'       0 ] [ y ] = [ b ]   for symmetric W, by a sparse Cholesky factor of
///
///   A = W + s M + K C K'      (AugmentedStiffness)
///
/// and conjugate residuals on K'A^-1K y = K'A^-1(a + KCb) - b. The matrix of that system is nearly C^-1, so that two or
/// three steps suffice. Iterative refinement with the residual of the whole system brings the answer to rounding. Rows
/// that depend on each other do no harm if b is consistent.
class KktSolver {
 public:
  /// Reads `equations` where they were linearised last, at each factorization; `equations` must outlive the solver.
  explicit KktSolver(const EquilibriumEquations& equations, Ordering ordering = Ordering::Auto);

  /// Factorizes A for the shift s, 1/s^2. Returns false if A is not positive definite: some omega^2 of Z'WZ q = omega^2
  /// Z'MZ q is then at or below -s, and there is no factor.
  [[nodiscard]] bool factorize(double shift);
  /// Factorizes with a separate shift for each moving point.
  [[nodiscard]] bool factorize(std::vector<double> shifts);
  struct Accuracy {
    int refinements = 3;     ///< rounds with the residual of the whole system
    double of_rows = 1e-24;  ///< conjugate residuals end at this part of the squared residual K'x - b
  };
  /// Solves in place: x [size()] and y [rows of the model] hold a and b on entry and the solution on return. Returns
  /// the residual of the forces relative to the largest force among a and the terms that it balances.
  double solve(double* x, double* y, int refinements = 3);
  /// Solves for many right-hand sides at once, x [size(), columns] and y [rows, columns]; returns the worst residual.
  double solve(Eigen::Ref<Eigen::MatrixXd> x, Eigen::Ref<Eigen::MatrixXd> y, Accuracy accuracy);
  /// Computes x := (A^-1 - A^-1 K C K'A^-1) x by columns. The result differs from that of `solve` with b = 0 by the
  /// square of W/C, 1e-10 if K is well conditioned. The operator is linear and symmetric, as Lanczos' method requires.
  void solve_roughly(Eigen::MatrixXd* x);
  /// Returns |b - K'x|/|b| after the last solve; it is near 1 if dependent rows demand what no move can do.
  double row_residual() const { return row_residual_; }

  /// Returns the number of omega^2 below the given one, 1/s^2, from the signs of the pivots of A = L D L' (Sylvester).
  /// Returns nothing if an omega^2 lies there to rounding, so that a pivot vanishes.
  ///
  /// Near a mode the signs are those of A only if C exceeds W^2 over the product of the distance from the mode and the
  /// squared singular values of K. `stiffer` multiplies C, and with it the rounding error.
  std::optional<std::size_t> count_below(double omega2, double stiffer = 1.0);
  /// Returns the number of mu < 1 of Z'WZ q = mu Z'LMZ q, where L holds omega^2 [moving point], 1/s^2. With L
  /// proportional to the scale of each island, mu = 1 means the same in all of them. Negative entries count those below
  /// mu = -1.
  std::optional<std::size_t> count_below(std::vector<double> omega2, double stiffer = 1.0);

 private:
  void follow_pattern();
  void solve_shifted(Eigen::MatrixXd* x, Eigen::MatrixXd* y, double of_rows);
  void find_multipliers(Eigen::MatrixXd* x, Eigen::MatrixXd* y, double of_rows);
  void apply_inverse(Eigen::MatrixXd* x);
  void add_reactions(const Eigen::MatrixXd& lambda, Eigen::MatrixXd* y) const;
  void apply_transposed(const Eigen::MatrixXd& x, Eigen::MatrixXd* rows) const;

  const EquilibriumEquations& equations_;
  const Model& model_;
  Ordering ordering_;
  std::optional<AugmentedStiffness> matrix_;  // for the current pattern of W
  std::optional<Multifrontal> factor_;
  std::vector<double> penalties_;  // C [row] of the factor, N/m over squared gradients
  std::vector<double> shifts_;     // s [moving point], 1/s^2
  std::vector<double> lanes_;      // scratch: columns in the order of the factor, in packs
  double row_residual_ = 0.0;
  // [size() or rows, columns]
  Eigen::MatrixXd rows_residual_, scaled_, image_, move_, direction_, direction_image_, direction_move_;
};

}  // namespace tanor::detail
