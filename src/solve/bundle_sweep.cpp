#include "solve/bundle_sweep.hpp"

#include <algorithm>
#include <limits>
#include <map>

namespace tanor {

namespace {

// Beyond, a batch's numbers leave the first caches and sparse factorizations take over.
constexpr std::size_t most_rods = 128;
constexpr double most_flops_a_rod = 500.0;
constexpr std::size_t most_topologies = 64;

}  // namespace

// ---- set-up ----

/// [row]; block -1 where the row is no rod.
std::vector<BundleSweep::Rod> BundleSweep::read_rods(const Constraints& constraints, std::size_t num_rows) {
  std::vector<Rod> result(num_rows, Rod{{-1, -1}, -1});
  const auto read = [&]<bool Timed, bool Shifted>(const Family<RodKernel<Timed, Shifted>>& rods) {
    for (std::size_t k = 0; k < rods.size(); ++k) {
      Rod& rod = result[static_cast<std::size_t>(rods.rows[k])];
      rod = {rods.kernel.points[k], rods.first_block + static_cast<Index>(k)};
      if constexpr (Shifted) rod.offset = rods.kernel.offset[k];
      if constexpr (Timed) rod.length = &rods.kernel.moving_length[k];
    }
  };
  read(constraints.family<RodKernel<false, false>>());
  read(constraints.family<RodKernel<false, true>>());
  read(constraints.family<RodKernel<true, false>>());
  read(constraints.family<RodKernel<true, true>>());
  return result;
}

/// The rods in [first_row, end_row) as a topology; false where one of them is none.
bool BundleSweep::read_island(std::span<const Rod> rods, Index first_row, Index end_row, Index num_moving,
                              IslandTopology* topology, Island* island) {
  *topology = {};
  *island = {};
  island->first_point = std::numeric_limits<Index>::max();
  Index last_point = 0;
  for (Index row = first_row; row < end_row; ++row) {
    const Rod& rod = rods[static_cast<std::size_t>(row)];
    if (rod.block < 0) return false;
    island->rows.push_back(row);
    for (const Index point : rod.points) {
      if (point >= num_moving) continue;
      island->first_point = std::min(island->first_point, point);
      last_point = std::max(last_point, point);
    }
  }
  topology->num_points = last_point - island->first_point + 1;
  // By their points, wherever the user put them; a support is numbered after every point that moves.
  const auto ends = [&](Index row) {
    const auto [i, j] = rods[static_cast<std::size_t>(row)].points;
    return std::array{std::min(i, j), std::min(std::max(i, j), num_moving)};
  };
  std::stable_sort(island->rows.begin(), island->rows.end(), [&](Index a, Index b) { return ends(a) < ends(b); });
  for (const Index row : island->rows) {
    const Rod& rod = rods[static_cast<std::size_t>(row)];
    const auto [low, high] = std::minmax(rod.points[0], rod.points[1]);
    island->is_reversed.push_back(rod.points[0] == high ? 1 : 0);
    int end = high - island->first_point;
    if (high >= num_moving) {
      end = topology->num_points + topology->num_supports++;
      island->supports.push_back(high);
    }
    topology->rods.push_back({low - island->first_point, end});
  }
  return true;
}

std::unique_ptr<BundleSweep> BundleSweep::make(const Constraints& constraints, const Numbering& numbering,
                                               std::span<const double> inverse_mass, int threads, bool eagerly) {
  const std::vector<Rod> rods = read_rods(constraints, numbering.num_rows());
  std::map<IslandTopology, std::vector<Island>> islands;
  const std::vector<Index>& start = numbering.island_start;
  for (std::size_t k = 0; k + 1 < start.size(); ++k) {
    if (!eagerly && static_cast<std::size_t>(start[k + 1] - start[k]) > most_rods) return nullptr;
    IslandTopology topology;
    Island island;
    const auto num_moving = static_cast<Index>(numbering.num_moving);
    if (!read_island(rods, start[k], start[k + 1], num_moving, &topology, &island)) return nullptr;
    islands[std::move(topology)].push_back(std::move(island));
    if (!eagerly && islands.size() > most_topologies) return nullptr;
  }

  std::unique_ptr<BundleSweep> result(new BundleSweep);
  std::size_t num_lanes_used = 0;
  for (const auto& [topology, members] : islands) {
    result->add_bundle(topology, members, rods, inverse_mass);
    num_lanes_used += num_lanes * result->bundles_.back().num_batches;
    const double flops = result->bundles_.back().schedule.flops();
    if (!eagerly && flops > most_flops_a_rod * static_cast<double>(topology.rods.size())) return nullptr;
  }
  if (!eagerly && 2 * numbering.num_islands() < num_lanes_used) return nullptr;

  result->desks_.resize(static_cast<std::size_t>(Parallel(threads).threads()));
  for (Desk& desk : result->desks_) {
    for (const Bundle& bundle : result->bundles_) {
      const auto enlarge = [](auto& list, std::size_t size) { list.resize(std::max(list.size(), size)); };
      for (std::vector<Eight3>* points : {&desk.r, &desk.v, &desk.w, &desk.dw}) enlarge(*points, bundle.num_places());
      enlarge(desk.u, bundle.num_rods());
      for (Eights* rows : {&desk.b, &desk.x, &desk.second_derivatives}) enlarge(*rows, bundle.num_rods());
    }
  }
  Summary& summary = result->summary_;
  summary.name = "bundles";
  summary.reason = std::to_string(numbering.num_islands()) + " islands of rods have " + std::to_string(islands.size()) +
                   (islands.size() == 1 ? " structure" : " structures");
  summary.parts = numbering.num_islands();
  return result;
}

void BundleSweep::add_bundle(const IslandTopology& topology, std::span<const Island> islands, std::span<const Rod> rods,
                             std::span<const double> inverse_mass) {
  Bundle bundle(topology);
  bundle.num_batches = (islands.size() + num_lanes - 1) / num_lanes;
  const std::size_t num_places = bundle.num_places(), num_rods = bundle.num_rods();
  bundle.points.resize(bundle.num_batches * num_places * num_lanes);
  bundle.rows.resize(bundle.num_batches * num_rods * num_lanes);
  bundle.blocks.resize(bundle.rows.size());
  bundle.inverse_mass.resize(bundle.num_batches * num_places);
  bundle.factor.resize(bundle.num_batches * static_cast<std::size_t>(bundle.schedule.num_slots));
  for (std::size_t k = 0; k < bundle.num_batches * num_lanes; ++k) {
    const Island& island = islands[std::min(k, islands.size() - 1)];
    const std::size_t batch = k / num_lanes, lane = k % num_lanes;
    for (std::size_t p = 0; p < num_places; ++p) {
      const auto num_points = static_cast<std::size_t>(topology.num_points);
      const Index point = p < num_points ? island.first_point + static_cast<Index>(p) : island.supports[p - num_points];
      bundle.points[(batch * num_places + p) * num_lanes + lane] = point;
      bundle.inverse_mass.data()[batch * num_places + p][lane] = inverse_mass[static_cast<std::size_t>(point)];
    }
    for (std::size_t a = 0; a < num_rods; ++a) {
      const Rod& rod = rods[static_cast<std::size_t>(island.rows[a])];
      const std::size_t place = batch * num_rods + a;
      const bool is_reversed = island.is_reversed[a] != 0;
      bundle.rows[place * num_lanes + lane] = island.rows[a];
      bundle.blocks[place * num_lanes + lane] = is_reversed ? ~rod.block : rod.block;
      if (dot(rod.offset, rod.offset) > 0.0) {
        bundle.offsets.resize(bundle.num_batches * num_rods);
        set_lane(&bundle.offsets[place], lane, is_reversed ? -rod.offset : rod.offset);
      }
      if (rod.length != nullptr) {
        bundle.lengths.resize(bundle.rows.size());
        bundle.lengths[place * num_lanes + lane] = rod.length;
      }
    }
  }
  const std::size_t num_entries = islands.size() * static_cast<std::size_t>(bundle.schedule.num_slots);
  summary_.factor_nonzeros += num_entries;
  summary_.pattern_nonzeros += num_entries - islands.size() * bundle.schedule.num_fill_slots;
  summary_.flops += static_cast<double>(islands.size()) * bundle.schedule.flops();
  bundles_.push_back(std::move(bundle));
}

// ---- every step ----

/// work(bundle, batch, desk), with the desks cleared before: a thread a desk.
template <class Work>
void BundleSweep::for_each_batch(const Parallel& parallel, const Work& work) {
  for (Desk& desk : desks_) {
    desk.smallest = Eight{} + 1.0;
    desk.right_side = desk.residual = {};
  }
  for (Bundle& bundle : bundles_) {
    constexpr std::size_t least_numbers = 4096;  // of rows: fewer are not worth a thread
    const std::size_t batches = bundle.num_batches;
    const std::size_t worthwhile = batches * bundle.num_rods() * num_lanes / least_numbers;
    const std::size_t shares = std::clamp<std::size_t>(worthwhile, 1, desks_.size());
    const auto share = [&](std::size_t k) {
      for (std::size_t batch = batches * k / shares; batch < batches * (k + 1) / shares; ++batch)
        work(bundle, batch, desks_[k]);
    };
    parallel.for_tasks(shares, share);
  }
}

Elimination BundleSweep::found() const {
  Elimination result;
  for (const Desk& desk : desks_) {
    for (std::size_t lane = 0; lane < num_lanes; ++lane)
      result.reciprocal_condition = std::min(result.reciprocal_condition, desk.smallest[lane]);
    result.largest_right_side = larger(result.largest_right_side, desk.right_side.read());
    result.residual = larger(result.residual, desk.residual.read());
  }
  return result;
}

/// Of the lengths that move; null where none does.
const Eight* BundleSweep::second_derivatives(const Bundle& bundle, std::size_t batch, Desk* desk) const {
  if (bundle.lengths.empty()) return nullptr;
  const std::size_t count = bundle.num_rods() * num_lanes;
  const MovingScalar* const* const lengths = bundle.lengths.data() + batch * count;
  Eight* const result = desk->second_derivatives.data();
  for (std::size_t k = 0; k < count; ++k)
    result[k / num_lanes][k % num_lanes] = lengths[k] != nullptr ? lengths[k]->second : 0.0;
  return result;
}

Elimination BundleSweep::solve(const Parallel& parallel, const FreeMotion& motion, double* blocks, double*,
                               double* lambda, double* w) {
  for_each_batch(parallel, [&](Bundle& bundle, std::size_t batch, Desk& desk) {
    const std::size_t num_places = bundle.num_places(), num_rods = bundle.num_rods();
    const auto num_points = static_cast<std::size_t>(bundle.topology.num_points);
    const Index* const points = bundle.points.data() + batch * num_places * num_lanes;
    const Index* const rows = bundle.rows.data() + batch * num_rods * num_lanes;
    const Eight* const inverse_mass = bundle.inverse_mass.data() + batch * num_places;
    gather_points(motion.r, points, num_places, desk.r.data());
    gather_points(motion.v, points, num_places, desk.v.data());
    const std::size_t num_known = motion.uniform != nullptr ? num_points : 0;
    if (num_known > 0) fill(desk.w.data(), num_known, *motion.uniform);
    gather_points(motion.w0, points + num_known * num_lanes, num_places - num_known, desk.w.data() + num_known);

    const Eight3* const offsets = bundle.offsets.empty() ? nullptr : bundle.offsets.data() + batch * num_rods;
    evaluate_rods(bundle.topology, desk.r.data(), desk.v.data(), desk.w.data(), offsets,
                  second_derivatives(bundle, batch, &desk), desk.u.data(), desk.b.data(), &desk.right_side);
    eliminate(bundle.topology, bundle.schedule, inverse_mass, desk.u.data(), bundle.factor_of(batch), &desk.smallest);
    tanor::solve_negative(bundle.schedule, bundle.factor_of(batch), desk.b.data(), desk.x.data());
    apply(bundle.topology, inverse_mass, desk.u.data(), desk.b.data(), desk.x.data(), desk.dw.data(), &desk.residual);
    add(desk.dw.data(), num_points, desk.w.data());

    scatter_points(desk.w.data(), points, num_points, w);
    scatter_blocks(desk.u.data(), bundle.blocks.data() + batch * num_rods * num_lanes, num_rods, blocks);
    scatter_rows(desk.x.data(), rows, num_rods, lambda);
  });
  return found();
}

Elimination BundleSweep::factorize(const Parallel& parallel, const double* blocks) {
  for_each_batch(parallel, [&](Bundle& bundle, std::size_t batch, Desk& desk) {
    const std::size_t num_rods = bundle.num_rods();
    gather_blocks(blocks, bundle.blocks.data() + batch * num_rods * num_lanes, num_rods, desk.u.data());
    eliminate(bundle.topology, bundle.schedule, bundle.inverse_mass.data() + batch * bundle.num_places(), desk.u.data(),
              bundle.factor_of(batch), &desk.smallest);
  });
  return found();
}

void BundleSweep::solve_negative(const Parallel& parallel, const double* b, double* x) {
  for_each_batch(parallel, [&](Bundle& bundle, std::size_t batch, Desk& desk) {
    const Index* const rows = bundle.rows.data() + batch * bundle.num_rods() * num_lanes;
    gather_rows(b, rows, bundle.num_rods(), desk.b.data());
    tanor::solve_negative(bundle.schedule, bundle.factor_of(batch), desk.b.data(), desk.x.data());
    scatter_rows(desk.x.data(), rows, bundle.num_rods(), x);
  });
}

}  // namespace tanor
