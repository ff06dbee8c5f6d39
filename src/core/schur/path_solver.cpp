#include "schur/path_solver.hpp"

#include <algorithm>

#include "plan/thresholds.hpp"

/// \file The distribution of paths to threads. The passes themselves are in path_factor.cpp.
namespace tanor::detail {

using paths::Sides, paths::PathWork;

namespace {

const Parallel alone(1);  // a path of many stays with one thread

}  // namespace

std::unique_ptr<PathSolver> PathSolver::make(const SchurProblem& problem, std::vector<Index>* islands) {
  if (islands->empty()) return nullptr;
  const std::vector<Index> before = *islands;
  PathRows rows(problem, islands);
  if (rows.paths.empty()) return nullptr;
  std::unique_ptr<PathSolver> result(new PathSolver(std::move(rows)));
  result->serve(problem, before, *islands);
  return result;
}

PathSolver::PathSolver(PathRows rows)
    : rows_(std::move(rows)),
      factor_(rows_),
      group_start_(group_islands(rows_.paths.size(), rows_.num_rows(),
                                 [&](std::size_t p) { return rows_.paths[p].num_rows(); })),
      work_(std::max(group_start_.size() - 1, std::min(rows_.paths.size(), plan::few_paths))) {
  summarize();
}

void PathSolver::summarize() {
  constexpr double flops_a_row = 5.0, flops_a_spike = 7.0;
  const auto count = [](std::size_t number, const std::string& what) {
    return number == 1 ? "one " + what + " of rods" : std::to_string(number) + " " + what + "s of rods";
  };
  const std::size_t num_rings = rows_.num_rings, num_open = rows_.paths.size() - num_rings;
  summary_ = {.solvers = {LinearSolver::Paths},
              .reason = (num_open > 0 ? count(num_open, "path") : "") + (num_open * num_rings > 0 ? ", " : "") +
                        (num_rings > 0 ? count(num_rings, "ring") : ""),
              .factor = {.parts = rows_.paths.size()}};
  for (const RodPath& path : rows_.paths) {
    const std::size_t rows = path.num_rows(), in_spike = path.is_ring ? rows - 3 : 0;  // the others are couplings
    summary_.factor.pattern_nonzeros += path.is_ring ? 2 * rows : 2 * rows - 1;
    summary_.factor.factor_nonzeros += (path.is_ring ? 2 * rows : 2 * rows - 1) + in_spike;
    summary_.factor.flops += flops_a_row * static_cast<double>(rows) + flops_a_spike * static_cast<double>(in_spike);
  }
}

// ---- what all calls have in common: forward from both ends, the row in the middle, and backward to both ends ----

/// Runs the passes: groups of paths, or the halves of a few long ones, go to the threads. For each path it calls
/// `forward(p, sides, work)`, `middle(p, work)`, `backward(p, sides, work)` and `finish(p, work)`, in this order.
template <class Forward, class Middle, class Backward, class Finish>
paths::Findings PathSolver::run(const Parallel& parallel, const Forward& forward, const Middle& middle,
                                const Backward& backward, const Finish& finish) {
  paths::Findings total;
  const bool splits = parallel.threads() > 1 && rows_.paths.size() <= plan::few_paths &&
                      rows_.num_rows() >= 2 * plan::rows_worth_a_thread;
  if (splits) {
    const auto for_ends = [&](const auto& of_end) {
      parallel.for_tasks(2 * rows_.paths.size(),
                         [&](std::size_t k) { of_end(k / 2, k % 2 == 0 ? Sides::Left : Sides::Right, &work_[k / 2]); });
    };
    for_ends(forward);
    for (std::size_t p = 0; p < rows_.paths.size(); ++p) middle(p, &work_[p]);
    for_ends(backward);
    for (std::size_t p = 0; p < rows_.paths.size(); ++p) {
      finish(p, &work_[p]);
      total.include(work_[p].findings);
    }
    return total;
  }
  const std::size_t num_groups = group_start_.size() - 1;
  parallel.for_tasks(num_groups, [&](std::size_t group) {
    PathWork& work = work_[group];
    paths::Findings findings;
    for (std::size_t p = group_start_[group]; p < group_start_[group + 1]; ++p) {
      forward(p, Sides::Both, &work);
      middle(p, &work);
      backward(p, Sides::Both, &work);
      finish(p, &work);
      findings.include(work.findings);
    }
    work.findings = findings;
  });
  for (std::size_t group = 0; group < num_groups; ++group) total.include(work_[group].findings);
  return total;
}

Elimination PathSolver::solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks,
                              double* b, double* lambda, double* w) {
  const PathReactions reactions{rows_, motion.uniform, blocks, b, lambda, w};
  const auto substitute = [&](std::size_t p, Sides sides, PathWork* work) {
    factor_.substitute_and_accelerate(p, reactions, lambda, sides, work);
  };
  const auto finish = [&](std::size_t p, PathWork* work) { reactions.include_residual(rows_.paths[p], work); };
  if (use == FactorUse::Renew) {
    const PathEquations equations{rows_, &motion, blocks, blocks, b, lambda, source_of_sides(parallel, motion)};
    const paths::Findings found = run(
        parallel,
        [&](std::size_t p, Sides sides, PathWork* work) { factor_.eliminate_from_ends(p, equations, sides, work); },
        [&](std::size_t p, PathWork* work) {
          factor_.eliminate_middle(p, equations, work);
          factor_.begin_backward(p, lambda);
        },
        substitute, finish);
    return {found.reciprocal_condition(), found.right_side, found.residual, found.own_residual};
  }
  bring_points(parallel, motion.source);
  const double largest = rows_.largest_of_ranges(
      parallel, [&](std::size_t begin, std::size_t end) { return rows_.find_right_sides(begin, end, motion, b); });
  const paths::Findings found = run(
      parallel,
      [&](std::size_t p, Sides sides, PathWork* work) { factor_.substitute_forward(p, sides, b, lambda, work); },
      [&](std::size_t p, PathWork* work) {
        work->findings = {};
        factor_.substitute_middle(p, b, lambda, *work);
      },
      substitute, finish);
  return {.largest_right_side = largest, .residual = found.residual, .own_residual = cannot_tell};
}

