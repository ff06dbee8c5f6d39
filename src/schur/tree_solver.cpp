#include "schur/tree_solver.hpp"

#include <algorithm>
#include <utility>

#include "plan/thresholds.hpp"
#include "schur/tree_lanes.hpp"

namespace tanor {

// ---- the plan ----

std::unique_ptr<TreeSolver> TreeSolver::make(const SchurProblem& problem, int threads, bool eagerly,
                                             std::vector<Index>* islands) {
  if (islands->empty()) return nullptr;
  const std::vector<Index> before = *islands;
  const RodRows rods(problem.constraints, problem.numbering.num_rows());
  std::vector<RodTree> trees;
  std::vector<Index> numbers;
  for (const Index island : before) {
    std::optional<RodTree> tree = RodTree::read(rods, problem.numbering, island);
    if (!tree.has_value()) continue;
    trees.push_back(std::move(*tree));
    numbers.push_back(island);
  }
  EqualBranches branches(trees);
  if (!eagerly) {
    std::size_t kept = 0;
    for (std::size_t tree = 0; tree < trees.size(); ++tree) {
      if (branches.share_in_lanes(tree) < plan::share_of_tree_in_lanes) continue;
      std::swap(trees[kept], trees[tree]);
      numbers[kept++] = numbers[tree];
    }
    const bool keeps_all = kept == trees.size();
    trees.resize(kept);
    numbers.resize(kept);
    if (!keeps_all) branches = EqualBranches(trees);
  }
  if (trees.empty()) return nullptr;
  std::unique_ptr<TreeSolver> result(new TreeSolver(problem, rods, trees, std::move(branches), threads));
  std::erase_if(*islands, [&](Index island) { return std::ranges::binary_search(numbers, island); });
  result->serve(problem, before, *islands);
  return result;
}

TreeSolver::TreeSolver(const SchurProblem& problem, const RodRows& rods, std::span<const RodTree> trees,
                       EqualBranches branches, int threads)
    : branches_(std::move(branches), rods, problem.inverse_mass, threads),
      trunks_(trees, branches_.plan(), rods, problem.inverse_mass, problem.numbering.num_moving),
      points_(problem.inverse_mass.size()),
      group_start_(group_islands(trunks_.size(), trunks_.num_rods(),
                                 [&](std::size_t trunk) { return trunks_.num_rods_of(trunk); })),
      found_(group_start_.size() - 1) {
  summarize();
}

void TreeSolver::summarize() {
  constexpr double flops_a_rod = 50.0;
  const std::size_t in_lanes = branches_.num_rods(), num_rods = trunks_.num_rods() + in_lanes;
  summary_ = {.solvers = {LinearSolver::Trees},
              .reason = (trunks_.size() == 1 ? "one tree" : std::to_string(trunks_.size()) + " trees") + " of rods, " +
                        std::to_string(in_lanes) + " of " + std::to_string(num_rods) + " rods in equal branches",
              .parts = trunks_.size(),
              .pattern_nonzeros = 4 * num_rods,
              .factor_nonzeros = 4 * num_rods,
              .flops = flops_a_rod * static_cast<double>(num_rods)};
}

/// Calls work(trunk, found) for each trunk; each thread takes some.
template <class Work>
void TreeSolver::for_each_trunk(const Parallel& parallel, const Work& work) {
  parallel.for_tasks(found_.size(), [&](std::size_t group) {
    for (std::size_t k = group_start_[group]; k < group_start_[group + 1]; ++k) work(k, &found_[group]);
  });
}

void TreeSolver::forget_findings() {
  std::ranges::fill(found_, TreeFindings{});
  branches_.forget_findings();
}

Elimination TreeSolver::found() const {
  TreeFindings all;
  for (const TreeFindings& found : found_) all.include(found);
  all.largest_inverse.see(branches_.largest_inverse().value);
  return {1.0 / all.largest_inverse.value, all.right_side, all.residual, all.own_residual};
}

// ---- the calls: up along branches, up and down along trunks, down along branches ----

Elimination TreeSolver::solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks,
                              double* b, double* lambda, double* w) {
  forget_findings();
  bring_points(parallel, motion.source);
  trunks_.take_lengths();
  branches_.for_each_batch(parallel, &points_, [&](TreeBranches::Lanes lanes) {
    const trees::BranchMotion own = lanes.read_motion(motion);
    if (use == FactorUse::Renew) {
      lanes.evaluate_and_eliminate(own);
      lanes.hand_over_mobilities();
      lanes.write_directions(blocks);
    } else {
      lanes.evaluate(own);
      lanes.substitute_up();
    }
    lanes.hand_over_answers();
  });
  for_each_trunk(parallel, [&](std::size_t trunk, TreeFindings* found) {
    trunks_.solve_up(trunk, motion, use, blocks, b, &points_, lambda, found);
    trunks_.substitute_down(trunk, &points_, lambda);
  });
  branches_.for_each_batch(parallel, &points_, [&](TreeBranches::Lanes lanes) {
    lanes.substitute_down();
    lanes.find_residual();
    lanes.write_multipliers(lambda);
    motion.uniform != nullptr ? lanes.write_accelerations(*motion.uniform, w) : lanes.add_accelerations(w);
  });
  for_each_trunk(parallel, [&](std::size_t trunk, TreeFindings* found) {
    trunks_.accelerate(trunk, points_, motion.uniform, w);
    trunks_.find_residual(trunk, points_, b, branches_, found);
  });
  return found();
}

