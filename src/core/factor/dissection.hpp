#pragma once

#include <vector>

#include "base/groups.hpp"

namespace tanor::detail {

/// The points that each row of S = K'WK acts on. Two rows with a common point have an entry of S.
struct RowsInSpace {
  Groups<int> points_of_row;      ///< each row has at least one
  std::vector<double> positions;  ///< [3 points]

  std::size_t num_points() const { return positions.size() / 3; }
  std::size_t num_rows() const { return points_of_row.size(); }
};

/// An order of elimination by nested dissection of the points (A. George, SIAM J. Numer. Anal. 10, 1973). The rows that
/// join two halves are the separator and come after the rows of both halves. A separator's rows follow the points of
/// its first half, so that each front below it meets one run of them, or few.
struct Dissection {
  std::vector<int> order;  ///< [place in the elimination] -> row
  double first_cut = 0.0;  ///< rows that the first cut parts, over the product of the points on its sides
};

/// Dissects by planes across an axis, each of which parts the fewest rows for the balance that it leaves: O(n log n).
Dissection dissect_along_axes(const RowsInSpace& rows);

/// Dissects the graph of points by halves of METIS (G. Karypis, V. Kumar, SISC 20, 1998). Throws std::bad_alloc.
Dissection dissect_graph(const RowsInSpace& rows);
/// Returns `first_cut` of dissect_graph without the rest of the dissection.
double first_cut_of_graph(const RowsInSpace& rows);

}  // namespace tanor::detail