/// Returns the source for the halves. Both see the row that closes a ring, so with rings all points are brought here.
const PointSource* PathSolver::source_of_sides(const Parallel& parallel, const FreeMotion& motion) const {
  if (rows_.num_rings == 0) return motion.source;
  bring_points(parallel, motion.source);
  return nullptr;
}

Elimination PathSolver::factorize(const Parallel& parallel, const double* blocks) {
  return eliminate(parallel, {rows_, nullptr, blocks, nullptr, nullptr, nullptr});
}

Elimination PathSolver::linearise(const Parallel& parallel, const double* r, const PointSource* source,
                                  double* blocks) {
  const FreeMotion motion{.r = r, .v = nullptr, .w0 = nullptr, .source = source};
  return eliminate(parallel, {rows_, &motion, blocks, blocks, nullptr, nullptr, source_of_sides(parallel, motion)});
}

Elimination PathSolver::eliminate(const Parallel& parallel, const PathEquations& equations) {
  const paths::Findings found = run(
      parallel,
      [&](std::size_t p, Sides sides, PathWork* work) { factor_.eliminate_from_ends(p, equations, sides, work); },
      [&](std::size_t p, PathWork* work) { factor_.eliminate_middle(p, equations, work); }, [](auto...) {},
      [](auto...) {});
  return {.reciprocal_condition = found.reciprocal_condition()};
}

/// Computes x = -S^-1 b up to the middle rows, then calls `backward(p, sides, work)`.
template <class Backward>
void PathSolver::substitute(const Parallel& parallel, const double* b, double* x, const Backward& backward) {
  (void)run(
      parallel, [&](std::size_t p, Sides sides, PathWork* work) { factor_.substitute_forward(p, sides, b, x, work); },
      [&](std::size_t p, PathWork* work) { factor_.substitute_middle(p, b, x, *work); }, backward, [](auto...) {});
}

void PathSolver::solve_negative(const Parallel& parallel, const double* b, double* x) {
  substitute(parallel, b, x, [&](std::size_t p, Sides sides, PathWork*) { factor_.substitute_backward(p, sides, x); });
}

