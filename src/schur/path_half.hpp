#pragma once

#include <algorithm>

#include "schur/path_solver.hpp"

namespace tanor {

/// One of the two halves of a path on its way to the middle.
struct PathSolver::Half {
  paths::Towards towards;
  std::size_t next, rows_left;  ///< the right half counts down: its next chunk ends at `next`
  std::size_t first = 0;        ///< row of the chunk
  paths::Chunk chunk;
  paths::Determinants determinants{};
  paths::PivotRange pivots{};
  double largest = 0.0;
  Eliminated end{};       ///< of the last row so far
  double coupling = 0.0;  ///< of the outermost row with the one that closes a ring

  Half(paths::Towards direction, std::size_t start, std::size_t rows)
      : towards(direction), next(start), rows_left(rows) {}

  bool is_rightwards() const { return towards == paths::Towards::Right; }
  void advance() {
    chunk.count = std::min(rows_left, paths::chunk_size);
    rows_left -= chunk.count;
    first = is_rightwards() ? next : next - chunk.count;
    next = is_rightwards() ? next + chunk.count : first;
    // The row eliminated before lies beside the chunk.
    const std::size_t slot = is_rightwards() ? 0 : chunk.count + 1;
    chunk.set_direction(slot, end.g);
    chunk.inverse_pivot[slot] = end.inverse_pivot;
  }
  /// Rows of the chunk after this one.
  std::size_t next_count() const { return std::min(rows_left, paths::chunk_size); }
  std::size_t next_first() const { return is_rightwards() ? next : next - next_count(); }
  void remember_last_row() {
    if (chunk.count == 0) return;
    const std::size_t slot = is_rightwards() ? chunk.count : 1;
    end.g = chunk.direction(slot);
    end.inverse_pivot = chunk.inverse_pivot[slot];
  }
};

}  // namespace tanor
