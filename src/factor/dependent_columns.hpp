#pragma once

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

/// C = C_I [1 X], where I names independent columns.
struct DependentColumns {
  std::vector<Dependence> dependences;  ///< X by its columns, increasing; terms as they come, rounding too
  TriangularFactor factor;              ///< of C_I
  double smallest_singular_value;       ///< of R11, from above
};

/// As RankSolver says. C has columns of unit length.
DependentColumns find_dependent_columns(const SparseColumns& C, double tolerance, QrFunction& factorize);

}  // namespace tanor