void PathSolver::correct(const Parallel& parallel, const double* blocks, double* rows, double* points) {
  const PathReactions reactions{rows_, nullptr, blocks, nullptr, rows, points};
  substitute(parallel, rows, rows, [&](std::size_t p, Sides sides, PathWork* work) {
    factor_.substitute_and_accelerate(p, reactions, rows, sides, work);
  });
}

double PathSolver::evaluate_values(const Parallel& parallel, const double* r, double* xi) {
  rows_.take_lengths();
  return rows_.largest_of_ranges(
      parallel, [&](std::size_t begin, std::size_t end) { return rows_.find_values(begin, end, r, xi); });
}

double PathSolver::evaluate_rates(const Parallel& parallel, const double* r, const double* v, double* rates) {
  return rows_.largest_of_ranges(
      parallel, [&](std::size_t begin, std::size_t end) { return rows_.find_rates(begin, end, r, v, rates); });
}

// ---- projections: many paths one by one, each of which stays in the cache from its first iteration to its last ----

/// Returns true if there are so few paths that threads may have to share each of them.
bool PathSolver::are_few() const {
  return rows_.paths.size() <= plan::few_paths;
}

/// Calls begin(path), then iterates with evaluate(path, rows := violations), which returns the largest one, and points
/// += M^-1 K S^-1 (-rows).
template <class Begin, class Evaluate>
Projection PathSolver::project(const Parallel& parallel, double target, const Begin& begin, const Evaluate& evaluate,
                               const double* blocks, double* points, double* sum) {
  double* const rows = scratch_rows();
  const PathReactions reactions{rows_, nullptr, blocks, nullptr, rows, points};
  const auto correct_path = [&](std::size_t p, PathWork* work) {
    factor_.substitute_forward(p, Sides::Both, rows, rows, work);
    factor_.substitute_middle(p, rows, rows, *work);
    factor_.substitute_and_accelerate(p, reactions, rows, Sides::Both, work);
  };
  const auto include = [](const Projection& found, Projection* all) {
    all->violation = larger(all->violation, found.violation);
    all->iterations = std::max(all->iterations, found.iterations);
  };
  const std::size_t num_groups = group_start_.size() - 1;
  parallel.for_tasks(num_groups, [&](std::size_t group) {
    PathWork& work = work_[group];
    work.projection = {};
    for (std::size_t p = group_start_[group]; p < group_start_[group + 1]; ++p) {
      const RodPath& path = rows_.paths[p];
      begin(path);
      const Projection found = iterate_along_chord(
          target, [&] { return evaluate(path, rows); },
          [&] {
            correct_path(p, &work);
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
  rows_.take_lengths();
  const auto begin = [&](const RodPath& path) {
    if (source != nullptr) source->bring(path.first_point(), path.end_point() - path.first_point());
    if (sum != nullptr) PathReactions{rows_, nullptr, blocks, nullptr, sum, r}.accelerate_all(alone, path);
  };
  const auto evaluate = [&](const RodPath& path, double* xi) {
    return rows_.find_values(path.first, path.first + path.num_rows(), r, xi);
  };
  return project(parallel, target, begin, evaluate, blocks, r, sum);
}

Projection PathSolver::project_velocities(const Parallel& parallel, const double* blocks, double target,
                                          const double* r, double* v, double* sum) {
  if (are_few()) return IslandSolver::project_velocities(parallel, blocks, target, r, v, sum);
  const auto evaluate = [&](const RodPath& path, double* rates) {
    return rows_.find_rates(path.first, path.first + path.num_rows(), r, v, rates);
  };
  return project(
      parallel, target, [](const RodPath&) {}, evaluate, blocks, v, sum);
}

void PathSolver::add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) {
  const PathReactions reactions{rows_, nullptr, blocks, nullptr, rows, points};
  if (are_few()) {
    for (const RodPath& path : rows_.paths) reactions.accelerate_all(parallel, path);
    return;
  }
  parallel.for_tasks(group_start_.size() - 1, [&](std::size_t group) {
    for (std::size_t p = group_start_[group]; p < group_start_[group + 1]; ++p)
      reactions.accelerate_all(alone, rows_.paths[p]);
  });
}

}  // namespace tanor::detail
