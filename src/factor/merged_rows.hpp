#pragma once

#include "factor/sparse_qr.hpp"

namespace tanor {

/// QR factorization of C in the order in which its columns stand, column by column, by Givens rotations of the rows
/// that begin there. For orders that make no fill (chains, trees): what SuiteSparseQR spends on its small fronts is
/// most of its time there. A column that is less than `tolerance` away from those before it is left out.
///
/// Rows that a column leaves over wait, as a trapezoid, where they begin (A. George, M. T. Heath 1980; J. W. H. Liu
/// 1986).
TriangularFactor merge_rows(const SparseColumns& C, double tolerance);

}  // namespace tanor
