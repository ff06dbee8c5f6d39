#pragma once

#include <vector>

#include "factor/sparse_qr.hpp"

namespace tanor::detail {

struct IndependentColumns {
  TriangularFactor factor;         ///< R11 of the independent columns; lists the dependent ones
  double smallest_singular_value;  ///< estimate for R11 from above
};

/// Finds independent columns by Heath's method, with one column fewer for each singular value of R11 below the
/// tolerance that it missed: a column that is large in its singular vector (Foster and Davis, Algorithm 933, ACM TOMS
/// 40, 2013). A column that the method drops after a miss is not trusted. It may have taken rounding for a
/// direction and so used up the direction of a later, independent column. C must have columns of unit length.
IndependentColumns find_independent_columns(const SparseColumns& C, double tolerance,
                                            QrFunction& factorize = factorize_qr);

/// Computes the QR factorization of some columns of C, which keep their numbers in C.
TriangularFactor factorize_columns(const SparseColumns& C, const std::vector<int>& wanted, double tolerance,
                                   QrFunction& factorize);

/// Returns all columns but `left_out`, which increase.
std::vector<int> all_but(const std::vector<int>& left_out, std::size_t num_columns);

/// Estimates the smallest singular value by inverse iteration with R'R. The estimate is from above, and close if the
/// value is small.
double find_smallest_singular_value(const TriangularFactor& R);

}  // namespace tanor::detail
