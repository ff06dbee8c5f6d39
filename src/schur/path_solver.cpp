#include "schur/path_solver.hpp"

#include <algorithm>

#include "plan/thresholds.hpp"

/// \file Which systems are paths, and which thread takes what; the passes themselves are in path_halves.cpp,
/// what closes a ring in path_rings.cpp.
namespace tanor {

void PathSolver::Range::include(const Range& other) {
  smallest_ratio = std::min(smallest_ratio, other.smallest_ratio);
  largest_ratio = larger(largest_ratio, other.largest_ratio);
  right_side = larger(right_side, other.right_side);
  residual = larger(residual, other.residual);
  own_residual = larger(own_residual, other.own_residual);
}

std::unique_ptr<PathSolver> PathSolver::make(const SchurProblem& problem, std::vector<Index>* islands) {
  if (islands->empty()) return nullptr;
  const Numbering& numbering = problem.numbering;
  const std::vector<Index> before = *islands;
  std::unique_ptr<PathSolver> result(new PathSolver);
  result->inverse_mass_ = problem.inverse_mass;
  RodRows rods(problem.constraints, numbering.num_rows());
  result->sign_.assign(numbering.num_rows(), 1);
  std::erase_if(*islands, [&](Index island) {
    const std::optional<Path> path = find_path(rods.ends, numbering, island);
    if (!path) return false;
    for (std::size_t row = path->first; row < path->first + path->num_rows(); ++row)
      result->sign_[row] = rods.ends[row][0] == static_cast<Index>(path->left_point(row)) ? 1 : -1;
    result->paths_.push_back(*path);
    return true;
  });
  if (result->paths_.empty()) return nullptr;
  result->block_ = std::move(rods.block);
  result->offset_ = std::move(rods.offset);
  result->length_ = std::move(rods.constant_length);
  result->lengths_ = std::move(rods.lengths);
  result->finish();
  result->serve(problem, before, *islands);
  return result;
}

void PathSolver::finish() {
  const std::size_t num_rows = sign_.size();
  for (std::size_t row = 0; row < offset_.size(); ++row) offset_[row] = sign_[row] * offset_[row];
  first_block_ = block_[0];
  bool follow_rows = true;
  for (std::size_t row = 0; row < num_rows; ++row) follow_rows = follow_rows && block_[row] == first_block_ + row;
  if (follow_rows) block_ = {};

  for (std::vector<double>* array : {&inverse_pivot_, &factor_}) array->resize(num_rows);
  right_factor_.resize(paths_.size());
  const auto num_rings = static_cast<std::size_t>(
      std::count_if(paths_.begin(), paths_.end(), [](const Path& path) { return path.is_ring; }));
  if (num_rings > 0) spike_.resize(num_rows);
  group_start_ = group_islands(paths_.size(), num_rows, [&](std::size_t p) { return paths_[p].num_rows(); });
  work_.resize(std::max(group_start_.size() - 1, std::min(paths_.size(), plan::few_paths)));

  constexpr double flops_a_row = 5.0, flops_a_spike = 7.0;
  const auto count = [](std::size_t number, const std::string& what) {
    return number == 1 ? "one " + what + " of rods" : std::to_string(number) + " " + what + "s of rods";
  };
  const std::size_t num_open = paths_.size() - num_rings;
  summary_ = {.solvers = {LinearSolver::Paths},
              .reason = (num_open > 0 ? count(num_open, "path") : "") + (num_open * num_rings > 0 ? ", " : "") +
                        (num_rings > 0 ? count(num_rings, "ring") : ""),
              .parts = paths_.size()};
  for (const Path& path : paths_) {
    const std::size_t rows = path.num_rows(), in_spike = path.is_ring ? rows - 3 : 0;  // the others are couplings
    summary_.pattern_nonzeros += path.is_ring ? 2 * rows : 2 * rows - 1;
    summary_.factor_nonzeros += (path.is_ring ? 2 * rows : 2 * rows - 1) + in_spike;
    summary_.flops += flops_a_row * static_cast<double>(rows) + flops_a_spike * static_cast<double>(in_spike);
  }
}

// ---- what all calls have in common: inwards over both halves, the row in the middle, and outwards again ----

/// Groups of paths, or the halves of a few long ones, go to the threads. `inwards(p, halves, work)`, `middle(p, work)`,
/// `outwards(p, halves, work)` and `finish(p, work)` of each path, in this order.
template <class Inwards, class Middle, class Outwards, class Finish>
PathSolver::Range PathSolver::run(const Parallel& parallel, const Inwards& inwards, const Middle& middle,
                                  const Outwards& outwards, const Finish& finish) {
  Range total;
  const bool splits =
      parallel.threads() > 1 && paths_.size() <= plan::few_paths && sign_.size() >= 2 * plan::rows_worth_a_thread;
  if (splits) {
    const auto for_halves = [&](const auto& of_half) {
      parallel.for_tasks(2 * paths_.size(), [&](std::size_t k) {
        of_half(k / 2, k % 2 == 0 ? Halves::Left : Halves::Right, &work_[k / 2]);
      });
    };
    for_halves(inwards);
    for (std::size_t p = 0; p < paths_.size(); ++p) middle(p, &work_[p]);
    for_halves(outwards);
    for (std::size_t p = 0; p < paths_.size(); ++p) {
      finish(p, &work_[p]);
      total.include(work_[p].range);
    }
    return total;
  }
  const std::size_t num_groups = group_start_.size() - 1;
  parallel.for_tasks(num_groups, [&](std::size_t group) {
    Work& work = work_[group];
    Range range;
    for (std::size_t p = group_start_[group]; p < group_start_[group + 1]; ++p) {
      inwards(p, Halves::Both, &work);
      middle(p, &work);
      outwards(p, Halves::Both, &work);
      finish(p, &work);
      range.include(work.range);
    }
    work.range = range;
  });
  for (std::size_t group = 0; group < num_groups; ++group) total.include(work_[group].range);
  return total;
}

/// Scaled to a unit diagonal, pivots lie between 1/largest_ratio and 1.
double PathSolver::Range::reciprocal_condition() const {
  return smallest_ratio > 0.0 && largest_ratio > 0.0 ? 1.0 / largest_ratio : 0.0;
}

Elimination PathSolver::solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks,
                              double* b, double* lambda, double* w) {
  const Substituted substituted{motion.uniform, blocks, b, lambda, w};
  const auto substitute = [&](std::size_t p, Halves halves, Work* work) {
    substitute_halves(p, substituted, lambda, halves, work);
  };
  const auto finish = [&](std::size_t p, Work* work) { include_residual(p, substituted, work); };
  if (use == FactorUse::Renew) {
    const Numbers numbers{&motion, blocks, blocks, b, lambda, source_of_halves(parallel, motion)};
    const Range range = run(
        parallel, [&](std::size_t p, Halves halves, Work* work) { eliminate_halves(paths_[p], numbers, halves, work); },
        [&](std::size_t p, Work* work) {
          eliminate_middle(p, numbers, work);
          start_outwards(p, lambda);
        },
        substitute, finish);
    return {range.reciprocal_condition(), range.right_side, range.residual, range.own_residual};
  }
  bring_points(parallel, motion.source);
  const double largest = evaluate_right_side(parallel, motion, b);
  const Range range = run(
      parallel,
      [&](std::size_t p, Halves halves, Work* work) { eliminate_right_side(paths_[p], halves, b, lambda, work); },
      [&](std::size_t p, Work* work) {
        work->range = {};
        eliminate_middle_of(p, b, lambda, *work);
      },
      substitute, finish);
  return {.largest_right_side = largest, .residual = range.residual, .own_residual = cannot_tell};
}

