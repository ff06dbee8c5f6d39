#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "evaluate/constraints.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// The rods of a system, row by row in the inner numbering. Solvers that go along rods read them.
struct RodRows {
  std::vector<std::array<Index, 2>> ends;          ///< [row] inner points; {-1, -1} if it is no rod
  std::vector<std::size_t> block;                  ///< [row]
  std::vector<double> constant_length;             ///< [row]
  std::vector<Vec3> offset;                        ///< [row] as in RodKernel; empty if there are none
  std::vector<const MovingScalar*> moving_length;  ///< [row] null if it is constant; empty if all are

  RodRows(const Constraints& constraints, std::size_t num_rows)
      : ends(num_rows, {-1, -1}), block(num_rows), constant_length(num_rows) {
    const auto read = [&]<bool Timed, bool Shifted>(const Family<RodKernel<Timed, Shifted>>& rods) {
      if (Shifted && rods.size() > 0) offset.resize(num_rows);
      if (Timed && rods.size() > 0) moving_length.resize(num_rows);
      for (std::size_t k = 0; k < rods.size(); ++k) {
        const auto row = static_cast<std::size_t>(rods.rows[k]);
        ends[row] = rods.kernel.points[k];
        block[row] = static_cast<std::size_t>(rods.first_block) + k;
        if constexpr (Shifted) offset[row] = rods.kernel.offset[k];
        if constexpr (Timed) {
          moving_length[row] = &rods.kernel.moving_length[k];
        } else {
          constant_length[row] = rods.kernel.length[k];
        }
      }
    };
    read(constraints.family<RodKernel<false, false>>());
    read(constraints.family<RodKernel<false, true>>());
    read(constraints.family<RodKernel<true, false>>());
    read(constraints.family<RodKernel<true, true>>());
  }
};

/// An island of rods that follow one another, point after point and row after row in the inner numbering.
struct RodPath {
  Index first_row, first_point, end_point;  ///< the points that move
  std::vector<Index> points;                ///< rod k joins the points k and k + 1; a support may stand at either end
  bool is_ring = false;                     ///< the last point is the first one again

  std::size_t num_rows() const { return points.size() - 1; }
};

/// Returns the path or ring that an island is, or nothing. `ends` [row] are the inner points of the rods.
inline std::optional<RodPath> find_path(std::span<const std::array<Index, 2>> ends, const Numbering& numbering,
                                        Index island) {
  const auto is_moving = [&](Index point) { return point < static_cast<Index>(numbering.num_moving); };
  const Index* const start = numbering.island_start.data() + island;
  const auto [low, high] = std::ranges::minmax(ends[static_cast<std::size_t>(start[0])]);
  RodPath path{start[0], low, is_moving(high) ? low + 1 : low, {is_moving(high) ? low : high}};
  for (Index row = start[0]; row < start[1]; ++row) {
    const auto [i, j] = ends[static_cast<std::size_t>(row)];
    const Index here = path.points.back(), next = here == i ? j : i;
    if (here != i && here != j) return std::nullopt;
    path.points.push_back(next);
    if (path.end_point == next && is_moving(next)) {
      ++path.end_point;
      continue;
    }
    path.is_ring = is_moving(next) && next == path.points.front() && path.num_rows() > 2;
    if (row + 1 < start[1] || (is_moving(next) && !path.is_ring)) return std::nullopt;
  }
  return path;
}

}  // namespace tanor::detail
