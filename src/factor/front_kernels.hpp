#pragma once

#include <cstddef>

/// \file Dense arithmetic of Multifrontal, compiled for each instruction set. Columns stand `stride` numbers apart,
/// which is a multiple of `front_width`, and are filled up with zeros. Up to `front_width` numbers behind an array are
/// read.
namespace tanor_kernels {

inline constexpr std::size_t front_width = 8;

/// Replaces the first columns of a front, whose lower triangle stands in `panel`, by those of L. What is above the
/// diagonal becomes 0. Returns the first column without a positive pivot, or `columns`.
std::size_t factorize_panel(std::size_t columns, std::size_t stride, double* panel);

/// update -= a a', lower triangle; a [rows, depth], update [rows, rows].
void subtract_square(std::size_t rows, std::size_t depth, const double* a, std::size_t stride, double* update,
                     std::size_t update_stride);

/// y := L11^-1 y of the first columns, y -= L21 y of the rows below; y [stride], zeros behind the rows.
void substitute_forwards(std::size_t columns, std::size_t stride, const double* panel, const double* inverse_pivots,
                         double* y);
/// y := L11'^-1 (y - L21' y below) of the first columns.
void substitute_backwards(std::size_t columns, std::size_t stride, const double* panel, const double* inverse_pivots,
                          double* y);

}  // namespace tanor_kernels
