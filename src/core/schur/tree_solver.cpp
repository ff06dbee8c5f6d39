#include "schur/tree_solver.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace tanor::detail {

// ---- the plan ----

std::unique_ptr<TreeSolver> TreeSolver::make(const SchurProblem& problem, int threads, bool eagerly,
                                             std::vector<Index>* islands) {
  if (islands->empty()) return nullptr;
  const std::vector<Index> before = *islands;
  const RodRows rods(problem.constraints, problem.numbering.num_rows());
  TreePieces pieces = TreePieces::take(rods, problem.numbering, eagerly, islands);
  if (pieces.trees.empty()) return nullptr;
  std::unique_ptr<TreeSolver> result(new TreeSolver(problem, rods, std::move(pieces), threads));
  result->serve(problem, before, *islands);
  return result;
}

TreeSolver::TreeSolver(const SchurProblem& problem, const RodRows& rods, TreePieces pieces, int threads)
    : lanes_(std::move(pieces), rods, problem.inverse_mass, problem.numbering.num_moving, threads),
      found_(lanes_.pieces().trees.size()),
      reached_(lanes_.pieces().groves.size()) {
  summarize();
}

void TreeSolver::summarize() {
  constexpr double flops_a_rod = 50.0;
  const TreePieces& pieces = lanes_.pieces();
  const std::size_t count = pieces.trees.size(), num_rods = pieces.num_rods;
  summary_ = {.solvers = {LinearSolver::Trees},
              .reason = (count == 1 ? "one tree" : std::to_string(count) + " trees") + " of rods, which use " +
                        std::to_string(static_cast<int>(100.0 * pieces.fullness())) + " % of the lanes",
              .factor = {.parts = count,
                         .pattern_nonzeros = 4 * num_rods,
                         .factor_nonzeros = 4 * num_rods,
                         .flops = flops_a_rod * static_cast<double>(num_rods)}};
}

// ---- the calls ----

Elimination TreeSolver::solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks,
                              double*, double* lambda, double* w) {
  lanes_.take_lengths();
  visit_groves(parallel, &lanes_, [&](const GroveVisit& visit) {
    visit.bring(motion.source);
    visit.up([&](TreeLanes::Group& group) {
      const trees::Motion own = group.read_motion(motion);
      if (use == FactorUse::Renew) {
        group.call_for_blocks(blocks);
        group.evaluate_and_eliminate(own);
        group.write_directions(blocks);
      } else {
        group.evaluate(own);
        group.substitute_up();
      }
    });
    visit.down([&](TreeLanes::Group& group) {
      group.call_for(w);
      group.substitute_down();
      if (!group.plan().has_joints()) group.find_residual();
      group.write_multipliers(lambda);
      motion.uniform != nullptr ? group.write_accelerations(*motion.uniform, w) : group.add_accelerations(w);
    });
    visit.up([](TreeLanes::Group& group) {
      if (group.plan().has_joints()) group.find_residual();
    });
  });
  return found(true);
}

/// Returns the worst findings of all trees.
Elimination TreeSolver::found(bool with_residual) {
  Elimination result;
  std::ranges::fill(found_, Elimination{});
  const std::vector<PieceGroup>& groups = lanes_.pieces().groups;
  for (std::size_t group = 0; group < groups.size(); ++group) {
    result.reciprocal_condition = std::min(result.reciprocal_condition, 1.0 / lanes_.largest_inverse(group));
    for (std::size_t lane = 0; with_residual && lane < num_lanes; ++lane) {
      Elimination& own = found_[static_cast<std::size_t>(groups[group].tree[lane])];
      own.largest_right_side = larger(own.largest_right_side, lanes_.right_side(group, lane));
      own.residual = larger(own.residual, lanes_.residual(group, lane));
    }
  }
  for (Elimination& own : found_) {
    own.own_residual = own_residual(own.residual, own.largest_right_side);
    result.include(own);
  }
  return result;
}

/// Factorizes S of the directions that take(group) finds. `begin(visit)` comes first.
template <class Begin, class TakeDirections>
Elimination TreeSolver::eliminate(const Parallel& parallel, const Begin& begin, const TakeDirections& take) {
  visit_groves(parallel, &lanes_, [&](const GroveVisit& visit) {
    begin(visit);
    visit.up([&](TreeLanes::Group& group) {
      take(group);
      group.eliminate();
    });
  });
  return found(false);
}

