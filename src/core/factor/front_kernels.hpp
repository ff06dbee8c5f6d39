#pragma once

#include <cstddef>
#include <span>

/// \file Dense arithmetic of Multifrontal for each instruction set. Columns stand `stride` numbers apart, a multiple of
/// `front_width`, and are padded with zeros. Kernels may read up to `front_width` numbers behind an array.
namespace tanor::detail::kernels {

inline constexpr std::size_t front_width = 8;

/// The lower triangle of an update, in blocks of columns that begin at the diagonal: little more than half of a square.
struct Triangle {
  static constexpr std::size_t width = 32;  ///< columns of a block, whole lanes

  double* numbers;
  std::size_t stride;  ///< stride of the first block; each block has `width` less than the one before

  static std::size_t size(std::size_t columns, std::size_t stride) {
    const std::size_t first = columns / width * width;
    return start(first, stride) + (columns - first) * (stride - first);
  }
  std::size_t stride_of(std::size_t j) const { return stride - j / width * width; }
  /// Returns column j, whose row i stands at [i]. It is stored from the first row of its block on.
  double* column(std::size_t j) const {
    const std::size_t first = j / width * width;
    return numbers + start(first, stride) + (j - first) * (stride - first) - first;
  }

 private:
  static std::size_t start(std::size_t first, std::size_t stride) {  // sum of the sizes of the blocks before
    return first * stride - first * first / 2 + first * width / 2;
  }
};

/// An update that a front takes from a child. Its row i is the row in_parent[i] of the front; the rows [i, run_end[i])
/// follow each other there too. The first rows are among the columns of the front.
struct ChildUpdate {
  const int *in_parent, *run_end;
  Triangle update;
  std::size_t rows_in_panel, rows;
};
/// The numbers of a front.
struct FrontNumbers {
  std::size_t columns, stride;
  double* panel;    ///< [stride, columns]
  Triangle update;  ///< of the rows below
  std::span<const ChildUpdate> children;

  /// Returns the column of the front that belongs to its row j. Its row i stands at [i], from the diagonal on.
  double* column(std::size_t j) const {
    return j < columns ? panel + j * stride : update.column(j - columns) - columns;
  }
};
/// A part of a lower triangle: the rows [row, end_row), whole lanes of them, of the columns [column, end_column).
struct Tile {
  std::size_t row, end_row, column, end_column;
};
/// Adds the updates of the children to a tile of the panel.
void add_updates(const FrontNumbers& front, const Tile& part);
/// Makes a tile of L and one of the update, either of which may be empty:
///
///   L         the entries of S and the updates of the children there, less the products of the tiles on the left,
///   which
///             are there, divided by the diagonal tile unless it is that one; with 0 above the diagonal in its lanes
///   update    the updates of the children less L21 L21'
///
/// Returns the first column without a positive pivot, or the end of the panel's tile.
std::size_t eliminate(const FrontNumbers& front, const Tile& panel, const Tile& update);

/// Columns of L in a front, or a tile of them. y [rows] is padded with zeros.
struct Panel {
  std::size_t columns, rows, stride;
  const double *numbers, *inverse_pivots;
};
/// Computes y := L11^-1 y in the first columns, then y -= L21 y below. Prefetches `ahead` numbers on unless that is 0.
void substitute_forwards(const Panel& panel, std::size_t ahead, double* y);
/// Computes y := L11'^-1 (y - L21' y below) in the first columns. Prefetches `ahead` numbers before.
void substitute_backwards(const Panel& panel, std::size_t ahead, double* y);
/// Computes y -= a x with a [rows, columns] in the panel.
void subtract_product(const Panel& panel, const double* x, double* y);
/// Computes sums = a' y.
void find_products(const Panel& panel, const double* y, double* sums);

/// Does both substitutions for eight right-hand sides at once. Those of row i stand side by side at x[8 places[i]].
void substitute_pack_forwards(const Panel& panel, const int* places, double* x);
void substitute_pack_backwards(const Panel& panel, const int* places, double* x);

}  // namespace tanor::detail::kernels
