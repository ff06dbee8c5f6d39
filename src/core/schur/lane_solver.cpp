#include "schur/lane_solver.hpp"

#include <algorithm>
#include <utility>

namespace tanor::detail {

// ---- the plan ----

std::unique_ptr<LaneSolver> LaneSolver::make(const SchurProblem& problem, LinearSolver kind, int threads, bool eagerly,
                                             std::vector<Index>* islands) {
  if (islands->empty()) return nullptr;
  const RodRows rods(problem.constraints, problem.numbering.num_rows());
  const auto take = kind == LinearSolver::Batches ? take_equal_islands
                    : kind == LinearSolver::Paths ? take_paths
                                                  : take_trees;
  LanePlan plan = take(rods, problem.numbering, eagerly, islands);
  if (plan.groups.empty()) return nullptr;
  std::unique_ptr<LaneSolver> result(new LaneSolver(problem, rods, std::move(plan), threads));
  result->summary_ = {{kind}, result->groups_.plan().reason, result->groups_.plan().factor};
  return result;
}

// ---- grove by grove ----

/// Calls work(visit) for all groves. Returns what was found.
template <class Work>
LaneSolver::Found LaneSolver::visit(const Parallel& parallel, const Work& work, Pass pass) {
  for (LaneGroups::Workspace& each : groups_.workspaces()) {
    each.found = {};
    each.of_islands = {};
    each.projection = {};
  }
  visit_groves(parallel, &groups_, pass, work);
  Found result;
  for (const LaneGroups::Workspace& each : groups_.workspaces()) {
    result.elimination.include(each.found.read());
    result.elimination.include(each.of_islands);
    result.projection.include(each.projection);
  }
  return result;
}

/// Includes what was found in the groups of pieces, island by island.
void LaneSolver::note_findings(const GroveVisit& visit) {
  LaneGroups::Workspace& work = groups_.workspaces()[visit.workspace()];
  const std::span<const LaneGroup> groups = visit.groups();
  for (std::size_t k = 0; k < groups.size(); ++k) {
    for (std::size_t lane = 0; lane < num_lanes; ++lane) {
      Elimination& own = of_island_[static_cast<std::size_t>(groups[k].island[lane])];
      own.largest_right_side = larger(own.largest_right_side, work.right_side.data()[k][lane]);
      own.residual = larger(own.residual, work.residual.data()[k][lane]);
    }
  }
  visit.for_each_path([&](std::size_t path) {
    double& own = of_island_[path].residual;
    own = larger(own, groups_.separators(path).residual());
  });
  for (std::size_t island = visit.first_island(); island < visit.end_island(); ++island) {
    Elimination& own = of_island_[island];
    own.own_residual = own_residual(own.residual, own.largest_right_side);
    work.of_islands.include(std::exchange(own, {}));
  }
}

// ---- the calls ----

bool LaneSolver::finds_multipliers_alone() const {
  return std::ranges::all_of(groups_.plan().groups, &LaneGroup::stands_alone);
}

Elimination LaneSolver::solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks,
                              double*, double* lambda, double* w) {
  groups_.take_lengths();
  const auto work = [&](const GroveVisit& grove) {
    grove.bring(motion.source);
    grove.up([&](Group& group) {
      grove.bring_for(motion.source, group.plan());
      const lanes::Motion own = group.read_motion(motion, blocks);
      if (!grove.is_of_paths()) {
        group.call_for_points(motion.r);
        group.call_for_points(motion.v);
      }
      if (grove.stands_alone()) {
        group.solve(own, motion.uniform, use, w);
        group.call_for_points(w != nullptr ? w : motion.w0);
        group.write_rows(group.arrays().z, lambda);
      } else if (use == FactorUse::Renew) {
        group.evaluate_and_eliminate(own);
      } else {
        group.evaluate(own);
        group.read_separators(blocks);
        group.substitute_up();
      }
      if (use == FactorUse::Keep) return;
      group.lists().blocks.write(group.arrays().u, blocks);
      if (!grove.is_of_paths()) group.call_for_blocks(blocks);
    });
    if (grove.stands_alone()) return;
    if (use == FactorUse::Renew) grove.factorize_separators();
    grove.solve_separators();
    grove.down([&](Group& group) {
      group.substitute_down(blocks, motion.uniform, w);
      group.write_rows(group.arrays().z, lambda);
    });
    if (!groups_.plan().joints.empty()) {
      grove.up([](Group& group) {
        if (group.plan().has_joints()) group.find_residual();
      });
    }
    note_findings(grove);
  };
  return visit(parallel, work).elimination;
}

Elimination LaneSolver::linearise(const Parallel& parallel, const double* r, const PointSource* source,
                                  double* blocks) {
  const auto work = [&](const GroveVisit& grove) {
    grove.bring(source);
    grove.up([&](Group& group) {
      grove.bring_for(source, group.plan());
      group.find_directions(r, group.arrays().u);
      group.lists().blocks.write(group.arrays().u, blocks);
      group.eliminate();
    });
    grove.factorize_separators();
  };
  return visit(parallel, work).elimination;
}