Elimination TreeSolver::factorize(const Parallel& parallel, const double* blocks) {
  return eliminate(
      parallel, [](const GroveVisit&) {}, [&](TreeLanes::Group& group) { group.read_directions(blocks); });
}

Elimination TreeSolver::linearise(const Parallel& parallel, const double* r, const PointSource* source,
                                  double* blocks) {
  return eliminate(
      parallel, [&](const GroveVisit& visit) { visit.bring(source); },
      [&](TreeLanes::Group& group) {
        group.find_directions(r);
        group.write_directions(blocks);
      });
}

void TreeSolver::solve_negative(const Parallel& parallel, const double* b, double* x) {
  visit_groves(parallel, &lanes_, [&](const GroveVisit& visit) {
    visit.up([&](TreeLanes::Group& group) {
      group.read_right_side(b);
      group.substitute_up();
    });
    visit.down([&](TreeLanes::Group& group) {
      group.substitute_down();
      group.write_multipliers(x);
    });
  });
}

void TreeSolver::correct(const Parallel& parallel, const double*, double* rows, double* points) {
  visit_groves(parallel, &lanes_, [&](const GroveVisit& visit) {
    visit.up([&](TreeLanes::Group& group) {
      group.read_right_side(rows);
      group.substitute_up();
    });
    visit.down([&](TreeLanes::Group& group) {
      group.substitute_down();
      group.write_multipliers(rows);
      group.add_accelerations(points);
    });
  });
}

namespace {

void add_reactions_of(const GroveVisit& visit, const double* rows, double* points) {
  visit.down([&](TreeLanes::Group& group) {
    group.find_reactions(rows);
    group.add_accelerations(points);
  });
}

}  // namespace

void TreeSolver::add_reactions(const Parallel& parallel, const double*, const double* rows, double* points) {
  visit_groves(parallel, &lanes_, [&](const GroveVisit& visit) { add_reactions_of(visit, rows, points); });
}

// ---- projections ----

double TreeSolver::largest_right_side(const Grove& grove) const {
  double largest = 0.0;
  for (std::size_t group = grove.first_group(); group < grove.end_group(); ++group) {
    for (std::size_t lane = 0; lane < num_lanes; ++lane) largest = larger(largest, lanes_.right_side(group, lane));
  }
  return largest;
}

/// Calls evaluate(group), which finds the violation at `points`, and computes points += M^-1 K S^-1 (-violation).
template <class Evaluate>
Projection TreeSolver::project(const GroveVisit& visit, double target, const Evaluate& evaluate, double* points,
                               double* sum) {
  return iterate_along_chord(
      target,
      [&] {
        visit.up([&](TreeLanes::Group& group) {
          evaluate(group);
          group.substitute_up();
        });
        return largest_right_side(visit.grove());
      },
      [&] {
        visit.down([&](TreeLanes::Group& group) {
          group.substitute_down();
          if (sum != nullptr) group.add_multipliers(sum);
          group.add_accelerations(points);
        });
      });
}

Projection TreeSolver::reached() const {
  Projection result;
  for (const Projection& of_grove : reached_) {
    result.violation = larger(result.violation, of_grove.violation);
    result.iterations = std::max(result.iterations, of_grove.iterations);
  }
  return result;
}

Projection TreeSolver::project_positions(const Parallel& parallel, const double*, double target, double* r,
                                         const PointSource* source, double* sum) {
  lanes_.take_lengths();
  visit_groves(parallel, &lanes_, [&](const GroveVisit& visit) {
    visit.bring(source);
    if (sum != nullptr) add_reactions_of(visit, sum, r);
    reached_[visit.number()] = project(
        visit, target, [&](TreeLanes::Group& group) { group.evaluate_values(r); }, r, sum);
  });
  return reached();
}

Projection TreeSolver::project_velocities(const Parallel& parallel, const double*, double target, const double* r,
                                          double* v, double* sum) {
  lanes_.take_lengths();
  visit_groves(parallel, &lanes_, [&](const GroveVisit& visit) {
    reached_[visit.number()] = project(
        visit, target, [&](TreeLanes::Group& group) { group.evaluate_rates(r, v); }, v, sum);
  });
  return reached();
}

}  // namespace tanor::detail
