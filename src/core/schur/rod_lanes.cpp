#include "schur/rod_lanes.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include "plan/thresholds.hpp"

namespace tanor::detail {

namespace {

RodLanes make_lanes(std::size_t width, std::size_t length, bool is_cut) {
  return {.width = width,
          .length = length,
          .is_cut = is_cut,
          .points = std::vector<Index>((length + 1) * width, -1),
          .rows = std::vector<Index>(length * width, -1),
          .flipped = std::vector<char>(length * width, 0)};
}

using Ends = std::vector<std::array<Index, 2>>;  // [row] inner points of its rod

/// Lays the rods [first, first + length) of a path into a lane, as far as there are any.
void fill_lane(const RodPath& path, const Ends& ends, std::size_t first, std::size_t lane, RodLanes* lanes) {
  const std::size_t width = lanes->width;
  for (std::size_t i = 0; i <= lanes->length && first + i <= path.num_rows(); ++i) {
    const std::size_t row = path.first + first + i, place = i * width + lane;
    const auto point = static_cast<Index>(first + i == 0 ? path.left_point(row) : path.right_point(row - 1));
    lanes->points[place] = point;
    if (i == lanes->length || first + i == path.num_rows()) continue;
    lanes->rows[place] = static_cast<Index>(row);
    lanes->flipped[place] = ends[row][0] == point ? 0 : 1;
  }
}

}  // namespace

std::vector<RodLanes> lay_rods(const RodRows& rods, const Numbering& numbering, std::vector<Index>* islands) {
  const Ends& ends = rods.ends;
  std::vector<RodPath> paths;
  std::erase_if(*islands, [&](Index island) {
    const std::optional<RodPath> path = find_path(ends, numbering, island);
    if (!path || path->is_ring) return false;
    paths.push_back(*path);
    return true;
  });

  constexpr std::size_t width = RodLanes::most, worth_a_cut = plan::fewest_rods_of_piece * width;
  std::vector<RodLanes> result;
  const auto short_ones = std::stable_partition(paths.begin(), paths.end(),
                                                [](const RodPath& path) { return path.num_rows() >= worth_a_cut; });
  for (auto path = paths.begin(); path != short_ones; ++path) {
    const std::size_t length = (path->num_rows() + width - 1) / width;
    result.push_back(make_lanes(width, length, true));
    for (std::size_t lane = 0; lane < width; ++lane) fill_lane(*path, ends, lane * length, lane, &result.back());
  }
  std::stable_sort(short_ones, paths.end(),
                   [](const RodPath& a, const RodPath& b) { return a.num_rows() > b.num_rows(); });
  for (auto path = short_ones; path != paths.end();) {
    const auto left = static_cast<std::size_t>(paths.end() - path);
    result.push_back(make_lanes(left > RodLanes::few ? width : RodLanes::few, path->num_rows(), false));
    for (std::size_t lane = 0; lane < std::min(left, result.back().width); ++lane, ++path)
      fill_lane(*path, ends, 0, lane, &result.back());
  }
  return result;
}

}  // namespace tanor::detail
