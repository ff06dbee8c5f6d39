#pragma once

#include <cstddef>
#include <vector>

#include "factor/sparse_columns.hpp"

namespace tanor::detail {

/// Upper triangular factor R11 of C(:, independent) = Q R11, rho x rho. Q is not kept.
struct TriangularFactor {
  std::vector<int> independent;  ///< [rho] column of R11 -> column of C, in the order of elimination
  std::vector<int> dependent;    ///< columns of C that are left out, increasing
  std::vector<int> start{0};     ///< columns of R11 as in SparseColumns, the diagonal entry last
  std::vector<int> rows;
  std::vector<double> values;

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

}  // namespace tanor::detail