/// The row that closes a ring is seen by both halves: where there are rings all points are brought before.
const PointSource* PathSolver::source_of_halves(const Parallel& parallel, const FreeMotion& motion) const {
  if (spike_.empty()) return motion.source;
  bring_points(parallel, motion.source);
  return nullptr;
}

/// |K'dw + b| of a whole path.
void PathSolver::include_residual(std::size_t p, const Substituted& numbers, Work* work) const {
  const Path& path = paths_[p];
  double& residual = work->range.residual;
  residual = larger(larger(work->left.residual, work->right.residual),
                    rest_of(numbers, path.middle(), work->left.dw, work->right.dw));
  if (path.is_ring)
    residual = larger(residual, rest_of(numbers, path.closing_row(), work->right.end_dw, work->left.end_dw));
  work->range.own_residual = own_residual(residual, work->range.right_side);
}

Elimination PathSolver::factorize(const Parallel& parallel, const double* blocks) {
  return eliminate(parallel, {nullptr, blocks, nullptr, nullptr, nullptr});
}

Elimination PathSolver::linearise(const Parallel& parallel, const double* r, const PointSource* source,
                                  double* blocks) {
  const FreeMotion motion{.r = r, .v = nullptr, .w0 = nullptr, .source = source};
  return eliminate(parallel, {&motion, blocks, blocks, nullptr, nullptr, source_of_halves(parallel, motion)});
}

