#include "solve/path_sweep.hpp"

#include <algorithm>

/// \file Which systems are paths, and which thread takes what; the sweeps themselves are in path_halves.cpp.
namespace tanor {

namespace {

constexpr std::size_t few_paths = 8, rows_worth_a_thread = 4096, most_groups = 64;

}  // namespace

void PathSweep::Range::include(const Range& other) {
  smallest_ratio = std::min(smallest_ratio, other.smallest_ratio);
  largest_ratio = larger(largest_ratio, other.largest_ratio);
  largest = larger(largest, other.largest);
}

std::unique_ptr<PathSweep> PathSweep::make(const Constraints& constraints, const Numbering& numbering,
                                           std::span<const double> inverse_mass) {
  std::unique_ptr<PathSweep> result(new PathSweep);
  result->inverse_mass_ = inverse_mass;
  std::vector<std::array<Index, 2>> ends(numbering.num_rows(), {-1, -1});
  result->read_rods(constraints, &ends);
  for (std::size_t island = 0; island < numbering.num_islands(); ++island) {
    if (!result->add_path(numbering, island, ends)) return nullptr;
  }
  result->finish();
  return result;
}

/// The ends of all rods, row by row, and what else belongs to each.
void PathSweep::read_rods(const Constraints& constraints, std::vector<std::array<Index, 2>>* ends) {
  block_.resize(ends->size());
  const auto read = [&]<bool Timed, bool Shifted>(const Family<RodKernel<Timed, Shifted>>& rods) {
    if (Shifted && rods.size() > 0) offset_.resize(ends->size());
    for (std::size_t k = 0; k < rods.size(); ++k) {
      const auto row = static_cast<std::size_t>(rods.rows[k]);
      (*ends)[row] = rods.kernel.points[k];
      block_[row] = static_cast<std::size_t>(rods.first_block) + k;
      if constexpr (Shifted) offset_[row] = rods.kernel.offset[k];
      if constexpr (Timed) lengths_.emplace_back(row, &rods.kernel.moving_length[k]);
    }
  };
  read(constraints.family<RodKernel<false, false>>());
  read(constraints.family<RodKernel<false, true>>());
  read(constraints.family<RodKernel<true, false>>());
  read(constraints.family<RodKernel<true, true>>());
}

/// False where the island is no path.
bool PathSweep::add_path(const Numbering& numbering, std::size_t island, std::span<const std::array<Index, 2>> ends) {
  const auto num_moving = static_cast<Index>(numbering.num_moving);
  Path path{.first = static_cast<std::size_t>(numbering.island_start[island]),
            .end = static_cast<std::size_t>(numbering.island_start[island + 1]),
            .shift = 0};
  const auto& [i, j] = ends[path.first];
  const Index low = std::min(i, j), high = std::max(i, j),
              last = std::max(ends[path.end - 1][0], ends[path.end - 1][1]);
  if (high >= num_moving) path.left_support = high;
  if (path.end - path.first > 1 && last >= num_moving) path.right_support = last;
  path.shift =
      static_cast<std::ptrdiff_t>(low) - static_cast<std::ptrdiff_t>(path.first) - (high >= num_moving ? 1 : 0);
  for (std::size_t row = path.first; row < path.end; ++row) {
    const auto left = static_cast<Index>(path.left_point(row)), right = static_cast<Index>(path.right_point(row));
    if (ends[row] == std::array{left, right}) {
      sign_.push_back(1);
    } else if (ends[row] == std::array{right, left}) {
      sign_.push_back(-1);
    } else {
      return false;
    }
  }
  paths_.push_back(path);
  return true;
}

void PathSweep::finish() {
  const std::size_t num_rows = sign_.size();
  for (std::size_t row = 0; row < offset_.size(); ++row) offset_[row] = sign_[row] * offset_[row];
  std::sort(lengths_.begin(), lengths_.end());
  first_block_ = block_[0];
  bool follow_rows = true;
  for (std::size_t row = 0; row < num_rows; ++row) follow_rows = follow_rows && block_[row] == first_block_ + row;
  if (follow_rows) block_ = {};

  for (std::vector<double>* array : {&inverse_pivot_, &factor_}) array->resize(num_rows);
  right_factor_.resize(paths_.size());
  const std::size_t least_rows = std::max(rows_worth_a_thread, num_rows / most_groups);
  group_start_.push_back(0);
  for (std::size_t p = 0; p < paths_.size(); ++p) {
    if (paths_[p].end - paths_[group_start_.back()].first >= least_rows) group_start_.push_back(p + 1);
  }
  if (group_start_.back() < paths_.size()) group_start_.push_back(paths_.size());
  range_.resize(group_start_.size() - 1);
  if (paths_.size() <= few_paths) {
    eliminated_.resize(paths_.size());
    accelerated_.resize(paths_.size());
  }

  constexpr double flops_a_row = 5.0;
  summary_ = {.name = "paths",
              .reason = "every island is a path of rods",
              .parts = paths_.size(),
              .pattern_nonzeros = 2 * num_rows - paths_.size(),
              .factor_nonzeros = 2 * num_rows - paths_.size(),
              .flops = flops_a_row * static_cast<double>(num_rows)};
}

// ---- threads: groups of paths, or the halves of a few long ones ----

bool PathSweep::splits(const Parallel& parallel) const {
  return parallel.threads() > 1 && !eliminated_.empty() && sign_.size() >= 2 * rows_worth_a_thread;
}

/// whole(path, range): of all paths.
template <class Whole>
void PathSweep::for_groups(const Parallel& parallel, const Whole& whole) {
  parallel.for_tasks(group_start_.size() - 1, [&](std::size_t group) {
    range_[group] = {};
    for (std::size_t p = group_start_[group]; p < group_start_[group + 1]; ++p) whole(p, &range_[group]);
  });
}

/// of_half(path, half): of all paths.
template <class OfHalf>
void PathSweep::for_halves(const Parallel& parallel, const OfHalf& of_half) const {
  parallel.for_tasks(2 * paths_.size(),
                     [&](std::size_t k) { of_half(k / 2, k % 2 == 0 ? Halves::Left : Halves::Right); });
}

Elimination PathSweep::eliminate(const Parallel& parallel, const Numbers& numbers) {
  Range total;
  if (splits(parallel)) {
    for_halves(parallel, [&](std::size_t p, Halves half) {
      eliminate_halves(paths_[p], numbers, half, &eliminated_[p][0], &eliminated_[p][1]);
    });
    for (std::size_t p = 0; p < paths_.size(); ++p)
      total.include(eliminate_middle(p, numbers, eliminated_[p][0], eliminated_[p][1]));
  } else {
    for_groups(parallel, [&](std::size_t p, Range* range) {
      Eliminated left, right;
      eliminate_halves(paths_[p], numbers, Halves::Both, &left, &right);
      range->include(eliminate_middle(p, numbers, left, right));
    });
    for (const Range& range : range_) total.include(range);
  }
  // Scaled to a unit diagonal, pivots lie between 1/largest and 1.
  const bool is_positive = total.smallest_ratio > 0.0 && total.largest_ratio > 0.0;
  return {.reciprocal_condition = is_positive ? 1.0 / total.largest_ratio : 0.0, .largest_right_side = total.largest};
}

Elimination PathSweep::solve(const Parallel& parallel, const FreeMotion& motion, double* blocks, double* b,
                             double* lambda, double* w) {
  Elimination result = eliminate(parallel, motion, blocks, b, lambda);
  if (result.reciprocal_condition > 0.0) result.residual = substitute(parallel, motion.uniform, blocks, b, lambda, w);
  return result;
}

/// The first sweep; b is eliminated too, in lambda.
Elimination PathSweep::eliminate(const Parallel& parallel, const FreeMotion& motion, double* blocks, double* b,
                                 double* lambda) {
  return eliminate(parallel, Numbers{&motion, blocks, blocks, b, lambda});
}

Elimination PathSweep::factorize(const Parallel& parallel, const double* blocks) {
  return eliminate(parallel, Numbers{nullptr, blocks, nullptr, nullptr, nullptr});
}

double PathSweep::substitute(const Parallel& parallel, const Vec3* uniform, const double* blocks, const double* b,
                             double* lambda, double* w) {
  const Substituted numbers{uniform, blocks, b, lambda, w};
  const auto solve_middle = [&](std::size_t p) {
    const std::size_t middle = paths_[p].middle();
    lambda[middle] *= -inverse_pivot_[middle];
  };
  const auto rest_of_middle = [&](std::size_t p, const Accelerated& left, const Accelerated& right) {
    return larger(larger(left.residual, right.residual), rest_of(numbers, paths_[p].middle(), left.dw, right.dw));
  };
  double worst = 0.0;
  if (splits(parallel)) {
    for (std::size_t p = 0; p < paths_.size(); ++p) solve_middle(p);
    for_halves(parallel, [&](std::size_t p, Halves half) {
      substitute_halves(p, numbers, half, &accelerated_[p][0], &accelerated_[p][1]);
    });
    for (std::size_t p = 0; p < paths_.size(); ++p)
      worst = larger(worst, rest_of_middle(p, accelerated_[p][0], accelerated_[p][1]));
    return worst;
  }
  for_groups(parallel, [&](std::size_t p, Range* range) {
    Accelerated left, right;
    solve_middle(p);
    substitute_halves(p, numbers, Halves::Both, &left, &right);
    range->largest = larger(range->largest, rest_of_middle(p, left, right));
  });
  for (const Range& range : range_) worst = larger(worst, range.largest);
  return worst;
}

void PathSweep::solve_negative(const Parallel& parallel, const double* b, double* x) {
  using paths::BackSubstitution, paths::Substitution;
  const double *const d = inverse_pivot_.data(), *const f = factor_.data();
  const auto inwards = [&](std::size_t p, Halves halves) {
    const std::size_t first = paths_[p].first, end = paths_[p].end, middle = paths_[p].middle();
    Substitution left{b + first, f + first, x + first, includes(halves, Halves::Left) ? middle - first : 0, 0.0};
    Substitution right{b + middle + 1, f + middle + 1, x + middle + 1,
                       includes(halves, Halves::Right) ? end - middle - 1 : 0, 0.0};
    paths::substitute_inwards(&left, &right);
  };
  const auto solve_middle = [&](std::size_t p) {
    const std::size_t first = paths_[p].first, end = paths_[p].end, middle = paths_[p].middle();
    double y = b[middle];
    if (middle > first) y -= f[middle] * x[middle - 1];
    if (middle + 1 < end) y -= right_factor_[p] * x[middle + 1];
    x[middle] = -y * d[middle];
  };
  const auto outwards = [&](std::size_t p, Halves halves) {
    const std::size_t first = paths_[p].first, end = paths_[p].end, middle = paths_[p].middle();
    BackSubstitution left{d + first, f + first, x + first, includes(halves, Halves::Left) ? middle - first : 0,
                          f[middle], x[middle]};
    BackSubstitution right{d + middle + 1,   f + middle + 1,
                           x + middle + 1,   includes(halves, Halves::Right) ? end - middle - 1 : 0,
                           right_factor_[p], x[middle]};
    paths::substitute_outwards(&left, &right);
  };
  if (splits(parallel)) {
    for_halves(parallel, inwards);
    for (std::size_t p = 0; p < paths_.size(); ++p) solve_middle(p);
    for_halves(parallel, outwards);
    return;
  }
  for_groups(parallel, [&](std::size_t p, Range*) {
    inwards(p, Halves::Both);
    solve_middle(p);
    outwards(p, Halves::Both);
  });
}

}  // namespace tanor
