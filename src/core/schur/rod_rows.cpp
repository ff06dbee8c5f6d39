#include "schur/rod_rows.hpp"

namespace tanor::detail {

std::optional<RodPath> find_path(std::span<const std::array<Index, 2>> ends, const Numbering& numbering, Index island) {
  const auto joins = [&](std::size_t row, Index a, Index b) {
    return ends[row] == std::array{a, b} || ends[row] == std::array{b, a};
  };
  const auto num_moving = static_cast<Index>(numbering.num_moving);
  const Index* const start = numbering.island_start.data() + island;
  RodPath path{.first = static_cast<std::size_t>(start[0]), .end = static_cast<std::size_t>(start[1]), .shift = 0};
  const auto& [i, j] = ends[path.first];
  const Index low = std::min(i, j), high = std::max(i, j),
              last = std::max(ends[path.end - 1][0], ends[path.end - 1][1]);
  const auto num_rows = static_cast<Index>(path.end - path.first);
  path.is_ring = num_rows > 2 && high < num_moving && joins(path.end - 1, low, low + num_rows - 1);
  if (path.is_ring) --path.end;
  if (high >= num_moving) path.left_support = high;
  if (path.end - path.first > 1 && last >= num_moving) path.right_support = last;
  path.shift =
      static_cast<std::ptrdiff_t>(low) - static_cast<std::ptrdiff_t>(path.first) - (high >= num_moving ? 1 : 0);
  for (std::size_t row = path.first; row < path.first + path.num_rows(); ++row) {
    if (!joins(row, static_cast<Index>(path.left_point(row)), static_cast<Index>(path.right_point(row)))) return {};
  }
  return path;
}

}  // namespace tanor::detail
