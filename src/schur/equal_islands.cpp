#include "schur/equal_islands.hpp"

#include <algorithm>
#include <limits>
#include <map>

#include "plan/thresholds.hpp"
#include "schur/rod_rows.hpp"

namespace tanor {

namespace {

struct Island {
  Index number = -1, first_point = 0;
  std::vector<Index> rows, supports;  // by the topology's rods and places
  std::vector<char> is_reversed;
};

/// The rods in [first_row, end_row) as a topology; false where one of them is none.
bool read_island(const RodRows& rods, Index first_row, Index end_row, Index num_moving, IslandTopology* topology,
                 Island* island) {
  *topology = {};
  *island = {};
  island->first_point = std::numeric_limits<Index>::max();
  Index last_point = 0;
  for (Index row = first_row; row < end_row; ++row) {
    const std::array<Index, 2>& ends = rods.ends[static_cast<std::size_t>(row)];
    if (ends[0] < 0) return false;
    island->rows.push_back(row);
    for (const Index point : ends) {
      if (point >= num_moving) continue;
      island->first_point = std::min(island->first_point, point);
      last_point = std::max(last_point, point);
    }
  }
  topology->num_points = last_point - island->first_point + 1;
  // By their points, wherever the user put them; a support is numbered after every point that moves.
  const auto ends = [&](Index row) {
    const auto [i, j] = rods.ends[static_cast<std::size_t>(row)];
    return std::array{std::min(i, j), std::min(std::max(i, j), num_moving)};
  };
  std::stable_sort(island->rows.begin(), island->rows.end(), [&](Index a, Index b) { return ends(a) < ends(b); });
  for (const Index row : island->rows) {
    const auto [first, second] = rods.ends[static_cast<std::size_t>(row)];
    const Index low = std::min(first, second), high = std::max(first, second);
    island->is_reversed.push_back(first == high ? 1 : 0);
    int end = high - island->first_point;
    if (high >= num_moving) {
      end = topology->num_points + topology->num_supports++;
      island->supports.push_back(high);
    }
    topology->rods.push_back({low - island->first_point, end});
  }
  return true;
}

/// From a free end or a support to the other one.
bool is_path(const IslandTopology& topology) {
  std::vector<int> num_rods(static_cast<std::size_t>(topology.num_points + topology.num_supports), 0);
  for (const auto& [i, j] : topology.rods) {
    ++num_rods[static_cast<std::size_t>(i)];
    ++num_rods[static_cast<std::size_t>(j)];
  }
  return topology.rods.size() + 1 == num_rods.size() && *std::max_element(num_rods.begin(), num_rods.end()) <= 2;
}

EqualIslands make_equal_islands(const IslandTopology& topology, std::span<const Island> islands, const RodRows& rods,
                                std::span<const double> inverse_mass) {
  EqualIslands result(topology);
  result.num_islands = islands.size();
  result.num_batches = (islands.size() + num_lanes - 1) / num_lanes;
  const std::size_t num_places = static_cast<std::size_t>(topology.num_points + topology.num_supports),
                    num_rods = topology.rods.size();
  result.first_point.resize((result.num_batches + 1) * num_lanes);
  result.supports.resize(result.num_batches * static_cast<std::size_t>(topology.num_supports) * num_lanes);
  const auto row = [](const Island& island, std::size_t a) { return island.rows[a]; };
  const auto block = [&](const Island& island, std::size_t a) {
    return static_cast<Index>(rods.block[static_cast<std::size_t>(island.rows[a])]);
  };
  /// follow(number): in each island the numbers of its rods do.
  const auto follow = [&](const auto& number) {
    return std::all_of(islands.begin(), islands.end(), [&](const Island& island) {
      std::size_t a = 0;
      while (a < num_rods && number(island, a) == number(island, 0) + static_cast<Index>(a)) ++a;
      return a == num_rods;
    });
  };
  const auto first_sign = islands[0].is_reversed[0];
  const bool have_one_sign = std::all_of(islands.begin(), islands.end(), [&](const Island& island) {
    return std::count(island.is_reversed.begin(), island.is_reversed.end(), first_sign) ==
           static_cast<std::ptrdiff_t>(num_rods);
  });
  result.rows_follow = follow(row);
  if (have_one_sign && follow(block)) result.block_sign = first_sign != 0 ? -1.0 : 1.0;
  const std::size_t rows_a_batch = result.rows_follow ? 1 : num_rods;
  const std::size_t blocks_a_batch = result.block_sign != 0.0 ? 1 : num_rods;
  result.rows.resize((result.num_batches + 1) * rows_a_batch * num_lanes);
  result.blocks.resize((result.num_batches + 1) * blocks_a_batch * num_lanes);
  result.lengths.resize(result.num_batches * num_rods);
  result.inverse_mass.resize((result.num_batches + 1) * num_places);
  result.factor.resize((result.num_batches + 1) * static_cast<std::size_t>(result.schedule.num_slots));
  for (std::size_t k = 0; k < (result.num_batches + 1) * num_lanes; ++k) {
    const Island& island = islands[std::min(k, islands.size() - 1)];
    const std::size_t batch = k / num_lanes, lane = k % num_lanes;
    result.first_point[k] = island.first_point;
    for (std::size_t a = 0; a < rows_a_batch; ++a)
      result.rows[(batch * rows_a_batch + a) * num_lanes + lane] = row(island, a);
    for (std::size_t a = 0; a < blocks_a_batch; ++a) {
      const bool is_turned = result.block_sign == 0.0 && island.is_reversed[a] != 0;
      result.blocks[(batch * blocks_a_batch + a) * num_lanes + lane] = is_turned ? ~block(island, a) : block(island, a);
    }
  }
  for (std::size_t k = 0; k < result.num_batches * num_lanes; ++k) {
    const Island& island = islands[std::min(k, islands.size() - 1)];
    const std::size_t batch = k / num_lanes, lane = k % num_lanes;
    for (std::size_t p = 0; p < num_places; ++p) {
      const auto num_points = static_cast<std::size_t>(topology.num_points);
      Index point = island.first_point + static_cast<Index>(p);
      if (p >= num_points) {
        point = island.supports[p - num_points];
        result.supports[(batch * (num_places - num_points) + p - num_points) * num_lanes + lane] = point;
      }
      result.inverse_mass.data()[batch * num_places + p][lane] = inverse_mass[static_cast<std::size_t>(point)];
    }
    for (std::size_t a = 0; a < num_rods; ++a) {
      const auto number = static_cast<std::size_t>(island.rows[a]);
      const std::size_t place = batch * num_rods + a;
      const bool is_reversed = island.is_reversed[a] != 0;
      const Vec3 offset = rods.offset.empty() ? Vec3{} : rods.offset[number];
      if (dot(offset, offset) > 0.0) {
        result.offsets.resize(result.num_batches * num_rods);
        set_lane(&result.offsets[place], lane, is_reversed ? -offset : offset);
      }
      result.lengths.data()[place][lane] = rods.constant_length[number];
      if (const MovingScalar* const moving = rods.moving_length(number)) {
        result.moving_lengths.resize(result.num_batches * num_rods * num_lanes);
        result.moving_lengths[place * num_lanes + lane] = moving;
      }
    }
  }
  return result;
}

}  // namespace

EqualIslands::Batch EqualIslands::batch(std::size_t number) {
  const auto num_points = static_cast<std::size_t>(topology.num_points),
             num_supports = static_cast<std::size_t>(topology.num_supports);
  const std::size_t num_rods = topology.rods.size(), num_places = num_points + num_supports;
  return {*this,
          num_points,
          num_supports,
          num_rods,
          first_point.data() + number * num_lanes,
          supports.data() + number * num_supports * num_lanes,
          rows.data() + number * (rows_follow ? 1 : num_rods) * num_lanes,
          blocks.data() + number * (block_sign != 0.0 ? 1 : num_rods) * num_lanes,
          inverse_mass.data() + number * num_places,
          offsets.empty() ? nullptr : offsets.data() + number * num_rods,
          lengths.data() + number * num_rods,
          moving_lengths.empty() ? nullptr : moving_lengths.data() + number * num_rods * num_lanes,
          factor.data() + number * static_cast<std::size_t>(schedule.num_slots)};
}

std::vector<EqualIslands> take_equal_islands(const Constraints& constraints, const Numbering& numbering,
                                             std::span<const double> inverse_mass, bool eagerly,
                                             std::vector<Index>* islands) {
  const RodRows rods(constraints, numbering.num_rows());
  std::map<IslandTopology, std::vector<Island>> by_topology;
  for (const Index number : *islands) {
    const Index* const start = numbering.island_start.data() + number;
    if (!eagerly && static_cast<std::size_t>(start[1] - start[0]) > plan::most_rods_of_batch) continue;
    IslandTopology topology;
    Island island;
    const auto num_moving = static_cast<Index>(numbering.num_moving);
    if (!read_island(rods, start[0], start[1], num_moving, &topology, &island)) continue;
    island.number = number;
    by_topology[std::move(topology)].push_back(std::move(island));
  }
  std::vector<EqualIslands> result;
  std::vector<char> is_taken(numbering.num_islands(), 0);
  for (const auto& [topology, members] : by_topology) {
    const std::size_t lanes = (members.size() + num_lanes - 1) / num_lanes * num_lanes;
    const bool is_long = topology.rods.size() > plan::long_path && is_path(topology);
    const double wanted = is_long ? plan::fullness_of_long_paths : plan::fullness_of_lanes;
    if (!eagerly && static_cast<double>(members.size()) < wanted * static_cast<double>(lanes)) continue;
    const double flops = IslandSchedule(topology).flops();
    if (!eagerly && flops > plan::most_flops_a_rod * static_cast<double>(topology.rods.size())) continue;
    result.push_back(make_equal_islands(topology, members, rods, inverse_mass));
    for (const Island& island : members) is_taken[static_cast<std::size_t>(island.number)] = 1;
  }
  std::erase_if(*islands, [&](Index number) { return is_taken[static_cast<std::size_t>(number)] != 0; });
  return result;
}

}  // namespace tanor
