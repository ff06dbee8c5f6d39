#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "factor/dependent_columns.hpp"

namespace tanor::detail {

/// Solves S x = b with S = C'C, where the columns of C = M^-1/2 K of one island, [m x d], may depend on each other.
///
/// D scales the columns to unit length and I names the independent ones, so that C D = (C D)_I [1 X]. S is never
/// formed. The steps are
///  0. Columns that no dependence can contain are found from their entries at points (find_columns_in_question). The
///     others are decided group by group, by a QR factorization of each group.
///  1. QR leaves out each column closer than the tolerance to those before it (Heath).
///  2. A dependence spread over many columns is found by the smallest singular value of R11 (inverse iteration), and
///     its largest column is left out (Foster and Davis, Algorithm 933, ACM TOMS 40, 2013).
///  3. Columns are exchanged until |X| <= 2. I is then about as well conditioned as C allows (Gu and Eisenstat, SIAM
///     J. Sci. Comput. 17, 1996), and among equals the later column is the dependent one.
/// (C D)_I is factorized at the first solve. Multipliers and right sides below are those of C; the scaling stays
/// inside.
class RankSolver {
 public:
  /// Decides the rank with the tolerance 20 (m + d) eps for unit columns, or `least_tolerance`, to which C itself is
  /// known, if that is more. Throws std::bad_alloc.
  explicit RankSolver(SparseColumns C, double least_tolerance = 0.0, QrFunction& factorize = factorize_qr);
  /// Takes over what was decided for columns that differ from C by positive factors of their rows alone, so that the
  /// same combinations vanish.
  RankSolver(SparseColumns C, const RankSolver& decided);

  std::size_t rank() const { return num_columns() - dependences_.size(); }
  std::size_t num_columns() const { return scale_.size(); }
  double tolerance() const { return tolerance_; }
  /// Returns the estimate from above for (C D)_I, which is factorized at the first call.
  double smallest_singular_value();
  /// Returns the same for the columns that may depend on others, at most 1. Dependences are known to eps over it.
  double singular_value_in_question() const { return sigma_in_question_; }

  /// Returns a dependence for each dependent column, by increasing column. Terms that are rounding are left out.
  const std::vector<Dependence>& dependences() const { return dependences_; }
  /// Returns for each multiplier if it is the same in every solution, [d].
  std::vector<bool> unique() const;

  /// Replaces the right side in x, [d], by a solution that is 0 at the dependent columns, whose right sides are not
  /// read. Its rounding error is cond(R11) eps of the right side; the caller refines it.
  void solve(double* x);

  /// Turns the solution x, [d], into the one with the smallest Euclidean norm by taking away its part along the null
  /// space of C.
  void minimize_norm(double* x) const;

  /// The part of the right side beyond the range of C', for each dependent column: b_j - sum of coefficient b_i.
  struct Contradiction {
    int column;
    double excess;     ///< unit of b
    double magnitude;  ///< |b_j| + sum of |coefficient b_i|: an excess of eps/sigma_min of it is rounding
  };
  std::vector<Contradiction> contradictions(std::span<const double> b) const;

 private:
  void scale_columns();
  void find_dependences();
  SparseColumns take_group(const std::vector<int>& group, std::vector<int>* row_name) const;
  const TriangularFactor& factor();
  void span_null_space(const std::vector<Dependence>& dependences);
  void drop_rounding();

  QrFunction& factorize_;
  SparseColumns C_;            ///< unit columns
  std::vector<double> scale_;  ///< [d] diagonal of D
  double tolerance_ = 0.0;
  double sigma_in_question_ = 1.0;
  std::vector<Dependence> dependences_;
  std::optional<TriangularFactor> factor_;  ///< of (C D)_I
  std::optional<double> smallest_singular_value_;
  SparseColumns null_space_;  ///< [d x (d - rho)] Z, unit columns that span the null space of C
  TriangularFactor null_factor_;
};

/// Says how the columns of K are scaled before QR: not at all, or to those of M^-1/2 K.
enum class Scaling { None, ByMasses };

/// Decides the rank of the columns `make` of M^-1/2 K. These come together if masses differ much; but their rank is
/// that of K, so that K decides wherever it keeps more columns apart. `find_mass_ratio` returns the largest over the
/// smallest mass and is called if some column depends on others.
std::unique_ptr<RankSolver> decide_rank(const std::function<SparseColumns(Scaling)>& make, double tolerance,
                                        const std::function<double()>& find_mass_ratio);

}  // namespace tanor::detail
