#include "schur/tree_solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "plan/thresholds.hpp"

namespace tanor {

namespace {

/// Scaled to a unit diagonal, pivots lie between 1/largest and 1.
double reciprocal_condition(const trees::PivotRange& range) {
  return range.smallest > 0.0 && range.largest > 0.0 ? 1.0 / range.largest : 0.0;
}

}  // namespace

std::unique_ptr<TreeSolver> TreeSolver::make(const SchurProblem& problem, std::vector<Index>* islands) {
  if (islands->empty()) return nullptr;
  const Numbering& numbering = problem.numbering;
  const std::vector<Index> before = *islands;
  std::unique_ptr<TreeSolver> result(new TreeSolver);
  const RodRows rods(problem.constraints, numbering.num_rows());
  result->inverse_mass_ = problem.inverse_mass;
  result->num_moving_ = static_cast<Index>(numbering.num_moving);
  std::erase_if(*islands, [&](Index island) { return result->add_island(numbering, island, rods); });
  if (result->islands_.empty()) return nullptr;
  result->finish(rods);
  result->serve(problem, before, *islands);
  return result;
}

/// The first rod of a point towards the root is the tree's: its row is the first one with this point as the lower one.
/// False where the island has other constraints or too many rings.
bool TreeSolver::add_island(const Numbering& numbering, Index number, const RodRows& given) {
  const auto first_row = static_cast<std::size_t>(numbering.island_start[static_cast<std::size_t>(number)]);
  const auto end_row = static_cast<std::size_t>(numbering.island_start[static_cast<std::size_t>(number) + 1]);
  Island island{};
  island.first_rod = order_.size();
  std::vector<trees::Rod> rings;
  Index before = -1, lowest = num_moving_, highest = -1;
  const auto refuse = [&] {
    order_.resize(island.first_rod);
    return false;
  };
  for (std::size_t row = first_row; row < end_row; ++row) {
    const auto [i, j] = given.ends[row];
    if (i < 0) return refuse();
    const Index low = std::min(i, j), high = std::max(i, j);
    const bool to_support = high >= num_moving_;
    const trees::Rod rod{static_cast<Index>(row), to_support ? high : low, to_support ? low : high};
    lowest = std::min(lowest, low);
    highest = std::max(highest, to_support ? low : high);
    // A second rod of the same lower point closes a ring; one to a support is a leaf. Lower points ascend, but where
    // the island is a ring: its last rod comes back to the first one.
    if (!to_support && low <= before) {
      rings.push_back(rod);
      if (rings.size() > plan::most_rings_of_tree) return refuse();
      continue;
    }
    if (!to_support) before = low;
    order_.push_back(rod);
  }
  island.end_rod = order_.size();
  order_.insert(order_.end(), rings.begin(), rings.end());
  island.end = order_.size();
  island.first_point = static_cast<std::size_t>(lowest);
  island.end_point = static_cast<std::size_t>(highest) + 1;
  islands_.push_back(island);
  return true;
}

void TreeSolver::finish(const RodRows& given) {
  const std::size_t num_rods = order_.size(), num_points = inverse_mass_.size();
  for (const auto& [inner_row, child, parent] : order_) {
    const auto row = static_cast<std::size_t>(inner_row);
    sign_.push_back(given.ends[row][0] == child ? 1 : -1);
    block_.push_back(given.block[row]);
    if (!given.offset.empty()) offset_.push_back(static_cast<double>(sign_.back()) * given.offset[row]);
    if (const MovingScalar* const length = given.moving_length(row)) lengths_.emplace_back(block_.size() - 1, length);
  }
  if (!lengths_.empty()) length_second_.resize(num_rods, 0.0);
  for (std::vector<Vec3>* array : {&u_, &h_}) array->resize(num_rods);
  inverse_pivot_.resize(num_rods);
  rows_.resize(given.ends.size());
  mobility_.resize(num_points);
  for (std::vector<double>* array : {&s_, &force_}) array->resize(3 * num_points, 0.0);
  std::size_t num_spikes = 0, num_entries = 0, num_rings = 0;
  for (Island& island : islands_) {
    const std::size_t rings = island.num_rings();
    island.first_spike = num_spikes;
    island.first_entry = num_entries;
    num_spikes += rings * (island.end_rod - island.first_rod);
    num_entries += rings * rings;
    num_rings += rings;
  }
  spikes_.resize(num_spikes);
  border_.resize(num_entries);
  group_start_ =
      group_islands(islands_.size(), num_rods, [&](std::size_t k) { return islands_[k].end - islands_[k].first_rod; });
  found_.resize(group_start_.size() - 1);

  constexpr double flops_a_rod = 50.0;
  summary_ = {.solvers = {LinearSolver::Trees},
              .reason = (islands_.size() == 1 ? "one tree" : std::to_string(islands_.size()) + " trees") + " of rods" +
                        (num_rings == 0   ? ""
                         : num_rings == 1 ? ", and one that closes a ring"
                                          : ", and " + std::to_string(num_rings) + " that close rings"),
              .parts = islands_.size(),
              .pattern_nonzeros = 4 * num_rods,
              .factor_nonzeros = 4 * num_rods + num_spikes,
              .flops = flops_a_rod * static_cast<double>(num_rods + num_spikes)};
}

void TreeSolver::Found::include(const Found& other) {
  range.smallest = std::min(range.smallest, other.range.smallest);
  range.largest = larger(range.largest, other.range.largest);
  right_side = larger(right_side, other.right_side);
  residual = larger(residual, other.residual);
  own_residual = larger(own_residual, other.own_residual);
}

/// work(island, found), some islands a thread.
template <class Work>
TreeSolver::Found TreeSolver::for_each_island(const Parallel& parallel, const Work& work) {
  parallel.for_tasks(found_.size(), [&](std::size_t group) {
    found_[group] = {};
    for (std::size_t k = group_start_[group]; k < group_start_[group + 1]; ++k) {
      Found own;
      work(islands_[k], &own);
      own.own_residual = own_residual(own.residual, own.right_side);
      found_[group].include(own);
    }
  });
  Found result;
  for (const Found& found : found_) result.include(found);
  return result;
}

trees::Tree TreeSolver::rods(std::size_t first, std::size_t end) {
  return {order_.data() + first, end - first,       num_moving_,           inverse_mass_.data(),
          u_.data() + first,     h_.data() + first, &inverse_pivot_[first]};
}

// ---- what all calls are made of ----

void TreeSolver::read_directions(const Island& island, const double* blocks) {
  for (std::size_t a = island.first_rod; a < island.end; ++a)
    u_[a] = static_cast<double>(sign_[a]) * load(blocks, block_[a]);
}

/// Of points that no rod holds.
void TreeSolver::prepare(const Island& island) {
  for (std::size_t i = island.first_point; i < island.end_point; ++i) {
    const double w = inverse_mass_[i];
    mobility_[i] = {.xx = w, .yy = w, .zz = w};
  }
}

void TreeSolver::eliminate(const Island& island, Range* range) {
  prepare(island);
  trees::eliminate(tree(island), mobility_.data(), range);
  if (island.num_rings() > 0) eliminate_border(island, range);
}

/// x := -S^-1 b, and K x of the island's points in `force_`.
void TreeSolver::substitute(const Island& island, const double* b, double* x) {
  clear(island, &s_);
  trees::substitute_up(tree(island), b, s_.data(), x);
  finish_substitution(island, b, x);
}

void TreeSolver::finish_substitution(const Island& island, const double* b, double* x) {
  clear(island, &force_);
  trees::substitute_down(tree(island), force_.data(), x);
  if (island.num_rings() > 0) substitute_border(island, b, x);
}

void TreeSolver::clear(const Island& island, std::vector<double>* points) const {
  std::fill(points->begin() + static_cast<std::ptrdiff_t>(3 * island.first_point),
            points->begin() + static_cast<std::ptrdiff_t>(3 * island.end_point), 0.0);
}

/// What a rod's multiplier does to its ends, which move.
void TreeSolver::add_forces(std::size_t rod, double lambda, double* forces) const {
  const Vec3 force = lambda * u_[rod];
  add_to(forces, order_[rod].parent, force);
  if (order_[rod].child < num_moving_) add_to(forces, order_[rod].child, -force);
}

/// dw = M^-1 K lambda
Vec3 TreeSolver::response(Index point) const {
  return point < num_moving_ ? inverse_mass_[static_cast<std::size_t>(point)] * load(force_.data(), point) : Vec3{};
}

/// A row of K'dw.
double TreeSolver::gap(std::size_t rod) const {
  return dot(u_[rod], response(order_[rod].parent) - response(order_[rod].child));
}

// ---- the rows that close rings ----

/// G = C - B'T^-1 B of S = [T B; B' C], T the tree's; a unit multiplier of a ring is answered by a spike of the tree's.
void TreeSolver::eliminate_border(const Island& island, Range* range) {
  const std::size_t rings = island.num_rings(), rods = island.end_rod - island.first_rod;
  double* const G = border_.data() + island.first_entry;
  for (std::size_t m = 0; m < rings; ++m) {
    const std::size_t ring = island.end_rod + m;
    clear(island, &s_);
    add_forces(ring, 1.0, s_.data());
    for (const Index point : {order_[ring].child, order_[ring].parent})
      store(s_.data(), point, inverse_mass_[static_cast<std::size_t>(point)] * load(s_.data(), point));
    trees::substitute_up(tree(island), nullptr, s_.data(), rows_.data());
    clear(island, &force_);
    trees::substitute_down(tree(island), force_.data(), rows_.data());
    double* const spike = spikes_.data() + island.first_spike + m * rods;
    for (std::size_t a = 0; a < rods; ++a) spike[a] = rows_[static_cast<std::size_t>(order_[island.first_rod + a].row)];
    add_forces(ring, 1.0, force_.data());
    for (std::size_t n = m; n < rings; ++n) G[n * rings + m] = gap(island.end_rod + n);
  }
  // G = L D L', 1/D in its place
  for (std::size_t m = 0; m < rings; ++m) {
    const auto& [row, child, parent] = order_[island.end_rod + m];
    const double diagonal =
        inverse_mass_[static_cast<std::size_t>(child)] + inverse_mass_[static_cast<std::size_t>(parent)];
    const double inverse = 1.0 / G[m * rings + m], ratio = diagonal * inverse;
    range->smallest = std::min(range->smallest, ratio);
    range->largest = larger(range->largest, ratio);
    for (std::size_t n = m + 1; n < rings; ++n) {
      const double factor = G[n * rings + m] * inverse;
      for (std::size_t k = n; k < rings; ++k) G[k * rings + n] -= factor * G[k * rings + m];
    }
    for (std::size_t n = m + 1; n < rings; ++n) G[n * rings + m] *= inverse;
    G[m * rings + m] = inverse;
  }
}

/// mu = -G^-1 (b + K'dw), lambda += spikes mu; x and `force_` are the tree's alone on entry.
void TreeSolver::substitute_border(const Island& island, const double* b, double* x) {
  const std::size_t rings = island.num_rings(), rods = island.end_rod - island.first_rod;
  const double* const G = border_.data() + island.first_entry;
  std::array<double, plan::most_rings_of_tree> mu{};
  for (std::size_t m = 0; m < rings; ++m) {
    mu[m] = b[order_[island.end_rod + m].row] + gap(island.end_rod + m);
    for (std::size_t n = 0; n < m; ++n) mu[m] -= G[m * rings + n] * mu[n];
  }
  for (std::size_t m = 0; m < rings; ++m) mu[m] *= -G[m * rings + m];
  for (std::size_t m = rings; m-- > 0;) {
    for (std::size_t n = m + 1; n < rings; ++n) mu[m] -= G[n * rings + m] * mu[n];
  }
  for (std::size_t m = 0; m < rings; ++m) {
    const double* const spike = spikes_.data() + island.first_spike + m * rods;
    for (std::size_t a = 0; a < rods; ++a) x[order_[island.first_rod + a].row] += mu[m] * spike[a];
    x[order_[island.end_rod + m].row] = mu[m];
  }
  clear(island, &force_);
  for (std::size_t a = island.first_rod; a < island.end; ++a) add_forces(a, x[order_[a].row], force_.data());
}

// ---- the calls ----

/// What rods from `rod` on are evaluated with.
trees::Motion TreeSolver::motion_from(std::size_t rod, const FreeMotion& motion, double* blocks, double* b) const {
  return {.r = motion.r,
          .v = motion.v,
          .w0 = motion.w0,
          .uniform = motion.uniform,
          .offset = offset_.empty() ? nullptr : &offset_[rod],
          .length_second = length_second_.empty() ? nullptr : &length_second_[rod],
          .sign = &sign_[rod],
          .block = &block_[rod],
          .blocks = blocks,
          .b = b};
}

/// w = w0 + dw, and what K'dw + b leaves over.
void TreeSolver::accelerate(const Island& island, const Vec3* uniform, const double* b, double* w, Found* found) const {
  for (auto i = static_cast<Index>(island.first_point); i < static_cast<Index>(island.end_point); ++i)
    store(w, i, (uniform != nullptr ? *uniform : load(w, i)) + response(i));
  for (std::size_t a = island.first_rod; a < island.end; ++a)
    found->residual = larger(found->residual, std::abs(gap(a) + b[order_[a].row]));
}

Elimination TreeSolver::solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks,
                              double* b, double* lambda, double* w) {
  bring_points(parallel, motion.source);
  for (const auto& [rod, length] : lengths_) length_second_[rod] = length->second;
  if (use == FactorUse::Keep) {
    const Found found = for_each_island(parallel, [&](const Island& island, Found* of_group) {
      of_group->right_side = trees::evaluate(rods(island.first_rod, island.end),
                                             motion_from(island.first_rod, motion, blocks, b), of_group->right_side);
      substitute(island, b, lambda);
      accelerate(island, motion.uniform, b, w, of_group);
    });
    return {.largest_right_side = found.right_side, .residual = found.residual, .own_residual = found.own_residual};
  }
  const Found found = for_each_island(parallel, [&](const Island& island, Found* of_group) {
    prepare(island);
    clear(island, &s_);
    of_group->right_side =
        trees::evaluate_and_eliminate(tree(island), motion_from(island.first_rod, motion, blocks, b),
                                      of_group->right_side, mobility_.data(), s_.data(), lambda, &of_group->range);
    if (island.num_rings() > 0) {
      of_group->right_side = trees::evaluate(rods(island.end_rod, island.end),
                                             motion_from(island.end_rod, motion, blocks, b), of_group->right_side);
      eliminate_border(island, &of_group->range);
    }
    finish_substitution(island, b, lambda);
    accelerate(island, motion.uniform, b, w, of_group);
  });
  return {reciprocal_condition(found.range), found.right_side, found.residual, found.own_residual};
}

Elimination TreeSolver::factorize(const Parallel& parallel, const double* blocks) {
  const Found found = for_each_island(parallel, [&](const Island& island, Found* of_group) {
    read_directions(island, blocks);
    eliminate(island, &of_group->range);
  });
  return {.reciprocal_condition = reciprocal_condition(found.range)};
}

void TreeSolver::solve_negative(const Parallel& parallel, const double* b, double* x) {
  (void)for_each_island(parallel, [&](const Island& island, Found*) { substitute(island, b, x); });
}

void TreeSolver::correct(const Parallel& parallel, const double*, double* rows, double* points) {
  (void)for_each_island(parallel, [&](const Island& island, Found*) {
    substitute(island, rows, rows);
    for (auto i = static_cast<Index>(island.first_point); i < static_cast<Index>(island.end_point); ++i)
      add_to(points, i, response(i));
  });
}

}  // namespace tanor
