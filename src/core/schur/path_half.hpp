#pragma once

#include <algorithm>

#include "schur/path_kernels.hpp"
#include "schur/schur_solver.hpp"

/// \file The state of the halves of a path on the way to its middle row and back.
namespace tanor::detail::paths {

/// The half of a path from its left end to its middle row, the half from its right end, or both.
enum class Sides { Both, Left, Right };
inline bool includes(Sides sides, Sides one) {
  return sides == Sides::Both || sides == one;
}

/// The findings in some rows.
struct Findings {
  double smallest_ratio = 1.0, largest_ratio = 1.0;  ///< S_aa/pivot
  double right_side = 0.0, residual = 0.0;           ///< largest |b| and |K'dw + b|
  double own_residual = 0.0;                         ///< largest residual of any path over its own |b|

  void include(const Findings& other) {
    smallest_ratio = std::min(smallest_ratio, other.smallest_ratio);
    largest_ratio = larger(largest_ratio, other.largest_ratio);
    right_side = larger(right_side, other.right_side);
    residual = larger(residual, other.residual);
    own_residual = larger(own_residual, other.own_residual);
  }
  /// Returns an estimate: scaled to a unit diagonal, pivots lie between 1/largest_ratio and 1.
  double reciprocal_condition() const {
    return smallest_ratio > 0.0 && largest_ratio > 0.0 ? 1.0 / largest_ratio : 0.0;
  }
};

/// The numbers that a half hands to the row in the middle. An empty half hands it zeros.
struct Eliminated {
  Vec3 g{};
  double inverse_pivot = 0.0, y = 0.0, spike = 0.0;
  double closing_pivot = 0.0, closing_y = 0.0;  ///< what its rows subtract from those of the closing row
  Findings findings;
};
/// The results of a half: dw of the points beside the middle row and beside the closing row, and the residual of its
/// own rows.
struct Accelerated {
  Vec3 dw{}, end_dw{};
  double residual = 0.0;
};

/// The state of a thread in the current path.
struct PathWork {
  Eliminated left_end, right_end;
  Accelerated left, right;
  Findings findings;
  Projection projection;  ///< that of all paths of a group
};

/// One of the two halves of a path on its way to the middle.
struct Half {
  Towards towards;
  std::size_t next, rows_left;  ///< the right half counts down: its next chunk ends at `next`
  std::size_t first = 0;        ///< first row of the chunk
  Chunk chunk;
  Determinants determinants{};
  PivotRange pivots{};
  double largest = 0.0;
  Eliminated end{};       ///< numbers of the last row so far
  double coupling = 0.0;  ///< coupling of the outermost row with the one that closes a ring

  Half(Towards direction, std::size_t start, std::size_t rows) : towards(direction), next(start), rows_left(rows) {}

  bool is_rightwards() const { return towards == Towards::Right; }
  void advance() {
    chunk.count = std::min(rows_left, chunk_size);
    rows_left -= chunk.count;
    first = is_rightwards() ? next : next - chunk.count;
    next = is_rightwards() ? next + chunk.count : first;
    // The row that was eliminated before lies beside the chunk.
    const std::size_t slot = is_rightwards() ? 0 : chunk.count + 1;
    chunk.set_direction(slot, end.g);
    chunk.inverse_pivot[slot] = end.inverse_pivot;
  }
  /// Returns the number of rows of the next chunk.
  std::size_t next_count() const { return std::min(rows_left, chunk_size); }
  std::size_t next_first() const { return is_rightwards() ? next : next - next_count(); }
  void remember_last_row() {
    if (chunk.count == 0) return;
    const std::size_t slot = is_rightwards() ? chunk.count : 1;
    end.g = chunk.direction(slot);
    end.inverse_pivot = chunk.inverse_pivot[slot];
  }
};

}  // namespace tanor::detail::paths
