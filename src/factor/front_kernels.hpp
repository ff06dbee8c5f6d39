#pragma once

#include <cstddef>

/// \file Dense arithmetic of Multifrontal, compiled for each instruction set. Columns stand `stride` numbers apart,
/// which is a multiple of `front_width`, and are filled up with zeros. Up to `front_width` numbers behind an array are
/// read.
namespace tanor_kernels {

inline constexpr std::size_t front_width = 8;

/// Replaces the first columns of a front, whose lower triangle stands in `panel` [rows, columns], by those of L. What
/// is above the diagonal becomes 0. Returns the first column without a positive pivot, or `columns`.
std::size_t factorize_panel(std::size_t columns, std::size_t rows, std::size_t stride, double* panel);

/// update = -a a', lower triangle; a [rows, terms], update [rows, rows].
void set_negative_square(std::size_t rows, std::size_t terms, const double* a, std::size_t stride, double* update,
                         std::size_t update_stride);

/// A block of a large front: whole lanes of rows.
struct FrontBlock {
  std::size_t rows, columns;
  bool is_lower = false;  // what is above the diagonal is not needed
  bool is_fresh = false;  // counts as 0 before
};
/// c -= a b'; a [rows, terms], b [columns, terms].
void subtract_block(const FrontBlock& block, std::size_t terms, const double* a, const double* b, std::size_t stride,
                    double* c, std::size_t c_stride);
/// x := x L11'^-1; x [rows, columns], L11 in `diagonal`.
void divide_block(std::size_t columns, std::size_t rows, const double* diagonal, std::size_t stride, double* x);

/// to[rows[i], rows[j]] += from[i, j] of the columns [first, end) and, of each, the rows [low, high) from j on.
void add_columns(std::size_t first, std::size_t end, std::size_t low, std::size_t high, const int* rows,
                 const double* from, std::size_t from_stride, double* to, std::size_t to_stride);

/// y := L11^-1 y of the first columns, y -= L21 y of the rows below; y [rows], zeros behind what counts.
void substitute_forwards(std::size_t columns, std::size_t rows, std::size_t stride, const double* panel,
                         const double* inverse_pivots, double* y);
/// y := L11'^-1 (y - L21' y below) of the first columns.
void substitute_backwards(std::size_t columns, std::size_t rows, std::size_t stride, const double* panel,
                          const double* inverse_pivots, double* y);
/// y -= a x; a [rows, columns] in `panel`.
void subtract_product(std::size_t columns, std::size_t rows, std::size_t stride, const double* panel, const double* x,
                      double* y);
/// sums = a' y.
void find_products(std::size_t columns, std::size_t rows, std::size_t stride, const double* panel, const double* y,
                   double* sums);

}  // namespace tanor_kernels
