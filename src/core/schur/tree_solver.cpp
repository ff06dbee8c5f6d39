#include "schur/tree_solver.hpp"

#include <algorithm>
#include <utility>

#include "schur/tree_lanes.hpp"

namespace tanor::detail {

// ---- the plan ----

std::unique_ptr<TreeSolver> TreeSolver::make(const SchurProblem& problem, int threads, bool eagerly,
                                             std::vector<Index>* islands) {
  if (islands->empty()) return nullptr;
  const std::vector<Index> before = *islands;
  const RodRows rods(problem.constraints, problem.numbering.num_rows());
  TreesInLanes chosen(rods, problem.numbering, eagerly, islands);
  if (chosen.trees.empty()) return nullptr;
  std::unique_ptr<TreeSolver> result(new TreeSolver(problem, rods, chosen.trees, std::move(chosen.branches), threads));
  result->serve(problem, before, *islands);
  return result;
}

TreeSolver::TreeSolver(const SchurProblem& problem, const RodRows& rods, std::span<const RodTree> trees,
                       EqualBranches branches, int threads)
    : branches_(std::move(branches), rods, problem.inverse_mass, threads),
      trunks_(trees, branches_.plan(), rods, problem.inverse_mass, problem.numbering.num_moving),
      points_(problem.inverse_mass.size()),
      groves_(trees, branches_.plan()),
      found_(trees.size()),
      reached_(groves_.size()) {
  summarize();
}

void TreeSolver::summarize() {
  constexpr double flops_a_rod = 50.0;
  const std::size_t in_lanes = branches_.num_rods(), num_rods = trunks_.num_rods() + in_lanes;
  summary_ = {.solvers = {LinearSolver::Trees},
              .reason = (trunks_.size() == 1 ? "one tree" : std::to_string(trunks_.size()) + " trees") + " of rods, " +
                        std::to_string(in_lanes) + " of " + std::to_string(num_rods) + " rods in equal branches",
              .factor = {.parts = trunks_.size(),
                         .pattern_nonzeros = 4 * num_rods,
                         .factor_nonzeros = 4 * num_rods,
                         .flops = flops_a_rod * static_cast<double>(num_rods)}};
}

// ---- grove by grove ----

/// One grove of the solver.
class TreeSolver::Visit {
 public:
  Visit(TreeSolver* all, const GroveVisit& visit) : all_(*all), visit_(visit) {}

  std::size_t number() const { return visit_.number(); }

  void bring(const PointSource* source) const {
    if (source == nullptr) return;
    const std::vector<std::size_t>& trees = visit_.grove().trees;
    if (trees.size() == 1) return all_.trunks_.bring(visit_.parallel(), trees[0], source);
    const Parallel alone(1);
    visit_.for_each_tree([&](std::size_t tree) { all_.trunks_.bring(alone, tree, source); });
  }
  /// Calls work(lanes) for each batch.
  template <class Work>
  void for_each_batch(const Work& work) const {
    visit_.for_each_batch([&](std::size_t batch, std::size_t workspace) {
      work(TreeBranches::Lanes(&all_.branches_, batch, &all_.points_, workspace));
    });
  }
  /// Calls work(trunk, found) for each trunk.
  template <class Work>
  void for_each_trunk(const Work& work) const {
    visit_.for_each_tree([&](std::size_t tree) { work(tree, &all_.found_[tree]); });
  }
  void forget_right_sides() const {
    for (const std::size_t tree : visit_.grove().trees) all_.found_[tree].right_side = 0.0;
  }
  double largest_right_side() const {
    double largest = 0.0;
    for (const std::size_t tree : visit_.grove().trees) largest = larger(largest, all_.found_[tree].right_side);
    return largest;
  }