Elimination PathSolver::eliminate(const Parallel& parallel, const Numbers& numbers) {
  const Range range = run(
      parallel, [&](std::size_t p, Halves halves, Work* work) { eliminate_halves(paths_[p], numbers, halves, work); },
      [&](std::size_t p, Work* work) { eliminate_middle(p, numbers, work); }, [](auto...) {}, [](auto...) {});
  return {.reciprocal_condition = range.reciprocal_condition()};
}

void PathSolver::solve_negative(const Parallel& parallel, const double* b, double* x) {
  (void)run(
      parallel, [&](std::size_t p, Halves halves, Work* work) { eliminate_right_side(paths_[p], halves, b, x, work); },
      [&](std::size_t p, Work* work) { eliminate_middle_of(p, b, x, *work); },
      [&](std::size_t p, Halves halves, Work*) { substitute_right_side(p, halves, x); }, [](auto...) {});
}

void PathSolver::correct(const Parallel& parallel, const double* blocks, double* rows, double* points) {
  const Substituted numbers{nullptr, blocks, nullptr, rows, points};
  (void)run(
      parallel,
      [&](std::size_t p, Halves halves, Work* work) { eliminate_right_side(paths_[p], halves, rows, rows, work); },
      [&](std::size_t p, Work* work) { eliminate_middle_of(p, rows, rows, *work); },
      [&](std::size_t p, Halves halves, Work* work) { substitute_halves(p, numbers, rows, halves, work); },
      [](auto...) {});
}

// ---- projections: many paths one by one, each of which stays in the cache from its first iteration to its last ----

/// Threads may have to share each of them.
bool PathSolver::are_few() const {
  return paths_.size() <= plan::few_paths;
}

/// begin(path), then evaluate(path, rows := what violates it) -> the largest, points += M^-1 K S^-1 (-rows).
template <class Begin, class Evaluate>
Projection PathSolver::project(const Parallel& parallel, double target, const Begin& begin, const Evaluate& evaluate,
                               const double* blocks, double* points, double* sum) {
  double* const rows = scratch_rows();
  const auto include = [](const Projection& found, Projection* all) {
    all->violation = larger(all->violation, found.violation);
    all->iterations = std::max(all->iterations, found.iterations);
  };
  const std::size_t num_groups = group_start_.size() - 1;
  parallel.for_tasks(num_groups, [&](std::size_t group) {
    Work& work = work_[group];
    work.projection = {};
    for (std::size_t p = group_start_[group]; p < group_start_[group + 1]; ++p) {
      const Path& path = paths_[p];
      begin(path);
      const Projection found = iterate_along_chord(
          target, [&] { return evaluate(path, rows); },
          [&] {
            correct_path(p, blocks, rows, points, &work);
            for (std::size_t a = path.first; sum != nullptr && a < path.first + path.num_rows(); ++a) sum[a] += rows[a];
          });
      include(found, &work.projection);
    }
  });
  Projection all;
  for (std::size_t group = 0; group < num_groups; ++group) include(work_[group].projection, &all);
  return all;
}

Projection PathSolver::project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                                         const PointSource* source, double* sum) {
  if (are_few()) return IslandSolver::project_positions(parallel, blocks, target, r, source, sum);
  take_lengths();
  const auto begin = [&](const Path& path) {
    if (source != nullptr) source->bring(path.first_point(), path.end_point() - path.first_point());
    if (sum != nullptr) add_reactions_of(path, {nullptr, blocks, nullptr, sum, r});
  };
  const auto evaluate = [&](const Path& path, double* xi) {
    return find_values(path.first, path.first + path.num_rows(), r, xi);
  };
  return project(parallel, target, begin, evaluate, blocks, r, sum);
}

Projection PathSolver::project_velocities(const Parallel& parallel, const double* blocks, double target,
                                          const double* r, double* v, double* sum) {
  if (are_few()) return IslandSolver::project_velocities(parallel, blocks, target, r, v, sum);
  const auto evaluate = [&](const Path& path, double* rates) {
    return find_rates(path.first, path.first + path.num_rows(), r, v, rates);
  };
  return project(
      parallel, target, [](const Path&) {}, evaluate, blocks, v, sum);
}

