#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "factor/cholesky.hpp"

namespace tanor::detail {

/// Groups of columns of L that have (almost) the same pattern, and their rows.
struct Supernodes {
  std::vector<int> first_column;        ///< [supernode], and the number of columns at the end
  std::vector<std::size_t> rows_start;  ///< [supernode + 1] into `rows`
  std::vector<int> rows;                ///< rows of each supernode, increasing, its own columns first
  std::vector<int> parent{};            ///< [supernode] the one that has the first row below the columns, or -1

  std::size_t size() const { return first_column.size() - 1; }
  std::size_t num_columns(std::size_t s) const {
    return static_cast<std::size_t>(first_column[s + 1] - first_column[s]);
  }
  std::span<const int> rows_of(std::size_t s) const {
    return std::span(rows).subspan(rows_start[s], rows_start[s + 1] - rows_start[s]);
  }
  std::span<const int> rows_below(std::size_t s) const { return rows_of(s).subspan(num_columns(s)); }
  double num_stored() const;  ///< numbers that stand in the trapezoids of L
};

/// Finds the supernodes of the factor L of a pattern (lower triangle) whose rows stand in the order of elimination.
///
/// CHOLMOD finds the elimination tree (J. W. H. Liu, SIAM J. Matrix Anal. Appl. 11, 1990) and the counts of L's columns
/// (J. R. Gilbert, E. G. Ng, B. W. Peyton, SIAM J. Matrix Anal. Appl. 15, 1994), in a time that hardly depends on L. L
/// may have more than 2^31 entries; S may not. Throws std::bad_alloc. A supernode is merged with the one that follows
/// it if that is its parent and L gets few zeros to store (C. Ashcraft and R. Grimes, ACM TOMS 15, 1989), because a few
/// zeros cost less than another front does. The last `num_kept` rows are one supernode without rows below.
Supernodes find_supernodes(const TrianglePattern& lower, std::size_t num_kept = 0);

}  // namespace tanor::detail
