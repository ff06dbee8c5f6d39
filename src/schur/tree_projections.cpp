#include <cmath>

#include "schur/tree_lanes.hpp"

/// \file Projections of TreeSolver. An iteration sees each branch once: on the way down its points move, and what they
/// then violate goes up again.
namespace tanor {

/// evaluate_branches(lanes), evaluate_rod(a) -> what is violated at `points`; points += M^-1 K S^-1 (-that).
template <class Branches, class Row>
Projection TreeSolver::project(const Parallel& parallel, double target, const Branches& evaluate_branches,
                               const Row& evaluate_rod, double* points, double* sum) {
  double* const rows = scratch_rows();
  bool has_moved = false;
  const auto evaluate = [&] {
    forget_findings();
    for_each_batch(parallel, [&](Lanes lanes) {
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
    for_each_island(parallel, [&](const Island& island, Found* found) {
      for (std::size_t a = island.first_rod; a < island.end_rod; ++a)
        found->right_side = larger(found->right_side, evaluate_rod(a, &rows[rods_[a].row]));
      for (std::size_t k = island.first_root; k < island.end_root; ++k)
        found->right_side = larger(found->right_side, branch_right_side_[roots_[k].batch * num_lanes + roots_[k].lane]);
    });
    has_moved = true;
    return found().largest_right_side;
  };
  return iterate_along_chord(target, evaluate, [&] {
    for_each_island(parallel, [&](const Island& island, Found*) {
      clear(island, &s_);
      trees::substitute_up(tree(island), rows, s_.data(), rows);
      finish_substitution(island, rows);
      move(island, points);
      for (std::size_t a = island.first_rod; sum != nullptr && a < island.end_rod; ++a)
        sum[rods_[a].row] += rows[rods_[a].row];
    });
  });
}

Projection TreeSolver::project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                                         const PointSource* source, double* sum) {
  // The families know lengths that move.
  if (!lengths_.empty() || !branch_lengths_.empty())
    return IslandSolver::project_positions(parallel, blocks, target, r, source, sum);
  bring_points(parallel, source);
  if (sum != nullptr) add_reactions(parallel, blocks, sum, r);
  return project(
      parallel, target, [](Lanes& lanes) { lanes.evaluate_values(); },
      [&](std::size_t a, double* xi) {
        *xi = norm(distance(a, r)) - length_[a];
        return std::abs(*xi) / length_[a];
      },
      r, sum);
}

Projection TreeSolver::project_velocities(const Parallel& parallel, const double* blocks, double target,
                                          const double* r, double* v, double* sum) {
  if (!lengths_.empty() || !branch_lengths_.empty())
    return IslandSolver::project_velocities(parallel, blocks, target, r, v, sum);
  return project(
      parallel, target, [&](Lanes& lanes) { lanes.evaluate_rates(r); },
      [&](std::size_t a, double* rate) {
        const Vec3 apart = distance(a, r);
        *rate = dot(apart, load(v, rods_[a].parent) - load(v, rods_[a].child)) / norm(apart);
        return std::abs(*rate);
      },
      v, sum);
}

void TreeSolver::add_reactions(const Parallel& parallel, const double*, const double* rows, double* points) {
  for_each_island(parallel, [&](const Island& island, Found*) { add_own_reactions(island, rows, points); });
  for_each_batch(parallel, [&](Lanes lanes) { lanes.add_reactions(rows, points); });
}

void TreeSolver::add_own_reactions(const Island& island, const double* rows, double* points) const {
  for (std::size_t a = island.first_rod; a < island.end_rod; ++a) {
    const auto& [row, child, parent] = rods_[a];
    const Vec3 force = rows[row] * u_[a];
    add_to(points, parent, inverse_mass_[static_cast<std::size_t>(parent)] * force);
    if (child < num_moving_) add_to(points, child, -inverse_mass_[static_cast<std::size_t>(child)] * force);
  }
}

/// From the child to the parent.
Vec3 TreeSolver::distance(std::size_t rod, const double* r) const {
  const Vec3 apart = load(r, rods_[rod].parent) - load(r, rods_[rod].child);
  return offset_.empty() ? apart : apart + offset_[rod];
}

}  // namespace tanor
