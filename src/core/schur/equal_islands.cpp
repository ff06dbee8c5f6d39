#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "plan/thresholds.hpp"
#include "schur/lane_plan.hpp"

namespace tanor::detail {

namespace {

struct Island {
  IslandTopology topology;
  Index number, first_point = 0;
  std::vector<Index> rows, supports{};  // by the topology's rods and places
};

/// Reads an island. Returns nothing if one of its rows is no rod.
std::optional<Island> read_island(const RodRows& rods, const Numbering& numbering, Index number) {
  const auto num_moving = static_cast<Index>(numbering.num_moving);
  const Index* const start = numbering.island_start.data() + number;
  Island island{{}, number, 0, std::vector<Index>(static_cast<std::size_t>(start[1] - start[0]))};
  std::iota(island.rows.begin(), island.rows.end(), start[0]);
  // Rods are sorted by their points, wherever the user put them. A support is numbered after every moving point.
  const auto ends = [&](Index row) {
    const auto [i, j] = rods.ends[static_cast<std::size_t>(row)];
    return std::array{std::min(i, j), std::min(std::max(i, j), num_moving)};
  };
  std::ranges::stable_sort(island.rows, {}, ends);
  if (island.first_point = ends(island.rows[0])[0]; island.first_point < 0) return std::nullopt;
  IslandTopology& topology = island.topology;
  for (const Index row : island.rows) {
    const auto [low, high] = ends(row);
    topology.num_points = std::max(topology.num_points, (high < num_moving ? high : low) + 1 - island.first_point);
  }
  for (const Index row : island.rows) {
    auto [low, end] = ends(row);
    end -= island.first_point;
    if (const Index high = std::ranges::max(rods.ends[static_cast<std::size_t>(row)]); high >= num_moving) {
      end = topology.num_points + topology.num_supports++;
      island.supports.push_back(high);
    }
    topology.rods.push_back({low - island.first_point, end});
  }
  return island;
}

/// Puts eight islands of one topology side by side.
void add_group(const IslandSchedule& schedule, std::span<const Island> members, LanePlan* plan) {
  const auto num_points = static_cast<std::size_t>(schedule.topology.num_points),
             num_supports = static_cast<std::size_t>(schedule.topology.num_supports);
  const auto num_slots = static_cast<std::size_t>(schedule.num_slots);
  LaneGroup& group = plan->add({.num_rods = schedule.topology.rods.size(),
                                .num_places = num_points + num_supports,
                                .num_members = members.size(),
                                .schedule = &schedule,
                                .has_supports = num_supports > 0},
                               num_slots);
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    const Island& island = members[std::min(lane, members.size() - 1)];
    const Index first = island.first_point;
    if (lane < members.size()) plan->islands.push_back({first, first + static_cast<Index>(num_points)});
    group.island[lane] = static_cast<Index>(plan->islands.size()) - 1;
    for (std::size_t k = 0; k < group.num_rods; ++k)
      plan->row[(group.first_rod + k) * num_lanes + lane] = island.rows[k];
    for (std::size_t p = 0; p < group.num_places; ++p)
      plan->point[(group.first_place + p) * num_lanes + lane] =
          p < num_points ? first + static_cast<Index>(p) : ~island.supports[p - num_points];
  }
  plan->num_rods += members.size() * group.num_rods;
  plan->factor.include({.parts = members.size(),
                        .pattern_nonzeros = members.size() * (num_slots - schedule.num_fill_slots),
                        .factor_nonzeros = members.size() * num_slots,
                        .flops = static_cast<double>(members.size()) * schedule.flops()});
  plan->end_level();
  plan->end_grove();
}

}  // namespace

LanePlan take_equal_islands(const RodRows& rods, const Numbering& numbering, bool eagerly,
                            std::vector<Index>* islands) {
  std::map<IslandTopology, std::vector<Island>> by_topology;
  for (const Index number : *islands) {
    const Index* const start = numbering.island_start.data() + number;
    if (!eagerly && static_cast<std::size_t>(start[1] - start[0]) > plan::most_rods_of_batch) continue;
    if (std::optional<Island> island = read_island(rods, numbering, number))
      by_topology[std::move(island->topology)].push_back(*std::move(island));
  }
  const auto is_open_path = [&](Index number) {
    const std::optional<RodPath> path = find_path(rods.ends, numbering, number);
    return path && !path->is_ring;
  };
  LanePlan result;
  std::vector<char> is_taken(numbering.num_islands(), 0);
  for (const auto& [topology, members] : by_topology) {
    const std::size_t lanes = (members.size() + num_lanes - 1) / num_lanes * num_lanes;
    const bool is_long = topology.rods.size() > plan::long_path && is_open_path(members.front().number);
    const double wanted = is_long ? plan::fullness_of_long_paths : plan::fullness_of_lanes;
    if (!eagerly && static_cast<double>(members.size()) < wanted * static_cast<double>(lanes)) continue;
    auto schedule = std::make_unique<const IslandSchedule>(topology);
    const double most_flops = plan::most_flops_a_rod * static_cast<double>(topology.rods.size());
    if (!eagerly && schedule->flops() > most_flops) continue;
    for (std::size_t k = 0; k < members.size(); k += num_lanes)
      add_group(*schedule, std::span(members).subspan(k, std::min(num_lanes, members.size() - k)), &result);
    result.schedules.push_back(std::move(schedule));
    for (const Island& island : members) is_taken[static_cast<std::size_t>(island.number)] = 1;
  }
  std::erase_if(*islands, [&](Index number) { return is_taken[static_cast<std::size_t>(number)] != 0; });
  const std::size_t count = result.schedules.size();
  result.reason = std::to_string(result.factor.parts) + " islands of rods have " + std::to_string(count) +
                  (count == 1 ? " structure" : " structures");
  return result;
}

}  // namespace tanor::detail
