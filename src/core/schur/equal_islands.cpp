#include "schur/equal_islands.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>

#include "plan/thresholds.hpp"
#include "schur/rod_rows.hpp"

namespace tanor::detail {

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

  /// Writes first points, rows and blocks. One batch more than there are tells what comes after the last one.
  void write_numbers() {
    result_.first_point.resize((result_.num_batches + 1) * num_lanes);
    for (std::size_t k = 0; k < result_.first_point.size(); ++k) result_.first_point[k] = in_lane(k).first_point;
    const auto row = [](const Island& island, std::size_t a) { return island.rows[a]; };
    const auto block = [&](const Island& island, std::size_t a) {
      return static_cast<Index>(rods_.block[static_cast<std::size_t>(island.rows[a])]);
    };
    const auto is_reversed = [](const Island& island, std::size_t a) { return island.is_reversed[a] != 0; };
    result_.rows = number_rods(1, row, [](const Island&, std::size_t) { return false; });
    result_.blocks = number_rods(3, block, is_reversed);
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

  /// Returns the rods of the first island in the order of their numbers.
  template <class Number>
  std::vector<std::size_t> sort_rods(const Number& number) const {
    std::vector<std::size_t> order(num_rods_);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::sort(order, {}, [&](std::size_t a) { return number(islands_[0], a); });
    return order;
  }

  /// Returns true if the numbers of every island count up in this order, with the signs of the first island.
  template <class Number, class IsNegative>
  bool follow(const std::vector<std::size_t>& order, const Number& number, const IsNegative& is_negative) const {
    return std::ranges::all_of(islands_, [&](const Island& island) {
      for (std::size_t k = 0; k < num_rods_; ++k) {
        const std::size_t a = order[k];
        if (number(island, a) != number(island, order[0]) + static_cast<Index>(k)) return false;
        if (is_negative(island, a) != is_negative(islands_[0], a)) return false;
      }
      return true;
    });
  }

  /// Writes number(island, rod), each of which stands for `width` numbers in memory with a sign.
  template <class Number, class IsNegative>
  EqualIslands::RodNumbers number_rods(std::size_t width, const Number& number, const IsNegative& is_negative) const {
    EqualIslands::RodNumbers result;
    const std::vector<std::size_t> order = sort_rods(number);
    const bool is_in_order = std::ranges::is_sorted(order);
    // Single numbers in another order are moved one by one in less time.
    result.follow = (width > 1 || is_in_order) && follow(order, number, is_negative);
    if (result.follow) {
      SequencePlaces places;
      for (std::size_t k = 0; k < width * num_rods_; ++k) {
        const std::size_t rod = order[k / width];
        places.place.push_back(static_cast<int>(width * rod + k % width));
        places.sign.push_back(is_negative(islands_[0], rod) ? -1.0 : 1.0);
      }
      result.sign = places.sign[0];
      const bool has_one_sign = std::ranges::count(places.sign, result.sign) == std::ssize(places.sign);
      if (!is_in_order || !has_one_sign) result.places = std::move(places);
    }
    const std::size_t num_written = result.follow ? 1 : num_rods_;
    for (std::size_t k = 0; k < (result_.num_batches + 1) * num_written * num_lanes; ++k) {
      const Island& island = in_lane(k / (num_written * num_lanes) * num_lanes + k % num_lanes);
      const std::size_t a = result.follow ? order[0] : k / num_lanes % num_written;
      const bool is_turned = !result.follow && is_negative(island, a);
      result.numbers.push_back(is_turned ? ~number(island, a) : number(island, a));
    }
    return result;
  }

  void write_rod(const Island& island, std::size_t a, std::size_t place, std::size_t lane) {
    const auto number = static_cast<std::size_t>(island.rows[a]);
    const Vec3 offset = rods_.offset.empty() ? Vec3{} : rods_.offset[number];
    if (dot(offset, offset) > 0.0) result_.shifted_rods.push_back({place, lane, number, island.is_reversed[a] != 0});
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
  result.read_offsets(rods.offset);
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
          rows.of_batch(number, num_rods),
          blocks.of_batch(number, num_rods),
          inverse_mass.data() + number * num_places,
          offsets.empty() ? nullptr : offsets.data() + number * num_rods,
          lengths.data() + number * num_rods,
          moving_lengths.empty() ? nullptr : moving_lengths.data() + number * num_rods * num_lanes,
          factor.data() + number * static_cast<std::size_t>(schedule.num_slots)};
}

void EqualIslands::read_offsets(std::span<const Vec3> by_row) {
  if (shifted_rods.empty()) return;
  offsets.resize(num_batches * topology.rods.size());
  for (const auto& [place, lane, row, is_reversed] : shifted_rods)
    set_lane(&offsets[place], lane, is_reversed ? -by_row[row] : by_row[row]);
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

}  // namespace tanor::detail
