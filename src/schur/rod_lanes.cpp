#include "schur/rod_lanes.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace tanor {

namespace {

struct Rod {
  Index begin, end;  // inner points
};

struct Path {
  std::vector<Index> points, rows;
  std::vector<char> flipped;
};

/// The rods [first, end) of an island in the order in which they follow one another.
class PathWalk {
 public:
  PathWalk(std::span<const Rod> rods, std::size_t num_moving) : rods_(rods), rods_of_(num_moving, {-1, -1}) {}

  std::optional<Path> walk(Index first, Index end) {
    for (Index row = first; row < end; ++row) {
      for (const Index point : {rod(row).begin, rod(row).end}) {
        if (!moves(point)) continue;
        auto& [one, other] = rods_of_[static_cast<std::size_t>(point)];
        if (other >= 0) return {};
        (one < 0 ? one : other) = row;
      }
    }
    Path path;
    Index row = first;
    while (row < end && !is_end(rod(row).begin) && !is_end(rod(row).end)) ++row;
    if (row == end) return {};  // a ring
    Index point = is_end(rod(row).begin) ? rod(row).begin : rod(row).end;
    path.points.push_back(point);
    while (row >= 0) {
      const bool flipped = rod(row).end == point;
      point = flipped ? rod(row).begin : rod(row).end;
      path.rows.push_back(row);
      path.flipped.push_back(flipped ? 1 : 0);
      path.points.push_back(point);
      row = next(point, row);
    }
    return path;
  }

 private:
  const Rod& rod(Index row) const { return rods_[static_cast<std::size_t>(row)]; }
  bool moves(Index point) const { return static_cast<std::size_t>(point) < rods_of_.size(); }
  bool is_end(Index point) const { return !moves(point) || rods_of_[static_cast<std::size_t>(point)][1] < 0; }
  Index next(Index point, Index row) const {
    if (is_end(point)) return -1;
    const auto [one, other] = rods_of_[static_cast<std::size_t>(point)];
    return one == row ? other : one;
  }

  std::span<const Rod> rods_;
  std::vector<std::array<Index, 2>> rods_of_;  // [moving point]
};

RodLanes make_lanes(std::size_t width, std::size_t length, bool is_cut) {
  return {.width = width,
          .length = length,
          .is_cut = is_cut,
          .points = std::vector<Index>((length + 1) * width, -1),
          .rows = std::vector<Index>(length * width, -1),
          .flipped = std::vector<char>(length * width, 0)};
}

/// Rods [first, first + length) of a path into a lane, as far as there are any.
void fill_lane(const Path& path, std::size_t first, std::size_t lane, RodLanes* lanes) {
  const std::size_t width = lanes->width;
  for (std::size_t i = 0; i <= lanes->length && first + i < path.points.size(); ++i) {
    lanes->points[i * width + lane] = path.points[first + i];
    if (i == lanes->length || first + i >= path.rows.size()) continue;
    lanes->rows[i * width + lane] = path.rows[first + i];
    lanes->flipped[i * width + lane] = path.flipped[first + i];
  }
}

}  // namespace

std::optional<std::vector<RodLanes>> lay_rods(const System& system, const Numbering& numbering,
                                              std::span<const Incidence> incidences) {
  const bool all_rods = std::all_of(system.constraints.begin(), system.constraints.end(),
                                    [](const auto& given) { return std::holds_alternative<Rods>(given); });
  if (!all_rods) return {};
  std::vector<Rod> rods(numbering.num_rows());
  for (const Incidence& incidence : incidences) {
    Rod& rod = rods[static_cast<std::size_t>(incidence.row)];
    (incidence.sign < 0.0 ? rod.begin : rod.end) = incidence.point;
  }
  PathWalk walk(rods, numbering.num_moving);
  std::vector<Path> paths;
  for (std::size_t island = 0; island < numbering.num_islands(); ++island) {
    std::optional<Path> path = walk.walk(numbering.island_start[island], numbering.island_start[island + 1]);
    if (!path) return {};
    paths.push_back(std::move(*path));
  }

  constexpr std::size_t width = RodLanes::most, worth_a_cut = 8 * width;
  std::vector<RodLanes> result;
  const auto short_ones = std::stable_partition(paths.begin(), paths.end(),
                                                [](const Path& path) { return path.rows.size() >= worth_a_cut; });
  for (auto path = paths.begin(); path != short_ones; ++path) {
    const std::size_t length = (path->rows.size() + width - 1) / width;
    result.push_back(make_lanes(width, length, true));
    for (std::size_t lane = 0; lane < width; ++lane) fill_lane(*path, lane * length, lane, &result.back());
  }
  std::stable_sort(short_ones, paths.end(), [](const Path& a, const Path& b) { return a.rows.size() > b.rows.size(); });
  for (auto path = short_ones; path != paths.end();) {
    const auto left = static_cast<std::size_t>(paths.end() - path);
    result.push_back(make_lanes(left > RodLanes::few ? width : RodLanes::few, path->rows.size(), false));
    for (std::size_t lane = 0; lane < std::min(left, result.back().width); ++lane, ++path)
      fill_lane(*path, 0, lane, &result.back());
  }
  return result;
}

}  // namespace tanor
