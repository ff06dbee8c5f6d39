#pragma once

#include <span>
#include <vector>

#include "factor/sparse_qr.hpp"

namespace tanor {

/// Column `column` of K is the sum of coefficient times the columns of `terms`.
struct Dependence {
  struct Term {
    int column;
    double coefficient;  ///< of the unit columns: their signs and sizes say how much each one matters
  };
  int column;
  std::vector<Term> terms;  ///< largest first; none: a column of zeros
};

/// Solves S x = b with S = C'C, where the columns of C = M^-1/2 K of one island, [m x d], may depend on each other.
///
/// D scales the columns to unit length and I names the independent ones, so that C D = (C D)_I [1 X]. S is never
/// formed; what is factorized is (C D)_I, by QR:
///  1. QR leaves out each column closer than the tolerance to those before it (Heath).
///  2. A dependence spread over many columns is found by the smallest singular value of R11 (inverse iteration), and
///     its largest column left out (Foster and Davis, Algorithm 933, ACM TOMS 40, 2013).
///  3. Exchange of columns until |X| <= 2: I is then about as well conditioned as C allows (Gu and Eisenstat, SIAM J.
///     Sci. Comput. 17, 1996), and among equals the later column is the dependent one.
/// Multipliers and right sides below are those of C; the scaling stays inside.
class RankSolver {
 public:
  /// Tolerance of unit columns: 20 (m + d) eps, or what C itself is known to where that is more. Throws std::bad_alloc.
  explicit RankSolver(SparseColumns C, double least_tolerance = 0.0, QrFunction& factorize = factorize_qr);

  std::size_t rank() const { return factor_.rank(); }
  std::size_t num_columns() const { return scale_.size(); }
  double tolerance() const { return tolerance_; }
  double smallest_singular_value() const { return smallest_singular_value_; }  ///< of R11, from above

  /// One dependence for each dependent column, by increasing column. Terms that are rounding are left out.
  const std::vector<Dependence>& dependences() const { return dependences_; }
  /// Is multiplier k the same in every solution? [d]
  std::vector<bool> unique() const;

  /// Replaces the right side in x, [d], by a solution that is 0 at the dependent columns, whose right sides are not
  /// read. Its rounding is cond(R11) eps of the right side; the caller refines.
  void solve(double* x) const;

  /// Turns the solution x, [d], into the one with the smallest Euclidean norm by taking away its part along the null
  /// space of C.
  void minimize_norm(double* x) const;

  /// What the right side asks beyond the range of C', for each dependent column: b_j - sum of coefficient b_i.
  struct Contradiction {
    int column;
    double excess;     ///< unit of b
    double magnitude;  ///< |b_j| + sum of |coefficient b_i|: the excess is rounding where it is eps/sigma_min of it
  };
  std::vector<Contradiction> contradictions(std::span<const double> b) const;

 private:
  void find_independent_columns();
  void combine_dependent_columns();
  bool exchange_columns();
  void span_null_space();
  void drop_rounding();
  std::vector<double> solve_normal(std::vector<double> y) const;

  QrFunction& factorize_;
  SparseColumns C_;             ///< unit columns
  SparseColumns transposed_C_;  ///< [d x m]
  std::vector<double> scale_;   ///< [d] diagonal of D
  double tolerance_ = 0.0;
  TriangularFactor factor_;  ///< of (C D)_I
  double smallest_singular_value_ = 0.0;
  std::vector<Dependence> dependences_;
  SparseColumns null_space_;  ///< [d x (d - rho)] Z = D [-X; 1], unit columns: they span the null space of C
  TriangularFactor null_factor_;
};

}  // namespace tanor