void PathSolver::add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) {
  if (are_few()) return IslandSolver::add_reactions(parallel, blocks, rows, points);
  parallel.for_tasks(group_start_.size() - 1, [&](std::size_t group) {
    for (std::size_t p = group_start_[group]; p < group_start_[group + 1]; ++p)
      add_reactions_of(paths_[p], {nullptr, blocks, nullptr, rows, points});
  });
}

void PathSolver::correct_path(std::size_t p, const double* blocks, double* rows, double* points, Work* work) const {
  eliminate_right_side(paths_[p], Halves::Both, rows, rows, work);
  eliminate_middle_of(p, rows, rows, *work);
  substitute_halves(p, {nullptr, blocks, nullptr, rows, points}, rows, Halves::Both, work);
}

/// w += M^-1 K lambda
void PathSolver::add_reactions_of(const Path& path, const Substituted& numbers) const {
  double nothing = 0.0;
  for (std::size_t row = path.first; row + 1 < path.end; row += paths::chunk_size)
    (void)accelerate(path, numbers, row, std::min(paths::chunk_size, path.end - 1 - row), &nothing);
  if (path.left_support < 0) (void)accelerate_end(path, numbers, path.first, path.left_point(path.first), -1.0);
  if (path.right_support < 0) (void)accelerate_end(path, numbers, path.end - 1, path.right_point(path.end - 1), 1.0);
}

// ---- one more right side ----

void PathSolver::eliminate_right_side(const Path& path, Halves halves, const double* b, double* y, Work* work) const {
  const double* const f = factor_.data();
  const std::size_t first = path.first, after = path.middle() + 1;
  const std::size_t num_left = includes(halves, Halves::Left) ? path.middle() - first : 0;
  const std::size_t num_right = includes(halves, Halves::Right) ? path.end - after : 0;
  paths::Substitution left{b + first, f + first, y + first, num_left, 0.0};
  paths::Substitution right{b + after, f + after, y + after, num_right, 0.0};
  paths::substitute_inwards(&left, &right);
  if (!path.is_ring) return;
  const auto sum = [&](std::size_t begin, std::size_t count) {
    return paths::sum_of_products(spike_.data() + begin, y + begin, inverse_pivot_.data() + begin, count);
  };
  if (includes(halves, Halves::Left)) work->left_end.closing_y = sum(first, num_left);
  if (includes(halves, Halves::Right)) work->right_end.closing_y = sum(after, num_right);
}

void PathSolver::eliminate_middle_of(std::size_t p, const double* b, double* y, const Work& work) const {
  const std::size_t middle = paths_[p].middle();
  double y_middle = b[middle];
  if (middle > paths_[p].first) y_middle -= factor_[middle] * y[middle - 1];
  if (middle + 1 < paths_[p].end) y_middle -= right_factor_[p] * y[middle + 1];
  y[middle] = y_middle;
  if (paths_[p].is_ring) eliminate_closing_row_of(paths_[p], b, y, work);
  start_outwards(p, y);
}

/// The closing row is the first one that is known; y := y + spike lambda of it is what the path is left with.
void PathSolver::start_outwards(std::size_t p, double* y) const {
  const Path& path = paths_[p];
  const std::size_t middle = path.middle();
  if (path.is_ring) {
    double& lambda = y[path.closing_row()];
    lambda *= -inverse_pivot_[path.closing_row()];
    y[middle] += lambda * spike_[middle];
  }
  y[middle] *= -inverse_pivot_[middle];
}

void PathSolver::substitute_right_side(std::size_t p, Halves halves, double* y) const {
  const double *const d = inverse_pivot_.data(), *const f = factor_.data();
  const std::size_t first = paths_[p].first, middle = paths_[p].middle(), after = middle + 1;
  const std::size_t num_left = includes(halves, Halves::Left) ? middle - first : 0;
  const std::size_t num_right = includes(halves, Halves::Right) ? paths_[p].end - after : 0;
  if (paths_[p].is_ring) {
    const double lambda = y[paths_[p].closing_row()];
    paths::add(lambda, spike_.data() + first, num_left, y + first);
    paths::add(lambda, spike_.data() + after, num_right, y + after);
  }
  paths::BackSubstitution left{d + first, f + first, y + first, num_left, f[middle], y[middle]};
  paths::BackSubstitution right{d + after, f + after, y + after, num_right, right_factor_[p], y[middle]};
  paths::Upcoming nothing;
  paths::substitute_outwards(&left, &right, &nothing);
}

}  // namespace tanor
