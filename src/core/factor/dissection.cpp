#include "factor/dissection.hpp"

#include <metis.h>

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <new>
#include <utility>

#include "base/check.hpp"
#include "plan/thresholds.hpp"

namespace tanor::detail {

namespace {

/// Returns the rows of each point, [point].
Groups<int> list_rows_of_points(const RowsInSpace& rows) {
  return {rows.num_points(), [&](const auto& add) {
            for (std::size_t row = 0; row < rows.num_rows(); ++row) {
              for (const int point : rows.points_of_row[row]) add(point, static_cast<int>(row));
            }
          }};
}

/// Returns the rows node by node of the tree of cuts, those of a node as `points` lists the first of their points.
std::vector<int> order_by_nodes(const RowsInSpace& rows, const std::vector<int>& points,
                                const std::vector<int>& node_of_row, int num_nodes) {
  const Groups<int> rows_of_point = list_rows_of_points(rows);
  std::vector<char> is_listed(rows.num_rows(), 0);
  std::vector<int> along_points;
  along_points.reserve(rows.num_rows());
  for (const int point : points) {
    for (const int row : rows_of_point[static_cast<std::size_t>(point)])
      if (std::exchange(is_listed[static_cast<std::size_t>(row)], 1) == 0) along_points.push_back(row);
  }
  return Groups<int>(static_cast<std::size_t>(num_nodes),
                     [&](const auto& add) {
                       for (const int row : along_points) add(node_of_row[static_cast<std::size_t>(row)], row);
                     })
      .entries;
}

// ---- cuts along axes ----

/// Cuts the points recursively and numbers the nodes of the tree of cuts, children before parents.
class AxisCuts {
 public:
  explicit AxisCuts(const RowsInSpace& rows)
      : rows_(rows),
        rows_of_point_(list_rows_of_points(rows)),
        open_(rows.num_rows()),
        is_first_(rows.num_points()),
        node_of_row_(rows.num_rows(), -1) {
    for (std::size_t row = 0; row < open_.size(); ++row)
      open_[row].points = static_cast<int>(rows.points_of_row[row].size());
    find_axes();
    for (const std::size_t axis : axes_) sort_along(axis);
  }

  Dissection dissect() {
    dissect(0, rows_.num_points());
    return {order_by_nodes(rows_, sorted_[axes_.front()], node_of_row_, num_nodes_), first_cut_};
  }

 private:
  struct Cut {
    std::size_t axis = 0, place = 0;
    double badness = std::numeric_limits<double>::infinity();  // rows over the product of the points on both sides
  };
  /// The points of a row during a sweep: those met, and all of them; `points` is 0 if a cut has parted the row.
  struct Open {
    int met = 0, points = 0;
  };

  /// Leaves out axes along which all points lie nearer than those of a line as long as the longest: across a flat net.
  void find_axes() {
    std::array<double, 3> extent{};
    for (std::size_t axis = 0; axis < 3 && rows_.num_points() > 0; ++axis) {
      double low = rows_.positions[axis], high = low;
      for (std::size_t k = axis; k < rows_.positions.size(); k += 3) {
        low = std::min(low, rows_.positions[k]);
        high = std::max(high, rows_.positions[k]);
      }
      extent[axis] = high - low;
    }
    const double longest = std::ranges::max(extent), least = longest / (1.0 + static_cast<double>(rows_.num_points()));
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (extent[axis] >= least) axes_.push_back(axis);
  }

  /// Sorts the points. Those of equal coordinate are sorted by the other coordinates, so that grids are cut straight.
  void sort_along(std::size_t axis) {
    struct Key {
      std::array<double, 3> place;  // beginning with this axis
      int point;
    };
    std::vector<Key> keys(rows_.num_points());
    for (std::size_t k = 0; k < keys.size(); ++k) {
      keys[k].point = static_cast<int>(k);
      for (std::size_t c = 0; c < 3; ++c) keys[k].place[c] = rows_.positions[3 * k + (axis + c) % 3];
    }
    std::ranges::sort(keys, [](const Key& a, const Key& b) {
      for (std::size_t c = 0; c < 3; ++c)
        if (a.place[c] != b.place[c]) return a.place[c] < b.place[c];
      return a.point < b.point;
    });
    for (const Key& key : keys) sorted_[axis].push_back(key.point);
  }

  double coordinate(int point, std::size_t axis) const {
    return rows_.positions[3 * static_cast<std::size_t>(point) + axis];
  }
  std::span<const int> rows_of(std::size_t place) const {
    return rows_of_point_[static_cast<std::size_t>(sorted_[axes_.front()][place])];
  }

  /// Orders the points [begin, end) and the rows that no cut has parted so far.
  void dissect(std::size_t begin, std::size_t end) {
    if (end - begin <= plan::most_points_of_leaf) {
      for (std::size_t k = begin; k < end; ++k) {
        for (const int row : rows_of(k)) {
          if (open_[static_cast<std::size_t>(row)].points > 0) node_of_row_[static_cast<std::size_t>(row)] = num_nodes_;
        }
      }
    } else {
      const Cut cut = find_cut(begin, end);
      if (end - begin == rows_.num_points()) first_cut_ = cut.badness;
      move_apart(begin, end, cut);
      const std::vector<int> separator = take_separator(begin, cut.place);
      dissect(begin, cut.place);
      dissect(cut.place, end);
      for (const int row : separator) node_of_row_[static_cast<std::size_t>(row)] = num_nodes_;
    }
    ++num_nodes_;
  }

