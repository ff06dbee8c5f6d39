#pragma once

#include <cstddef>
#include <span>

/// \file Dense arithmetic of Multifrontal, compiled for each instruction set. Columns stand `stride` numbers apart,
/// which is a multiple of `front_width`, and are filled up with zeros. Up to `front_width` numbers behind an array are
/// read.
namespace tanor::kernels {

inline constexpr std::size_t front_width = 8;

/// Replaces the first columns of a front, whose lower triangle stands in `panel` [rows, columns], by those of L. What
/// is above the diagonal becomes 0. Returns the first column without a positive pivot, or `columns`.
std::size_t factorize_panel(std::size_t columns, std::size_t rows, std::size_t stride, double* panel);

/// The lower triangle of an update. Blocks of columns that begin at the diagonal take half of a square, and little
/// more.
struct Triangle {
  static constexpr std::size_t width = 32;  ///< columns of a block, whole lanes

  double* numbers;
  std::size_t stride;  ///< of the first block; that of each is `width` less than that of the one before

  static std::size_t size(std::size_t columns, std::size_t stride) {
    const std::size_t first = columns / width * width;
    return start(first, stride) + (columns - first) * (stride - first);
  }
  std::size_t stride_of(std::size_t j) const { return stride - j / width * width; }
  /// Column j, whose row i stands at [i], from the first row of its block on.
  double* column(std::size_t j) const {
    const std::size_t first = j / width * width;
    return numbers + start(first, stride) + (j - first) * (stride - first) - first;
  }

 private:
  static std::size_t start(std::size_t first, std::size_t stride) {  // sum of the sizes of the blocks before
    return first * stride - first * first / 2 + first * width / 2;
  }
};

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

/// Where the rows of a child are in its parent. Rows up to run_end[i] follow the i-th one there as they do here.
struct RowsInParent {
  const int *rows, *run_end;
};
/// Part of a triangle: the columns [first, end) and, of each, the rows [low, high) from the diagonal on.
struct TrianglePart {
  std::size_t first, end, low, high;
};
/// to[rows[i], rows[j]] += from[i, j]
void add_to_panel(const TrianglePart& part, const RowsInParent& in_parent, const Triangle& from, double* to,
                  std::size_t to_stride);
/// to[rows[i] - columns, rows[j] - columns] += from[i, j]
void add_to_update(const TrianglePart& part, const RowsInParent& in_parent, const Triangle& from, std::size_t columns,
                   const Triangle& to);

/// An update that a front takes from a child: its first rows are among the columns of the front.
struct ChildUpdate {
  RowsInParent in_parent;
  Triangle update;
  std::size_t rows_in_panel, rows;
};
/// A front whose panel [stride, columns] holds the entries of S.
struct WholeFront {
  std::size_t columns, stride, below;
  double* panel;
  Triangle update;
  std::span<const ChildUpdate> children;
};
/// Adds the updates of the children, replaces the panel by L and writes the front's own update, all in one call: small
/// fronts take less time than several calls. Returns the first column without a positive pivot, or all columns.
std::size_t eliminate_front(const WholeFront& front);

/// y := L11^-1 y of the first columns, y -= L21 y of the rows below; y [rows], zeros behind what counts. Columns are
/// fetched that stand `ahead` numbers further on; 0: none.
void substitute_forwards(std::size_t columns, std::size_t rows, std::size_t stride, const double* panel,
                         const double* inverse_pivots, std::size_t ahead, double* y);
/// y := L11'^-1 (y - L21' y below) of the first columns. Columns are fetched that stand `ahead` numbers before.
void substitute_backwards(std::size_t columns, std::size_t rows, std::size_t stride, const double* panel,
                          const double* inverse_pivots, std::size_t ahead, double* y);
/// y -= a x; a [rows, columns] in `panel`.
void subtract_product(std::size_t columns, std::size_t rows, std::size_t stride, const double* panel, const double* x,
                      double* y);
/// sums = a' y.
void find_products(std::size_t columns, std::size_t rows, std::size_t stride, const double* panel, const double* y,
                   double* sums);

/// Both substitutions for eight right-hand sides at once: those of row i stand side by side at x[numbers[i]].
void substitute_eight_forwards(std::size_t columns, std::size_t rows, std::size_t stride, const double* panel,
                               const double* inverse_pivots, const int* numbers, double* x);
void substitute_eight_backwards(std::size_t columns, std::size_t rows, std::size_t stride, const double* panel,
                                const double* inverse_pivots, const int* numbers, double* x);

}  // namespace tanor::kernels
