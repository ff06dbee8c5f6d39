#pragma once

#include <vector>

#include "factor/sparse_qr.hpp"

/// \file The steps in which RankSolver decides which columns depend on others. C must have columns of unit length.
namespace tanor::detail {

/// Returns the columns of C that may depend on others, in groups that have no row in common. Groups and their columns
/// are in increasing order.
///
/// Rows are taken in triples, the components of a point. If the part of a column in such a triple is not in the span of
/// the other columns' parts there, no dependence contains this column,
///
///   v'c_q = 0 for all others q there  =>  v'C x = x_p v'c_p,
///
/// and without it more columns may stand out. Chains with a free end dissolve rod by rod in this way, and little is
/// left that needs a factor. Bounds of |x_p| over |C x| are carried along. A column stays in question if its own bound
/// is above 1e-4 over the tolerance, since rounding might then hide a dependence.
std::vector<std::vector<int>> find_columns_in_question(const SparseColumns& C, double tolerance);

/// States that column `column` of K is the sum of `coefficient` times the columns of `terms`.
struct Dependence {
  struct Term {
    int column;
    double coefficient;  ///< for columns scaled to unit length, so that its sign and size say how much it matters
  };
  int column;
  std::vector<Term> terms;  ///< largest first; empty for a column of zeros
};

/// The decomposition C = C_I [1 X], where I names independent columns.
struct DependentColumns {
  TriangularFactor factor;                ///< factor of C_I; lists the dependent ones
  double smallest_singular_value = 0.0;   ///< estimate for R11 from above
  std::vector<Dependence> dependences{};  ///< X by its columns, increasing; terms above the tolerance
  /// Combinations of other columns that span the same null space, to rounding. They have fewer terms where |X| <= 2
  /// asks for long ones.
  std::vector<Dependence> short_dependences{};
};

/// Finds independent columns by Heath's method, with one column fewer for each singular value of R11 below the
/// tolerance that it missed: a column that is large in its singular vector (Foster and Davis, Algorithm 933, ACM TOMS
/// 40, 2013). A column that the method drops after a miss is not trusted. It may have taken rounding for a
/// direction and so used up the direction of a later, independent column. X is left out.
DependentColumns find_independent_columns(const SparseColumns& C, double tolerance,
                                          QrFunction& factorize = factorize_qr);

/// Decides which columns depend on others, as RankSolver says.
DependentColumns find_dependent_columns(const SparseColumns& C, double tolerance, QrFunction& factorize);

/// Computes the QR factorization of all columns but some, which increase. They keep their numbers in C.
TriangularFactor factorize_without(const std::vector<int>& left_out, const SparseColumns& C, double tolerance,
                                   QrFunction& factorize);

/// Estimates the smallest singular value by inverse iteration with R'R. The estimate is from above, and close if the
/// value is small.
double find_smallest_singular_value(const TriangularFactor& R);

}  // namespace tanor::detail
