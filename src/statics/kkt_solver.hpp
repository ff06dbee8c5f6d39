#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "factor/multifrontal.hpp"
#include "statics/augmented_stiffness.hpp"
#include "statics/equilibrium_equations.hpp"

namespace tanor {

/// Solves  [ W + s M  K ] [ x ]   [ a ]
///         [ K'       0 ] [ y ] = [ b ]   for symmetric W, by a sparse Cholesky factor of
///
///   A = W + s M + K C K'      (AugmentedStiffness)
///
/// and conjugate residuals on K'A^-1K y = K'A^-1(a + KCb) - b, whose matrix is nearly C^-1: two or three of them
/// suffice. Residuals of the whole system refine the answer to rounding. Rows that depend on each other do no harm
/// where b is consistent.
class KktSolver {
 public:
  /// Reads `equations` where they were linearised last, whenever it factorizes; these outlive the solver.
  explicit KktSolver(const EquilibriumEquations& equations, Ordering ordering = Ordering::Auto);

  /// Factorizes A for the shift s, 1/s^2. False: it is not positive definite, so some omega^2 of
  /// Z'WZ q = omega^2 Z'MZ q is at or below -s, and there is no factor.
  [[nodiscard]] bool factorize(double shift);
  /// The same with a shift of its own for each moving point.
  [[nodiscard]] bool factorize(std::vector<double> shifts);
  struct Accuracy {
    int refinements = 3;     ///< how often the whole system is asked
    double of_rows = 1e-24;  ///< of the squares of K'x - b, at which conjugate residuals leave the rest to the next one
  };
  /// x [size()] := a, y [rows of the model] := b on entry; the solution on return. Returns the residual of forces over
  /// the largest force among a and the terms that it balances.
  double solve(double* x, double* y, int refinements = 3);
  /// The same of many right-hand sides at once, x [size(), columns] and y [rows, columns]; the worst residual.
  double solve(Eigen::Ref<Eigen::MatrixXd> x, Eigen::Ref<Eigen::MatrixXd> y, Accuracy accuracy);
  /// x := (A^-1 - A^-1 K C K'A^-1) x by columns: what `solve` gives where b = 0, but for the square of W over C, 1e-10
  /// where K is well conditioned. It is linear and symmetric, as Lanczos' method wants it.
  void solve_roughly(Eigen::MatrixXd* x);
  /// |b - K'x| over |b| after the last solve: near 1 where rows that depend on each other want what no move can do.
  double row_residual() const { return row_residual_; }

  /// How many omega^2 lie below the given one, 1/s^2, by the signs of the pivots of A = L D L' (Sylvester). Empty: one
  /// lies there to rounding, so that a pivot vanishes.
  ///
  /// Near a mode the signs are those of A only where C exceeds W^2 over the distance from it times the squared singular
  /// values of K: `stiffer` multiplies C, and rounding.
  std::optional<std::size_t> count_below(double omega2, double stiffer = 1.0);
  /// The same of Z'WZ q = mu Z'LMZ q below mu = 1, where L is of [moving point], 1/s^2: 1 is then as much of each
  /// island's own scale. Negative ones: below mu = -1.
  std::optional<std::size_t> count_below(std::vector<double> omega2, double stiffer = 1.0);

 private:
  void follow_pattern();
  void solve_shifted(Eigen::MatrixXd* x, Eigen::MatrixXd* y, double of_rows);
  void find_multipliers(Eigen::MatrixXd* x, Eigen::MatrixXd* y, double of_rows);
  void apply_inverse(Eigen::MatrixXd* x);
  void apply_inverse_by_eights(Eigen::MatrixXd* x) const;
  void add_reactions(const Eigen::MatrixXd& lambda, Eigen::MatrixXd* y) const;
  void apply_transposed(const Eigen::MatrixXd& x, Eigen::MatrixXd* rows) const;

  const EquilibriumEquations& equations_;
  const Model& model_;
  Ordering ordering_;
  std::optional<AugmentedStiffness> matrix_;  // of the pattern that W has
  std::optional<Multifrontal> factor_;
  std::vector<double> penalties_;  // C [row] of the factor, N/m over squared gradients
  std::vector<double> shifts_;     // s [moving point], 1/s^2
  double row_residual_ = 0.0;
  std::vector<double> ordered_;  // scratch [size()]
  // [size() or rows, columns]
  Eigen::MatrixXd rows_residual_, scaled_, image_, move_, direction_, direction_image_, direction_move_;
};

}  // namespace tanor
