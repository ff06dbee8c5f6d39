#include "schur/rod_rows.hpp"

#include <algorithm>

namespace tanor::detail {

std::optional<RodPath> find_path(std::span<const std::array<Index, 2>> ends, const Numbering& numbering, Index island) {
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
