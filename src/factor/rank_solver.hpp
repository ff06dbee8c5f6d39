#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "factor/dependent_columns.hpp"

namespace tanor {

/// Solves S x = b with S = C'C, where the columns of C = M^-1/2 K of one island, [m x d], may depend on each other.
///
/// D scales the columns to unit length and I names the independent ones, so that C D = (C D)_I [1 X]. S is never
/// formed:
///  0. Columns that no dependence can have are told from their places (find_columns_in_question); the others are
///     decided group by group, by QR of their own.
///  1. QR leaves out each column closer than the tolerance to those before it (Heath).
///  2. A dependence spread over many columns is found by the smallest singular value of R11 (inverse iteration), and
///     its largest column left out (Foster and Davis, Algorithm 933, ACM TOMS 40, 2013).
///  3. Exchange of columns until |X| <= 2: I is then about as well conditioned as C allows (Gu and Eisenstat, SIAM J.
///     Sci. Comput. 17, 1996), and among equals the later column is the dependent one.
/// (C D)_I is factorized where there is a solve. Multipliers and right sides below are those of C; the scaling stays
/// inside.
class RankSolver {
 public:
  /// Tolerance of unit columns: 20 (m + d) eps, or what C itself is known to where that is more. Throws std::bad_alloc.
  explicit RankSolver(SparseColumns C, double least_tolerance = 0.0, QrFunction& factorize = factorize_qr);

  std::size_t rank() const { return num_columns() - dependences_.size(); }
  std::size_t num_columns() const { return scale_.size(); }
  double tolerance() const { return tolerance_; }
  /// Of (C D)_I, from above. Factorizes where nothing has before.
  double smallest_singular_value();
  /// The same, of columns that may depend on others: what dependences are known to is eps over it. At most 1.
  double singular_value_in_question() const { return sigma_in_question_; }

  /// One dependence for each dependent column, by increasing column. Terms that are rounding are left out.
  const std::vector<Dependence>& dependences() const { return dependences_; }
  /// Is multiplier k the same in every solution? [d]
  std::vector<bool> unique() const;

  /// Replaces the right side in x, [d], by a solution that is 0 at the dependent columns, whose right sides are not
  /// read. Its rounding is cond(R11) eps of the right side; the caller refines.
  void solve(double* x);

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
  void find_dependences();
  SparseColumns take_group(const std::vector<int>& group, std::vector<int>* row_name) const;
  const TriangularFactor& factor();
  void span_null_space();
  void drop_rounding();

  QrFunction& factorize_;
  SparseColumns C_;            ///< unit columns
  std::vector<double> scale_;  ///< [d] diagonal of D
  double tolerance_ = 0.0;
  double sigma_in_question_ = 1.0;
  std::vector<Dependence> dependences_;
  std::optional<TriangularFactor> factor_;  ///< of (C D)_I
  std::optional<double> smallest_singular_value_;
  SparseColumns null_space_;  ///< [d x (d - rho)] Z = D [-X; 1], unit columns: they span the null space of C
  TriangularFactor null_factor_;
};

/// How the columns of K stand before QR: as they are, or as those of M^-1/2 K.
enum class Scaling { None, ByMasses };

/// The columns `make` of M^-1/2 K, decided. They come together where masses differ much: what K itself keeps apart
/// depends on nothing, however little K is known. Then those of M^-1/2 K are told apart down to rounding.
/// `find_mass_ratio`: largest over smallest mass, asked for where something depends.
std::unique_ptr<RankSolver> decide_rank(const std::function<SparseColumns(Scaling)>& make, double tolerance,
                                        const std::function<double()>& find_mass_ratio);

}  // namespace tanor