  Cut find_cut(std::size_t begin, std::size_t end) {
    std::array<double, 3> extent{};
    for (const std::size_t axis : axes_)
      extent[axis] = coordinate(sorted_[axis][end - 1], axis) - coordinate(sorted_[axis][begin], axis);
    const double longest = std::ranges::max(extent);
    Cut best;
    for (const std::size_t axis : axes_)
      if (extent[axis] >= plan::least_extent * longest) sweep(begin, end, axis, &best);
    return best;
  }

  /// Tries all places across an axis that leave at least a third of the points on each side.
  void sweep(std::size_t begin, std::size_t end, std::size_t axis, Cut* best) {
    const auto count = static_cast<double>(end - begin);
    std::size_t num_parted = 0;
    for (std::size_t k = begin; k < end; ++k) {
      for (const int row : rows_of_point_[static_cast<std::size_t>(sorted_[axis][k])]) {
        Open& open = open_[static_cast<std::size_t>(row)];
        if (open.points < 2) continue;
        if (open.met++ == 0) ++num_parted;
        if (open.met < open.points) continue;
        open.met = 0;
        --num_parted;
      }
      const auto first = static_cast<double>(k + 1 - begin), second = count - first;
      if (3.0 * first < count || 3.0 * second < count) continue;
      const double badness = static_cast<double>(num_parted) / (first * second);
      if (badness < best->badness) *best = {axis, k + 1, badness};
    }
  }

  /// Sorts the points of each axis anew: those of the first half, then those of the second.
  void move_apart(std::size_t begin, std::size_t end, const Cut& cut) {
    for (std::size_t k = begin; k < end; ++k)
      is_first_[static_cast<std::size_t>(sorted_[cut.axis][k])] = k < cut.place ? 1 : 0;
    for (const std::size_t axis : axes_) {
      if (axis == cut.axis) continue;
      std::ranges::stable_partition(std::span(sorted_[axis]).subspan(begin, end - begin),
                                    [&](int point) { return is_first_[static_cast<std::size_t>(point)] != 0; });
    }
  }

  /// Lists the rows that join the points [begin, end) of the first half to others, and closes them.
  std::vector<int> take_separator(std::size_t begin, std::size_t end) {
    std::vector<int> separator;
    for (std::size_t k = begin; k < end; ++k) {
      for (const int row : rows_of(k)) {
        Open& open = open_[static_cast<std::size_t>(row)];
        const std::span<const int> points = rows_.points_of_row[static_cast<std::size_t>(row)];
        const auto is_first = [&](int point) { return is_first_[static_cast<std::size_t>(point)] != 0; };
        if (open.points < 2 || std::ranges::all_of(points, is_first)) continue;
        open.points = 0;
        separator.push_back(row);
      }
    }
    return separator;
  }

  const RowsInSpace& rows_;
  const Groups<int> rows_of_point_;
  std::vector<std::size_t> axes_;           // that are tried
  std::array<std::vector<int>, 3> sorted_;  // [axis] points along it, half by half
  std::vector<Open> open_;                  // [row]
  std::vector<char> is_first_;              // [point] true in the first half of the last cut
  std::vector<int> node_of_row_;
  int num_nodes_ = 0;
  double first_cut_ = 0.0;
};

// ---- cuts of the graph ----

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

Dissection dissect_along_axes(const RowsInSpace& rows) {
  return AxisCuts(rows).dissect();
}

Dissection dissect_graph(const RowsInSpace& rows) {
  int depth = 0;
  while ((rows.num_points() >> depth) > plan::most_points_of_part) ++depth;
  const std::vector<int> part = bisect(rows, depth);
  const Groups<int> by_part(std::size_t{1} << depth, [&](const auto& add) {
    for (std::size_t point = 0; point < part.size(); ++point) add(part[point], static_cast<int>(point));
  });
  // Nodes are numbered children first: before the end of a node lie 2 end - popcount(end), its parents among them.
  std::vector<int> node_of_row(rows.num_rows());
  for (std::size_t row = 0; row < node_of_row.size(); ++row) {
    const std::span<const int> points = rows.points_of_row[row];
    const int height = height_of(points, part);
    const unsigned end = ((static_cast<unsigned>(part[static_cast<std::size_t>(points[0])]) >> height) + 1) << height;
    node_of_row[row] = static_cast<int>(2 * end) - std::popcount(end) - 1 - (std::countr_zero(end) - height);
  }
  const int num_nodes = (2 << depth) - 1;
  return {order_by_nodes(rows, by_part.entries, node_of_row, num_nodes), first_cut(rows, part, depth)};
}

double first_cut_of_graph(const RowsInSpace& rows) {
  const int depth = rows.num_points() > plan::most_points_of_part ? 1 : 0;
  return first_cut(rows, bisect(rows, depth), depth);
}

}  // namespace tanor::detail
