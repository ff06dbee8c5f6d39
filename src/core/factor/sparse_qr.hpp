#pragma once

#include <cstddef>
#include <vector>

#include "factor/sparse_columns.hpp"

namespace tanor::detail {

/// Upper triangular factor R11 of C(:, independent) = Q R11, rho x rho, with the diagonal entry of each column last. Q
/// is not kept.
struct TriangularFactor : SparseColumns {
  std::vector<int> independent;  ///< [rho] column of R11 -> column of C, in the order of elimination
  std::vector<int> dependent;    ///< columns of C that are left out, increasing

  /// Sets R11 to the rows that a QR has found, as columns over those of C. They may have entries at dependent columns
  /// too, which are left out.
  void set_rows(const SparseColumns& rows_of_R);

  std::size_t rank() const { return independent.size(); }
  void solve(double* x) const;             ///< x := R11^-1 x, [rho]
  void solve_transposed(double* x) const;  ///< x := R11^-T x, [rho]
};

/// Computes the QR factorization of C in COLAMD's order, by factorize_by_fronts, or by SuiteSparseQR if built with
/// TANOR_GPL. A column that is less than `tolerance` away from those before it is left out as dependent (M. T. Heath,
/// SIAM J. Sci. Stat. Comput. 3, 1982). That finds every dependence that shows in a single |R_jj|, but not one that is
/// spread over many. A negative tolerance leaves out zero columns alone. Throws std::bad_alloc, std::length_error.
TriangularFactor factorize_qr(const SparseColumns& C, double tolerance);

/// The type of factorize_qr and of functions that are compared with it.
using QrFunction = TriangularFactor(const SparseColumns& C, double tolerance);

/// Does so by dense fronts of rows (I. S. Duff, J. K. Reid 1983; J. W. H. Liu 1986). The fronts are the supernodes of
/// C'C. A front has the rows of C that begin at its own columns, and the rows that its children left over. Its
/// trapezoid gives rows of R at its own columns; the remaining rows belong to its parent.
TriangularFactor factorize_by_fronts(const SparseColumns& C, double tolerance);

/// Does so by SuiteSparseQR, which is GPL-2.0-or-later. It is part of the library if TANOR_GPL is on.
TriangularFactor factorize_with_suitesparse(const SparseColumns& C, double tolerance);

/// Does so in the given order of columns, row by row, by plane rotations (A. George, M. T. Heath 1980), which keep the
/// digits of rows of very different sizes. It is meant for orders that make no fill (chains, trees). There it is five
/// times as fast as factorize_by_fronts, which first looks for an order and for supernodes. What is left of the row of
/// a column that is left out is rotated into the rows behind it (M. T. Heath 1982).
TriangularFactor merge_rows(const SparseColumns& C, double tolerance);

}  // namespace tanor::detail