Elimination TreeSolver::factorize(const Parallel& parallel, const double* blocks) {
  forget_findings();
  branches_.for_each_batch(parallel, &points_, [&](TreeBranches::Lanes lanes) {
    lanes.read_directions(blocks);
    lanes.eliminate();
    lanes.hand_over_mobilities();
  });
  for_each_trunk(parallel, [&](std::size_t trunk, TreeFindings* found) {
    trunks_.read_directions(trunk, blocks);
    trunks_.eliminate(trunk, &points_, found);
  });
  return {.reciprocal_condition = found().reciprocal_condition};
}

/// Computes x := -S^-1 b, then calls finish(lanes) for each batch, with dw in its lanes.
template <class Finish>
void TreeSolver::substitute(const Parallel& parallel, const double* b, double* x, const Finish& finish) {
  branches_.for_each_batch(parallel, &points_, [&](TreeBranches::Lanes lanes) {
    lanes.read_right_side(b);
    lanes.substitute_up();
    lanes.hand_over_answers();
  });
  for_each_trunk(parallel, [&](std::size_t trunk, TreeFindings*) {
    trunks_.substitute_up(trunk, b, &points_, x);
    trunks_.substitute_down(trunk, &points_, x);
  });
  branches_.for_each_batch(parallel, &points_, [&](TreeBranches::Lanes lanes) {
    lanes.substitute_down();
    lanes.write_multipliers(x);
    finish(lanes);
  });
}

void TreeSolver::solve_negative(const Parallel& parallel, const double* b, double* x) {
  substitute(parallel, b, x, [](const TreeBranches::Lanes&) {});
}

void TreeSolver::correct(const Parallel& parallel, const double*, double* rows, double* points) {
  substitute(parallel, rows, rows, [&](TreeBranches::Lanes& lanes) { lanes.add_accelerations(points); });
  for_each_trunk(parallel, [&](std::size_t trunk, TreeFindings*) { trunks_.move(trunk, points_, points); });
}

void TreeSolver::add_reactions(const Parallel& parallel, const double*, const double* rows, double* points) {
  for_each_trunk(parallel, [&](std::size_t trunk, TreeFindings*) { trunks_.add_reactions(trunk, rows, points); });
  branches_.for_each_batch(parallel, &points_, [&](TreeBranches::Lanes lanes) { lanes.add_reactions(rows, points); });
}

// ---- projections: an iteration sees each branch once. On the way down its points move, and their new violation goes
// up again. ----

/// Calls evaluate_branches(lanes) and evaluate_trunk(trunk, rows, found), which find the violation at `points`, and
/// computes points += M^-1 K S^-1 (-violation).
template <class OfBranches, class OfTrunk>
Projection TreeSolver::project(const Parallel& parallel, double target, const OfBranches& evaluate_branches,
                               const OfTrunk& evaluate_trunk, double* points, double* sum) {
  double* const rows = scratch_rows();
  bool has_moved = false;
  const auto evaluate = [&] {
    forget_findings();
    branches_.for_each_batch(parallel, &points_, [&](TreeBranches::Lanes lanes) {
      if (has_moved) {
        lanes.substitute_down();
        if (sum != nullptr) lanes.add_multipliers(sum);
        lanes.add_accelerations(points);
      } else {
        lanes.read(points);
      }
      evaluate_branches(lanes);
      lanes.substitute_up();
      lanes.hand_over_answers();
    });
    for_each_trunk(parallel, [&](std::size_t trunk, TreeFindings* found) { evaluate_trunk(trunk, rows, found); });
    has_moved = true;
    return found().largest_right_side;
  };
  return iterate_along_chord(target, evaluate, [&] {
    for_each_trunk(parallel, [&](std::size_t trunk, TreeFindings*) {
      trunks_.substitute_up(trunk, rows, &points_, rows);
      trunks_.substitute_down(trunk, &points_, rows);
      trunks_.move(trunk, points_, points);
      if (sum != nullptr) trunks_.add_rows(trunk, rows, sum);
    });
  });
}

Projection TreeSolver::project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                                         const PointSource* source, double* sum) {
  // Only the families of constraints know lengths that move.
  if (has_moving_lengths()) return IslandSolver::project_positions(parallel, blocks, target, r, source, sum);
  bring_points(parallel, source);
  if (sum != nullptr) add_reactions(parallel, blocks, sum, r);
  return project(
      parallel, target, [](TreeBranches::Lanes& lanes) { lanes.evaluate_values(); },
      [&](std::size_t trunk, double* xi, TreeFindings* found) { trunks_.find_values(trunk, r, xi, branches_, found); },
      r, sum);
}

Projection TreeSolver::project_velocities(const Parallel& parallel, const double* blocks, double target,
                                          const double* r, double* v, double* sum) {
  if (has_moving_lengths()) return IslandSolver::project_velocities(parallel, blocks, target, r, v, sum);
  return project(
      parallel, target, [&](TreeBranches::Lanes& lanes) { lanes.evaluate_rates(r); },
      [&](std::size_t trunk, double* rates, TreeFindings* found) {
        trunks_.find_rates(trunk, r, v, rates, branches_, found);
      },
      v, sum);
}

}  // namespace tanor
