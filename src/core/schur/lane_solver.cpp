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

/// Calls work(visit) for all groves, with findings that are cleared before.
template <class Work>
void LaneSolver::visit(const Parallel& parallel, const Work& work, Pass pass) {
  for (LaneGroups::Workspace& each : groups_.workspaces()) {
    each.found = {};
    each.of_islands = {};
    each.projection = {};
  }
  visit_groves(parallel, &groups_, pass, work);
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

Elimination LaneSolver::found() {
  Elimination result;
  for (const LaneGroups::Workspace& work : groups_.workspaces()) {
    result.include(work.found.read());
    result.include(work.of_islands);
  }
  return result;
}

Projection LaneSolver::reached() {
  Projection result;
  for (const LaneGroups::Workspace& work : groups_.workspaces()) result.include(work.projection);
  return result;
}

// ---- the calls ----

bool LaneSolver::finds_multipliers_alone() const {
  return std::ranges::all_of(groups_.plan().groups, &LaneGroup::stands_alone);
}

Elimination LaneSolver::solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks,
                              double*, double* lambda, double* w) {
  groups_.take_lengths();
  visit(parallel, [&](const GroveVisit& grove) {
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
        group.write_rows(group.arrays().rods.z, lambda);
      } else if (use == FactorUse::Renew) {
        group.evaluate_and_eliminate(own);
      } else {
        group.evaluate(own);
        group.read_separators(blocks);
        group.substitute_up();
      }
      if (use == FactorUse::Keep) return;
      group.lists().blocks.write(group.arrays().rods.u, blocks);
      if (!grove.is_of_paths()) group.call_for_blocks(blocks);
    });
    if (grove.stands_alone()) return;
    if (use == FactorUse::Renew) grove.factorize_separators();
    grove.solve_separators();
    grove.down([&](Group& group) {
      group.substitute_down(blocks, motion.uniform, w);
      group.write_rows(group.arrays().rods.z, lambda);
    });
    if (!groups_.plan().joints.empty()) {
      grove.up([](Group& group) {
        if (group.plan().has_joints()) group.find_residual();
      });
    }
    note_findings(grove);
  });
  return found();
}

Elimination LaneSolver::linearise(const Parallel& parallel, const double* r, const PointSource* source,
                                  double* blocks) {
  visit(parallel, [&](const GroveVisit& grove) {
    grove.bring(source);
    grove.up([&](Group& group) {
      grove.bring_for(source, group.plan());
      group.find_directions(r, group.arrays().rods.u);
      group.lists().blocks.write(group.arrays().rods.u, blocks);
      group.eliminate();
    });
    grove.factorize_separators();
  });
  return found();
}

void LaneSolver::solve_negative(const Parallel& parallel, const double* b, double* x) {
  visit(parallel, [&](const GroveVisit& grove) {
    grove.up([&](Group& group) {
      group.lists().rows.read(b, group.arrays().rods.b);
      group.substitute_up();
    });
    grove.solve_separators();
    grove.down([&](Group& group) {
      if (group.arrays().shape.structure == nullptr) group.substitute_down();
      group.write_rows(group.arrays().rods.z, x);
    });
  });
}

void LaneSolver::correct(const Parallel& parallel, const double* blocks, double* rows, double* points) {
  visit(parallel, [&](const GroveVisit& grove) {
    bool is_needed = true;
    grove.up([&](Group& group) {
      group.lists().rows.read(rows, group.arrays().rods.b);
      // Islands whose series are in lanes have rows of 0, see MultiplierSeries.
      const auto* const b = reinterpret_cast<const double*>(group.arrays().rods.b);
      if (grove.stands_alone())
        is_needed = std::any_of(b, b + num_lanes * group.plan().num_rods, [](double x) { return !(x == 0.0); });
      if (!is_needed) return;
      group.read_separators(blocks);
      group.substitute_up();
    });
    if (!is_needed) return;
    grove.solve_separators();
    grove.down([&](Group& group) {
      group.move(blocks, false, points);
      group.write_rows(group.arrays().rods.z, rows);
    });
  });
}

void LaneSolver::add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) {
  visit(parallel, [&](const GroveVisit& grove) {
    grove.up([&](Group& group) { group.read_separators(blocks, rows); });
    grove.hand_on_separators();
    grove.down([&](Group& group) {
      group.lists().rows.read(rows, group.arrays().rods.z);
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
      if (was_moved) group.take_joints(group.own().points);
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
      group.substitute_down(group.own().points);
      for (std::size_t k = 0; sum != nullptr && k < group.plan().num_rods; ++k)
        group.own().sum[k] += group.arrays().rods.z[k];
    });
  };
  work.projection.include(iterate_along_chord(target, find_violation, move));
  grove.up([&](Group& group) {
    group.lists().points.write(group.own().points, points);
    if (sum != nullptr) group.write_rows(group.own().sum, sum);
  });
}

Projection LaneSolver::project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                                         const PointSource* source, double* sum) {
  groups_.take_lengths();
  visit(
      parallel,
      [&](const GroveVisit& grove) {
        grove.bring(source);
        if (grove.is_of_paths()) {
          grove.up([&](Group& group) {
            grove.bring_for(source, group.plan());
            group.read_separators(blocks, sum);
          });
          if (sum != nullptr) grove.hand_on_separators();
        }
        grove.down([&](Group& group) {
          group.lists().points.read(r, group.own().points);
          group.read_directions(blocks);
          group.call_for_points(r);
          group.call_for_blocks(blocks);
          if (sum == nullptr) return;
          group.lists().rows.read(sum, group.own().sum);
          std::copy_n(group.own().sum, group.plan().num_rods, group.arrays().rods.z);
          group.substitute_down(group.own().points, nullptr, true);
        });
        project(grove, target, sum != nullptr, &Group::evaluate_values, r, sum);
      },
      Pass::Repeated);
  return reached();
}

Projection LaneSolver::project_velocities(const Parallel& parallel, const double* blocks, double target,
                                          const double* r, double* v, double* sum) {
  groups_.take_lengths();
  visit(
      parallel,
      [&](const GroveVisit& grove) {
        grove.up([&](Group& group) {
          group.lists().points.read(v, group.own().points);
          group.find_directions(r, group.own().directions);
          group.read_directions(blocks);
          group.read_separators(blocks);
          group.call_for_points(r);
          group.call_for_points(v);
          group.call_for_blocks(blocks);
          if (sum != nullptr) group.lists().rows.read(sum, group.own().sum);
        });
        project(grove, target, false, &Group::evaluate_rates, v, sum);
      },
      Pass::Repeated);
  return reached();
}

}  // namespace tanor::detail
