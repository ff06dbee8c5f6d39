#pragma once

#include <cstddef>

/// \file Dense arithmetic of the multifrontal QR, compiled for each instruction set.
namespace tanor::detail::kernels {

/// Numbers behind the last row of each column that kernels read; they must be 0.
inline constexpr std::size_t rows_read_beyond = 8;

/// Dense rows over some columns of C. Rows that begin further right stand further down.
struct RowFront {
  std::size_t rows = 0, columns = 0, stride = 0;  ///< stride of the columns, at least rows + rows_read_beyond
  double* values = nullptr;                       ///< column by column
  const std::size_t* height = nullptr;            ///< [columns] end of the rows that begin at a column or before it
};

/// Reduces the front to a trapezoid by Householder reflections, four at once (R. Schreiber and C. Van Loan, SIAM J.
/// Sci. Stat. Comput. 10, 1989). At most one row begins at each column; row_at [columns] names it, or is -1 if there is
/// none. No row begins at one of the first `own` columns that is no longer than `tolerance` below the rows before it;
/// what remains there is rounding. `scratch` holds 4 strides. Returns the number of rows.
std::size_t reduce_rows(const RowFront& front, std::size_t own, double tolerance, double* scratch, int* row_at);

}  // namespace tanor::detail::kernels
