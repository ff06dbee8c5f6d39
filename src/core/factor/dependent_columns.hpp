#pragma once

#include <vector>

#include "factor/sparse_qr.hpp"

namespace tanor::detail {

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
  std::vector<Dependence> dependences;  ///< X by its columns, increasing; terms above the tolerance
  /// Combinations of other columns that span the same null space, to rounding. They have fewer terms where |X| <= 2
  /// asks for long ones.
  std::vector<Dependence> short_dependences;
  TriangularFactor factor;         ///< factor of C_I
  double smallest_singular_value;  ///< estimate for R11 from above
};

/// Decides which columns depend on others, as RankSolver says. C must have columns of unit length.
DependentColumns find_dependent_columns(const SparseColumns& C, double tolerance, QrFunction& factorize);

}  // namespace tanor::detail
