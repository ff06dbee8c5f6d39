#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "factor/cholesky.hpp"
#include "statics/equilibrium_equations.hpp"

namespace tanor {

/// Solves  [ W + s M  K ] [ x ]   [ a ]
///         [ K'       0 ] [ y ] = [ b ]   for symmetric W, by a sparse Cholesky factor of
///
///   A = W + s M + K C K'      (C > 0 diagonal; Gould 1985: A is positive definite for large C where Z'(W + s M)Z is)
///
/// in a good order of elimination, and conjugate gradients on K'A^-1K y = K'A^-1(a + KCb) - b, whose matrix is nearly
/// C^-1: two or three of them suffice. Residuals of the whole system refine the answer to rounding. Rows that depend on
/// each other do no harm where b is consistent.
class KktSolver {
 public:
  /// Reads `equations` where they were linearised last; these outlive the solver.
  explicit KktSolver(const EquilibriumEquations& equations, Ordering ordering = Ordering::Auto);

  /// Factorizes A for the shift s, 1/s^2. False: it is not positive definite, so some omega^2 of
  /// Z'WZ q = omega^2 Z'MZ q is at or below -s, and there is no factor.
  [[nodiscard]] bool factorize(double shift);
  /// x [size()] := a, y [num_rows of the model] := b on entry; the solution on return. Returns the norm of the residual
  /// over that of (a, b), each in its own unit.
  double solve(double* x, double* y);

  /// How many omega^2 lie below the given one, 1/s^2, by the signs of the pivots of A = L D L' (Sylvester). Empty: an
  /// omega^2 lies there to rounding, so that a pivot vanishes.
  std::optional<std::size_t> count_below(double omega2);

 private:
  void analyze();
  void assemble(double shift, double* values) const;

  const EquilibriumEquations& equations_;
  Ordering ordering_;
  std::size_t version_ = 0;         // of the pattern that was analyzed
  std::vector<int> place_;          // [unknown] -> place in the elimination
  std::vector<int> stiffness_slots_, product_slots_;
  std::optional<Cholesky> factor_;
  std::vector<double> penalties_;   // C [row], N/m over squared gradients
  double shift_ = 0.0;
  std::vector<double> x_, z_, p_, q_;  // scratch
};

}  // namespace tanor