/// Computes x := -S^-1 b, and points += M^-1 K x unless these are null.
void LaneSolver::solve(const Parallel& parallel, const double* b, double* x, const double* blocks, double* points) {
  visit(parallel, [&](const GroveVisit& grove) {
    bool is_needed = true;
    grove.up([&](Group& group) {
      group.lists().rows.read(b, group.arrays().b);
      // Islands whose series are in lanes have rows of 0, see MultiplierSeries.
      const auto* const own = reinterpret_cast<const double*>(group.arrays().b);
      if (points != nullptr && grove.stands_alone())
        is_needed =
            std::any_of(own, own + num_lanes * group.plan().num_rods, [](double each) { return !(each == 0.0); });
      if (!is_needed) return;
      if (points != nullptr) group.read_separators(blocks);
      group.substitute_up();
    });
    if (!is_needed) return;
    grove.solve_separators();
    grove.down([&](Group& group) {
      if (points != nullptr) group.move(blocks, false, points);
      if (points == nullptr && group.arrays().schedule == nullptr) group.substitute_down();
      group.write_rows(group.arrays().z, x);
    });
  });
}

void LaneSolver::add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) {
  visit(parallel, [&](const GroveVisit& grove) {
    grove.up([&](Group& group) { group.read_separators(blocks, rows); });
    grove.hand_on_separators();
    grove.down([&](Group& group) {
      group.lists().rows.read(rows, group.arrays().z);
      group.move(blocks, true, points);
    });
  });
}

// ---- projections ----

/// Iterates with points that stay in lanes; joints do not have theirs yet if it `was_moved`.
void LaneSolver::project(const GroveVisit& grove, double target, bool was_moved, void (Group::*evaluate)(),
                         double* points, double* sum) {
  LaneGroups::Workspace& work = groups_.workspaces()[grove.workspace()];
  const auto find_violation = [&] {
    grove.up([&](Group& group) {
      if (was_moved) group.take_joints(group.arrays().points);
      (group.*evaluate)();
      group.substitute_up();
    });
    Largest violation;
    for (std::size_t k = 0; k < grove.groups().size(); ++k) violation.see(work.right_side.data()[k]);
    return violation.read();
  };
  const auto move = [&] {
    was_moved = true;
    grove.solve_separators();
    grove.down([&](Group& group) {
      group.substitute_down(group.arrays().points);
      for (std::size_t k = 0; sum != nullptr && k < group.plan().num_rods; ++k)
        group.arrays().sum[k] += group.arrays().z[k];
    });
  };
  work.projection.include(iterate_along_chord(target, find_violation, move));
  grove.up([&](Group& group) {
    group.lists().points.write(group.arrays().points, points);
    if (sum != nullptr) group.write_rows(group.arrays().sum, sum);
  });
}

Projection LaneSolver::project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                                         const PointSource* source, double* sum) {
  groups_.take_lengths();
  const auto work = [&](const GroveVisit& grove) {
    grove.bring(source);
    if (grove.is_of_paths()) {
      grove.up([&](Group& group) {
        grove.bring_for(source, group.plan());
        group.read_separators(blocks, sum);
      });
      if (sum != nullptr) grove.hand_on_separators();
    }
    grove.down([&](Group& group) {
      group.lists().points.read(r, group.arrays().points);
      group.read_directions(blocks);
      group.call_for_points(r);
      group.call_for_blocks(blocks);
      if (sum == nullptr) return;
      group.lists().rows.read(sum, group.arrays().sum);
      std::copy_n(group.arrays().sum, group.plan().num_rods, group.arrays().z);
      group.substitute_down(group.arrays().points, nullptr, true);
    });
    project(grove, target, sum != nullptr, &Group::evaluate_values, r, sum);
  };
  return visit(parallel, work, Pass::Repeated).projection;
}

Projection LaneSolver::project_velocities(const Parallel& parallel, const double* blocks, double target,
                                          const double* r, double* v, double* sum) {
  groups_.take_lengths();
  const auto work = [&](const GroveVisit& grove) {
    grove.up([&](Group& group) {
      group.lists().points.read(v, group.arrays().points);
      group.find_directions(r, group.arrays().directions);
      group.read_directions(blocks);
      group.read_separators(blocks);
      group.call_for_points(r);
      group.call_for_points(v);
      group.call_for_blocks(blocks);
      if (sum != nullptr) group.lists().rows.read(sum, group.arrays().sum);
    });
    project(grove, target, false, &Group::evaluate_rates, v, sum);
  };
  return visit(parallel, work, Pass::Repeated).projection;
}

}  // namespace tanor::detail
