#include "schur/lane_series.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include "schur/group_series.hpp"
#include "schur/rod_rows.hpp"
#include "schur/short_path_series.hpp"

namespace tanor::detail {

namespace {

bool has_uniform_free_motion(const System& system) {
  return std::ranges::all_of(system.forces,
                             [](const Force& force) { return std::holds_alternative<Gravity>(force); }) &&
         std::ranges::all_of(system.supports, [](const Support& each) { return each.displacement.is_constant(); });
}

}  // namespace

LaneSeries::LaneSeries(const System& system, const Constraints& constraints, const Numbering& numbering,
                       std::span<const double> inverse_mass, int threads)
    : left_rows_(numbering.num_rows(), 1), left_points_(numbering.num_moving) {
  if (!has_uniform_free_motion(system)) return;
  const RodRows rods(constraints, numbering.num_rows());
  std::vector<Index> islands(numbering.num_islands());  // whose rows are rods of fixed lengths
  std::iota(islands.begin(), islands.end(), 0);
  std::erase_if(islands, [&](Index island) {
    const Index* const start = numbering.island_start.data() + island;
    for (auto row = static_cast<std::size_t>(start[0]); row < static_cast<std::size_t>(start[1]); ++row)
      if (rods.ends[row][0] < 0 || (!rods.moving_length.empty() && rods.moving_length[row] != nullptr)) return true;
    return false;
  });
  const std::vector<Index> suited = islands;
  const auto add = [&](auto series) {
    if (series->num_parts() > 0) series_.push_back(std::move(series));
  };
  add(std::make_unique<ShortPathSeries>(rods, numbering, inverse_mass, &islands));
  for (const auto take : {take_equal_islands, take_paths, take_trees})
    add(std::make_unique<GroupSeries>(take(rods, numbering, false, &islands), rods, numbering, inverse_mass, threads));
  std::vector<Index> served;
  std::ranges::set_difference(suited, islands, std::back_inserter(served));
  serves_all_ = served.size() == numbering.num_islands();
  std::vector<char> is_served(numbering.num_moving, 0);
  for (const Index island : served) {
    const Index* const start = numbering.island_start.data() + island;
    for (auto row = static_cast<std::size_t>(start[0]); row < static_cast<std::size_t>(start[1]); ++row) {
      left_rows_[row] = 0;
      for (const Index point : rods.ends[row]) {
        if (static_cast<std::size_t>(point) < is_served.size()) is_served[static_cast<std::size_t>(point)] = 1;
      }
    }
  }
  const auto left = static_cast<double>(std::ranges::count(left_rows_, 1));
  if (serves_some()) share_left_ = left / static_cast<double>(left_rows_.size());
  left_points_ = {};
  for (std::size_t point = 0; point < is_served.size(); ++point) {
    if (is_served[point] == 0) left_points_.append(point);
  }
}

std::size_t LaneSeries::num_parts() const {
  std::size_t result = 0;
  for (const auto& series : series_) result += series->num_parts();
  return result;
}

double LaneSeries::expand(const Parallel& parallel, const LaneExpansion& expansion) {
  double longest = any_length;
  for (const auto& series : series_) longest = std::min(longest, series->expand(parallel, expansion));
  return longest;
}

}  // namespace tanor::detail
