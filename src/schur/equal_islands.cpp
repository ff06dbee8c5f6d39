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

/// Reads the rods in [first_row, end_row) as a topology. Returns false if one of the rows is no rod.
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
  // Rods are sorted by their points, wherever the user put them. A support is numbered after every moving point.
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

/// Returns true if the rods form one path, from a free end or a support to another one.
bool is_path(const IslandTopology& topology) {
  std::vector<int> num_rods(static_cast<std::size_t>(topology.num_points + topology.num_supports), 0);
  for (const auto& [i, j] : topology.rods) {
    ++num_rods[static_cast<std::size_t>(i)];
    ++num_rods[static_cast<std::size_t>(j)];
  }
  return topology.rods.size() + 1 == num_rods.size() && *std::max_element(num_rods.begin(), num_rods.end()) <= 2;
}

/// Writes the numbers of islands of one topology into the lanes of their batches. Lanes that are left over repeat the
/// last island.
class BatchWriter {
 public:
  BatchWriter(std::span<const Island> islands, const RodRows& rods, EqualIslands* result)
      : islands_(islands),
        rods_(rods),
        result_(*result),
        num_rods_(result->topology.rods.size()),
        num_points_(static_cast<std::size_t>(result->topology.num_points)),
        num_supports_(static_cast<std::size_t>(result->topology.num_supports)) {
    result_.num_islands = islands.size();
    result_.num_batches = (islands.size() + num_lanes - 1) / num_lanes;
  }

  /// Writes first points, rows and blocks. Only those of the first rod are written if the others follow it in every
  /// island. One batch more than there are tells what comes after the last one.
  void write_numbers() {
    const auto row = [](const Island& island, std::size_t a) { return island.rows[a]; };
    const auto block = [&](const Island& island, std::size_t a) {
      return static_cast<Index>(rods_.block[static_cast<std::size_t>(island.rows[a])]);
    };
    result_.rows_follow = follow(row);
    if (have_one_direction() && follow(block)) result_.block_sign = islands_[0].is_reversed[0] != 0 ? -1.0 : 1.0;
    const std::size_t rows_a_batch = result_.rows_follow ? 1 : num_rods_;
    const std::size_t blocks_a_batch = result_.block_sign != 0.0 ? 1 : num_rods_;
    const std::size_t num_lanes_in_all = (result_.num_batches + 1) * num_lanes;
    result_.first_point.resize(num_lanes_in_all);
    result_.rows.resize(num_lanes_in_all * rows_a_batch);
    result_.blocks.resize(num_lanes_in_all * blocks_a_batch);
    for (std::size_t k = 0; k < num_lanes_in_all; ++k) {
      const Island& island = in_lane(k);
      const std::size_t batch = k / num_lanes, lane = k % num_lanes;
      result_.first_point[k] = island.first_point;
      for (std::size_t a = 0; a < rows_a_batch; ++a)
        result_.rows[(batch * rows_a_batch + a) * num_lanes + lane] = row(island, a);
      for (std::size_t a = 0; a < blocks_a_batch; ++a) {
        const bool is_turned = result_.block_sign == 0.0 && island.is_reversed[a] != 0;
        result_.blocks[(batch * blocks_a_batch + a) * num_lanes + lane] =
            is_turned ? ~block(island, a) : block(island, a);
      }
    }
  }

  void write_points(std::span<const double> inverse_mass) {
    const std::size_t num_places = num_points_ + num_supports_;
    result_.supports.resize(result_.num_batches * num_supports_ * num_lanes);
    result_.inverse_mass.resize((result_.num_batches + 1) * num_places);
    for (std::size_t k = 0; k < result_.num_batches * num_lanes; ++k) {
      const Island& island = in_lane(k);
      const std::size_t batch = k / num_lanes, lane = k % num_lanes;
      for (std::size_t p = 0; p < num_places; ++p) {
        Index point = island.first_point + static_cast<Index>(p);
        if (p >= num_points_) {
          point = island.supports[p - num_points_];
          result_.supports[(batch * num_supports_ + p - num_points_) * num_lanes + lane] = point;
        }
        result_.inverse_mass.data()[batch * num_places + p][lane] = inverse_mass[static_cast<std::size_t>(point)];
      }
    }
  }

  void write_rods() {
    result_.lengths.resize(result_.num_batches * num_rods_);
    for (std::size_t k = 0; k < result_.num_batches * num_lanes; ++k) {
      const Island& island = in_lane(k);
      for (std::size_t a = 0; a < num_rods_; ++a) write_rod(island, a, k / num_lanes * num_rods_ + a, k % num_lanes);
    }
  }

 private:
  const Island& in_lane(std::size_t k) const { return islands_[std::min(k, islands_.size() - 1)]; }

  /// Returns true if number(island, rod) counts up from rod to rod in every island.
  template <class Number>
  bool follow(const Number& number) const {
    return std::all_of(islands_.begin(), islands_.end(), [&](const Island& island) {
      std::size_t a = 0;
      while (a < num_rods_ && number(island, a) == number(island, 0) + static_cast<Index>(a)) ++a;
      return a == num_rods_;
    });
  }
  bool have_one_direction() const {
    const char first = islands_[0].is_reversed[0];
    return std::all_of(islands_.begin(), islands_.end(), [&](const Island& island) {
      return std::all_of(island.is_reversed.begin(), island.is_reversed.end(), [&](char is) { return is == first; });
    });
  }

  void write_rod(const Island& island, std::size_t a, std::size_t place, std::size_t lane) {
    const auto number = static_cast<std::size_t>(island.rows[a]);
    const Vec3 offset = rods_.offset.empty() ? Vec3{} : rods_.offset[number];
    if (dot(offset, offset) > 0.0) {
      result_.offsets.resize(result_.num_batches * num_rods_);
      set_lane(&result_.offsets[place], lane, island.is_reversed[a] != 0 ? -offset : offset);
    }
    result_.lengths.data()[place][lane] = rods_.constant_length[number];
    if (const MovingScalar* const moving = rods_.moving_length(number)) {
      result_.moving_lengths.resize(result_.num_batches * num_rods_ * num_lanes);
      result_.moving_lengths[place * num_lanes + lane] = moving;
    }
  }

  const std::span<const Island> islands_;
  const RodRows& rods_;
  EqualIslands& result_;
  const std::size_t num_rods_, num_points_, num_supports_;
};

EqualIslands make_equal_islands(const IslandTopology& topology, std::span<const Island> islands, const RodRows& rods,
                                std::span<const double> inverse_mass) {
  EqualIslands result(topology);
  BatchWriter writer(islands, rods, &result);
  writer.write_numbers();
  writer.write_points(inverse_mass);
  writer.write_rods();
  result.factor.resize((result.num_batches + 1) * static_cast<std::size_t>(result.schedule.num_slots));
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
