#include <metis.h>

#include <bit>
#include <new>
#include <utility>

#include "base/check.hpp"
#include "factor/dissection.hpp"
#include "plan/thresholds.hpp"

namespace tanor::detail {

namespace {

/// Returns for each point the points that a row joins it to.
Groups<int> list_neighbours(const RowsInSpace& rows) {
  const Groups<int> rows_of_point = list_rows_of_points(rows);
  Groups<int> neighbours;
  std::vector<int> last_met(rows.num_points(), -1);
  for (int point = 0; point < static_cast<int>(rows.num_points()); ++point) {
    last_met[static_cast<std::size_t>(point)] = point;
    for (const int row : rows_of_point[static_cast<std::size_t>(point)]) {
      for (const int other : rows.points_of_row[static_cast<std::size_t>(row)])
        if (std::exchange(last_met[static_cast<std::size_t>(other)], point) != point)
          neighbours.entries.push_back(other);
    }
    neighbours.end_group();
  }
  return neighbours;
}

/// Bisects `depth` times. Returns [point] its part, whose first bit tells the first half from the second, and so on.
std::vector<int> bisect(const RowsInSpace& rows, int depth) {
  std::vector<int> part(rows.num_points(), 0);
  if (depth == 0) return part;
  Groups<int> neighbours = list_neighbours(rows);
  idx_t num_points = static_cast<idx_t>(rows.num_points()), weights = 1, num_parts = 1 << depth, num_cut = 0;
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_UFACTOR] = plan::imbalance_of_halves;
  const int status =
      METIS_PartGraphRecursive(&num_points, &weights, neighbours.start.data(), neighbours.entries.data(), nullptr,
                               nullptr, nullptr, &num_parts, nullptr, nullptr, options, &num_cut, part.data());
  if (status == METIS_ERROR_MEMORY) throw std::bad_alloc();
  ensure(status == METIS_OK, "METIS takes the graphs that we build");
  return part;
}

/// Returns the number of a node of a full binary tree, children before parents: the ancestor of `leaf` that is `height`
/// above the leaves.
int number_of_node(int leaf, int height) {
  // All trees that end at or before the node's last leaf are complete. A complete tree has twice as many nodes as
  // leaves, less one.
  const auto end = static_cast<unsigned>(((leaf >> height) + 1) << height);
  return 2 * static_cast<int>(end) - std::popcount(end) - 1 - (std::countr_zero(end) - height);
}

/// Returns how many cuts have to be undone until all points of a row are in one part.
int height_of(std::span<const int> points, const std::vector<int>& part) {
  unsigned difference = 0;
  const auto part_of = [&](int point) { return static_cast<unsigned>(part[static_cast<std::size_t>(point)]); };
  for (const int point : points) difference |= part_of(point) ^ part_of(points[0]);
  return std::bit_width(difference);
}

double first_cut(const RowsInSpace& rows, const std::vector<int>& part, int depth) {
  if (depth == 0) return 0.0;
  double parted = 0.0, first = 0.0;
  for (std::size_t row = 0; row < rows.num_rows(); ++row)
    parted += height_of(rows.points_of_row[row], part) == depth ? 1.0 : 0.0;
  for (const int own : part) first += (own >> (depth - 1)) == 0 ? 1.0 : 0.0;
  return parted / (first * (static_cast<double>(part.size()) - first));
}

}  // namespace

Dissection dissect_graph(const RowsInSpace& rows) {
  int depth = 0;
  while ((rows.num_points() >> depth) > plan::most_points_of_part) ++depth;
  const std::vector<int> part = bisect(rows, depth);
  const Groups<int> by_part(std::size_t{1} << depth, [&](const auto& add) {
    for (std::size_t point = 0; point < part.size(); ++point) add(part[point], static_cast<int>(point));
  });
  std::vector<int> node_of_row(rows.num_rows());
  for (std::size_t row = 0; row < node_of_row.size(); ++row) {
    const std::span<const int> points = rows.points_of_row[row];
    node_of_row[row] = number_of_node(part[static_cast<std::size_t>(points[0])], height_of(points, part));
  }
  const int num_nodes = (2 << depth) - 1;
  return {order_by_nodes(rows, by_part.entries, node_of_row, num_nodes), first_cut(rows, part, depth)};
}

double first_cut_of_graph(const RowsInSpace& rows) {
  const int depth = rows.num_points() > plan::most_points_of_part ? 1 : 0;
  return first_cut(rows, bisect(rows, depth), depth);
}

}  // namespace tanor::detail
