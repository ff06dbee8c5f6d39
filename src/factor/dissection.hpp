#pragma once

#include <vector>

#include "base/groups.hpp"

namespace tanor {

/// The points that each row of S = K'WK takes hold of: two rows with a point in common have an entry of S.
struct RowsInSpace {
  Groups<int> points_of_row;      ///< each at least one
  std::vector<double> positions;  ///< [3 points]

  std::size_t num_points() const { return positions.size() / 3; }
  std::size_t num_rows() const { return points_of_row.size(); }
};

/// An order of elimination by nested dissection of the points (A. George, SIAM J. Numer. Anal. 10, 1973): rows that
/// join two halves are the separator and come after those of both. A separator's rows follow the points of its first
/// half, so that each front below it meets a single run of them, or few.
struct Dissection {
  std::vector<int> order;  ///< [place in the elimination] -> row
  double first_cut = 0.0;  ///< rows that the first cut parts, over the product of the points on its sides
};

/// Halves on both sides of a plane across an axis, where it parts fewest rows for the balance that it leaves.
/// O(n log n).
Dissection dissect_along_axes(const RowsInSpace& rows);

/// Halves of the graph of points that METIS finds (G. Karypis, V. Kumar, SIAM J. Sci. Comput. 20, 1998). Throws
/// std::bad_alloc.
Dissection dissect_graph(const RowsInSpace& rows);
/// Its first cut alone.
double first_cut_of_graph(const RowsInSpace& rows);

/// [point] the rows that take hold of it.
Groups<int> list_rows_of_points(const RowsInSpace& rows);
/// Rows node by node of the tree of cuts, those of a node as the first of their points follow one another in `points`.
std::vector<int> order_by_nodes(const RowsInSpace& rows, const std::vector<int>& points,
                                const std::vector<int>& node_of_row, int num_nodes);

}  // namespace tanor
