#pragma once

#include "factor/sparse_qr.hpp"

namespace tanor::detail {

/// Computes the QR factorization of C in COLAMD's order of its columns, by dense fronts of rows (I. S. Duff, J. K. Reid
/// 1983; J. W. H. Liu 1986). The fronts are the supernodes of C'C. A front has the rows of C that begin at its own
/// columns, and the rows that its children left over. Its trapezoid gives rows of R at its own columns; the remaining
/// rows belong to its parent. Dependent columns are left out as factorize_qr says.
TriangularFactor factorize_by_fronts(const SparseColumns& C, double tolerance);

}  // namespace tanor::detail
