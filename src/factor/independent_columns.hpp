#pragma once

#include <vector>

#include "factor/sparse_qr.hpp"

namespace tanor {

struct IndependentColumns {
  TriangularFactor factor;         ///< R11 of the independent columns; the dependent ones by name
  double smallest_singular_value;  ///< of R11, from above
};

/// Heath's method, with one column fewer for each singular value of R11 below the tolerance that it missed: the largest
/// one in its singular vector (Foster and Davis, Algorithm 933, ACM TOMS 40, 2013). A column that it drops after a miss
/// is not trusted: it may have taken rounding for a direction and so used up that of a later, independent column.
/// C has columns of unit length.
IndependentColumns find_independent_columns(const SparseColumns& C, double tolerance,
                                            QrFunction& factorize = factorize_qr);

/// QR of some columns of C, which keep their numbers in C.
TriangularFactor factorize_columns(const SparseColumns& C, const std::vector<int>& wanted, double tolerance,
                                   QrFunction& factorize);

/// All but the columns `left_out`, which increase.
std::vector<int> all_but(const std::vector<int>& left_out, std::size_t num_columns);

/// By inverse iteration with R'R: from above, near where it matters.
double find_smallest_singular_value(const TriangularFactor& R);

}  // namespace tanor