 private:
  TreeSolver& all_;
  const GroveVisit& visit_;
};

template <class Work>
void TreeSolver::for_each_grove(const Parallel& parallel, const Work& work) {
  groves_.visit(parallel, branches_.num_workspaces(parallel),
                [&](const GroveVisit& visit) { work(Visit(this, visit)); });
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
  trunks_.take_lengths();
  for_each_grove(parallel, [&](const Visit& visit) {
    visit.bring(motion.source);
    visit.for_each_batch([&](TreeBranches::Lanes lanes) {
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
    visit.for_each_trunk([&](std::size_t trunk, TreeFindings* found) {
      trunks_.solve_up(trunk, motion, use, blocks, b, &points_, lambda, found);
      trunks_.substitute_down(trunk, &points_, lambda);
    });
    visit.for_each_batch([&](TreeBranches::Lanes lanes) {
      lanes.substitute_down();
      lanes.find_residual();
      lanes.write_multipliers(lambda);
      motion.uniform != nullptr ? lanes.write_accelerations(*motion.uniform, w) : lanes.add_accelerations(w);
    });
    visit.for_each_trunk([&](std::size_t trunk, TreeFindings* found) {
      trunks_.accelerate(trunk, points_, motion.uniform, w);
      trunks_.find_residual(trunk, points_, b, branches_, found);
    });
  });
  return found();
}

/// Factorizes S of the directions that take_branches(lanes) and take_trunk(trunk) find. Both are called after
/// `begin(visit)`.
template <class Begin, class OfBranches, class OfTrunk>
Elimination TreeSolver::eliminate(const Parallel& parallel, const Begin& begin, const OfBranches& take_branches,
                                  const OfTrunk& take_trunk) {
  forget_findings();
  for_each_grove(parallel, [&](const Visit& visit) {
    begin(visit);
    visit.for_each_batch([&](TreeBranches::Lanes lanes) {
      take_branches(lanes);
      lanes.eliminate();
      lanes.hand_over_mobilities();
    });
    visit.for_each_trunk([&](std::size_t trunk, TreeFindings* found) {
      take_trunk(trunk);
      trunks_.eliminate(trunk, &points_, found);
    });
  });
  return {.reciprocal_condition = found().reciprocal_condition};
}

Elimination TreeSolver::factorize(const Parallel& parallel, const double* blocks) {
  return eliminate(
      parallel, [](const Visit&) {}, [&](TreeBranches::Lanes& lanes) { lanes.read_directions(blocks); },
      [&](std::size_t trunk) { trunks_.read_directions(trunk, blocks); });
}

Elimination TreeSolver::linearise(const Parallel& parallel, const double* r, const PointSource* source,
                                  double* blocks) {
  return eliminate(
      parallel, [&](const Visit& visit) { visit.bring(source); },
      [&](TreeBranches::Lanes& lanes) {
        lanes.find_directions(r);
        lanes.write_directions(blocks);
      },
      [&](std::size_t trunk) { trunks_.find_directions(trunk, r, blocks); });
}

/// Computes x := -S^-1 b of a grove, then calls finish(lanes) for each batch, with dw in its lanes.
template <class Finish>
void TreeSolver::substitute(const Visit& visit, const double* b, double* x, const Finish& finish) {
  visit.for_each_batch([&](TreeBranches::Lanes lanes) {
    lanes.read_right_side(b);
    lanes.substitute_up();
    lanes.hand_over_answers();
  });
  visit.for_each_trunk([&](std::size_t trunk, TreeFindings*) {
    trunks_.substitute_up(trunk, b, &points_, x);
    trunks_.substitute_down(trunk, &points_, x);
  });
  visit.for_each_batch([&](TreeBranches::Lanes lanes) {
    lanes.substitute_down();
    lanes.write_multipliers(x);
    finish(lanes);
  });
}

void TreeSolver::solve_negative(const Parallel& parallel, const double* b, double* x) {
  for_each_grove(parallel, [&](const Visit& visit) { substitute(visit, b, x, [](const TreeBranches::Lanes&) {}); });
}

void TreeSolver::correct(const Parallel& parallel, const double*, double* rows, double* points) {
  for_each_grove(parallel, [&](const Visit& visit) {
    substitute(visit, rows, rows, [&](TreeBranches::Lanes& lanes) { lanes.add_accelerations(points); });
    visit.for_each_trunk([&](std::size_t trunk, TreeFindings*) { trunks_.move(trunk, points_, points); });
  });
}

void TreeSolver::add_reactions(const Visit& visit, const double* rows, double* points) {
  visit.for_each_trunk([&](std::size_t trunk, TreeFindings*) { trunks_.add_reactions(trunk, rows, points); });
  visit.for_each_batch([&](TreeBranches::Lanes lanes) { lanes.add_reactions(rows, points); });
}

void TreeSolver::add_reactions(const Parallel& parallel, const double*, const double* rows, double* points) {
  for_each_grove(parallel, [&](const Visit& visit) { add_reactions(visit, rows, points); });
}

// ---- projections: an iteration sees each branch once. On the way down its points move, and their new violation goes
// up again. ----

/// Calls evaluate_branches(lanes) and evaluate_trunk(trunk, rows, found), which find the violation of a grove at
/// `points`, and computes points += M^-1 K S^-1 (-violation).
template <class OfBranches, class OfTrunk>
Projection TreeSolver::project(const Visit& visit, double target, const OfBranches& evaluate_branches,
                               const OfTrunk& evaluate_trunk, double* points, double* sum) {
  double* const rows = scratch_rows();
  bool has_moved = false;
  const auto evaluate = [&] {
    visit.forget_right_sides();
    visit.for_each_batch([&](TreeBranches::Lanes lanes) {
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
    visit.for_each_trunk([&](std::size_t trunk, TreeFindings* found) { evaluate_trunk(trunk, rows, found); });
    has_moved = true;
    return visit.largest_right_side();
  };
  return iterate_along_chord(target, evaluate, [&] {
    visit.for_each_trunk([&](std::size_t trunk, TreeFindings*) {
      trunks_.substitute_up(trunk, rows, &points_, rows);
      trunks_.substitute_down(trunk, &points_, rows);
      trunks_.move(trunk, points_, points);
      if (sum != nullptr) trunks_.add_rows(trunk, rows, sum);
    });
  });
}

/// Returns the worst of all groves.
Projection TreeSolver::reached() const {
  Projection result;
  for (const Projection& of_grove : reached_) {
    result.violation = larger(result.violation, of_grove.violation);
    result.iterations = std::max(result.iterations, of_grove.iterations);
  }
  return result;
}

Projection TreeSolver::project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                                         const PointSource* source, double* sum) {
  // Only the families of constraints know lengths that move.
  if (has_moving_lengths()) return IslandSolver::project_positions(parallel, blocks, target, r, source, sum);
  for_each_grove(parallel, [&](const Visit& visit) {
    visit.bring(source);
    if (sum != nullptr) add_reactions(visit, sum, r);
    reached_[visit.number()] = project(
        visit, target, [](TreeBranches::Lanes& lanes) { lanes.evaluate_values(); },
        [&](std::size_t trunk, double* xi, TreeFindings* found) {
          trunks_.find_values(trunk, r, xi, branches_, found);
        },
        r, sum);
  });
  return reached();
}

Projection TreeSolver::project_velocities(const Parallel& parallel, const double* blocks, double target,
                                          const double* r, double* v, double* sum) {
  if (has_moving_lengths()) return IslandSolver::project_velocities(parallel, blocks, target, r, v, sum);
  for_each_grove(parallel, [&](const Visit& visit) {
    reached_[visit.number()] = project(
        visit, target, [&](TreeBranches::Lanes& lanes) { lanes.evaluate_rates(r); },
        [&](std::size_t trunk, double* rates, TreeFindings* found) {
          trunks_.find_rates(trunk, r, v, rates, branches_, found);
        },
        v, sum);
  });
  return reached();
}

}  // namespace tanor::detail
