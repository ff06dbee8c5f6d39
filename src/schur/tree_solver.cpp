#include "schur/tree_solver.hpp"

#include <algorithm>
#include <cmath>

#include "plan/thresholds.hpp"
#include "schur/tree_lanes.hpp"

namespace tanor {

// ---- the plan ----

std::unique_ptr<TreeSolver> TreeSolver::make(const SchurProblem& problem, int threads, bool eagerly,
                                             std::vector<Index>* islands) {
  if (islands->empty()) return nullptr;
  const std::vector<Index> before = *islands;
  const RodRows rods(problem.constraints, problem.numbering.num_rows());
  std::vector<RodTree> all;
  std::vector<Index> numbers;
  for (const Index island : before) {
    std::optional<RodTree> tree = RodTree::read(rods, problem.numbering, island);
    if (!tree.has_value()) continue;
    all.push_back(std::move(*tree));
    numbers.push_back(island);
  }
  if (!eagerly) {
    const EqualBranches branches(all);
    std::size_t kept = 0;
    for (std::size_t tree = 0; tree < all.size(); ++tree) {
      if (branches.share_in_lanes(tree) < plan::share_of_tree_in_lanes) continue;
      std::swap(all[kept], all[tree]);
      numbers[kept++] = numbers[tree];
    }
    all.resize(kept);
    numbers.resize(kept);
  }
  if (all.empty()) return nullptr;

  std::unique_ptr<TreeSolver> result(new TreeSolver(std::move(all)));
  result->num_moving_ = static_cast<Index>(problem.numbering.num_moving);
  result->inverse_mass_ = problem.inverse_mass;
  result->read_rods(rods);
  result->read_branches(rods, problem.inverse_mass);
  result->prepare_workspaces(threads);
  result->summarize();
  std::erase_if(*islands, [&](Index island) { return std::ranges::binary_search(numbers, island); });
  result->serve(problem, before, *islands);
  return result;
}

TreeSolver::TreeSolver(std::vector<RodTree> all) : branches_(all) {
  list_islands(all);
}

/// Rods, points and roots of branches by island.
void TreeSolver::list_islands(std::span<const RodTree> all) {
  std::vector<Branch> in_order;
  for (std::size_t batch = 0; batch < branches_.batches.size(); ++batch) {
    const auto num_rods = static_cast<Index>(branches_.shape(branches_.batches[batch]).num_rods);
    for (std::size_t lane = 0; lane < num_lanes; ++lane)
      in_order.push_back({batch, lane, branches_.batches[batch].first_point[lane] + num_rods});
  }
  std::ranges::sort(in_order, {}, &Branch::root);
  auto next = in_order.begin();
  for (std::size_t k = 0; k < all.size(); ++k) {
    const RodTree& tree = all[k];
    const auto is_inside = [&](Index point) {
      return branches_.is_inside[k][static_cast<std::size_t>(point - tree.first_point)] != 0;
    };
    Island island{};
    island.first_rod = rods_.size();
    island.first_point = points_.size();
    island.first_root = roots_.size();
    for (const trees::Rod& rod : tree.rods) {
      if (rod.child >= tree.end_point ? !is_inside(rod.parent) : !is_inside(rod.child)) rods_.push_back(rod);
    }
    for (Index point = tree.first_point; point < tree.end_point; ++point) {
      while (next != in_order.end() && next->root < point) ++next;
      if (next != in_order.end() && next->root == point) {
        roots_.push_back(*next);
      } else if (!is_inside(point)) {
        points_.push_back(point);
      }
    }
    island.end_rod = rods_.size();
    island.end_point = points_.size();
    island.end_root = roots_.size();
    islands_.push_back(island);
  }
  group_start_ = group_islands(islands_.size(), rods_.size(),
                               [&](std::size_t k) { return islands_[k].end_rod - islands_[k].first_rod; });
  found_.resize(group_start_.size() - 1);
}

void TreeSolver::read_rods(const RodRows& given) {
  for (const auto& [inner_row, child, parent] : rods_) {
    const auto row = static_cast<std::size_t>(inner_row);
    sign_.push_back(given.ends[row][0] == child ? 1 : -1);
    block_.push_back(given.block[row]);
    length_.push_back(given.constant_length[row]);
    if (!given.offset.empty()) offset_.push_back(static_cast<double>(sign_.back()) * given.offset[row]);
    if (const MovingScalar* const length = given.moving_length(row)) lengths_.emplace_back(block_.size() - 1, length);
  }
  if (!lengths_.empty()) length_second_.resize(rods_.size(), 0.0);
  for (std::vector<Vec3>* array : {&u_, &h_}) array->resize(rods_.size());
  inverse_pivot_.resize(rods_.size());
  const std::size_t num_points = inverse_mass_.size();
  mobility_.resize(num_points);
  for (std::vector<double>* array : {&s_, &dw_}) array->resize(3 * num_points, 0.0);
}

void TreeSolver::read_branches(const RodRows& given, std::span<const double> inverse_mass) {
  const std::size_t num_rods = branches_.num_rods();
  branch_blocks_.resize(num_rods * num_lanes);
  if (!given.offset.empty()) branch_offsets_.resize(num_rods);
  if (!given.lengths.empty()) branch_lengths_.resize(num_rods * num_lanes, nullptr);
  branch_length_.resize(num_rods);
  branch_rods_.resize(num_rods);
  branch_rows_.resize(num_rods);
  branch_masses_.resize(num_rods + branches_.batches.size());
  for (std::vector<double>* array : {&branch_right_side_, &branch_residual_})
    array->resize(branches_.batches.size() * num_lanes);
  for (const BranchBatch& batch : branches_.batches) {
    const trees::Shape shape = branches_.shape(batch);
    for (std::size_t lane = 0; lane < num_lanes; ++lane) {
      for (std::size_t k = 0; k < shape.num_points(); ++k) {
        const auto point = batch.first_point[lane] + static_cast<Index>(k);
        branch_masses_.data()[batch.first_place + k][lane] = inverse_mass[static_cast<std::size_t>(point)];
        if (k == shape.num_rods) continue;
        const std::size_t row = static_cast<std::size_t>(batch.first_row[lane]) + k, rod = batch.first_rod + k;
        const bool is_turned = given.ends[row][0] != point;
        const auto block = static_cast<Index>(given.block[row]);
        branch_blocks_[rod * num_lanes + lane] = is_turned ? ~block : block;
        branch_length_.data()[rod][lane] = given.constant_length[row];
        if (!given.offset.empty())
          set_lane(&branch_offsets_[rod], lane, is_turned ? -given.offset[row] : given.offset[row]);
        if (!given.lengths.empty()) branch_lengths_[rod * num_lanes + lane] = given.moving_length(row);
      }
    }
  }
}

void TreeSolver::prepare_workspaces(int threads) {
  const std::size_t worthwhile = branches_.num_rods() * num_lanes / plan::rows_of_batches_worth_a_thread;
  const auto available = static_cast<std::size_t>(Parallel(threads).threads());
  workspaces_.resize(std::clamp<std::size_t>(worthwhile, 1, available));
  std::size_t most_points = 0;
  for (const std::vector<Index>& parent : branches_.parents) most_points = std::max(most_points, parent.size() + 1);
  for (Workspace& work : workspaces_) {
    for (auto* points : {&work.r, &work.v, &work.w, &work.s, &work.dw, &work.u}) points->resize(most_points);
    work.mobility.resize(most_points);
    for (Eights* rods : {&work.rows, &work.length_second}) rods->resize(most_points);
  }
}

void TreeSolver::summarize() {
  constexpr double flops_a_rod = 50.0;
  const std::size_t in_lanes = branches_.num_rods() * num_lanes, num_rods = rods_.size() + in_lanes;
  summary_ = {.solvers = {LinearSolver::Trees},
              .reason = (islands_.size() == 1 ? "one tree" : std::to_string(islands_.size()) + " trees") +
                        " of rods, " + std::to_string(in_lanes) + " of " + std::to_string(num_rods) +
                        " rods in equal branches",
              .parts = islands_.size(),
              .pattern_nonzeros = 4 * num_rods,
              .factor_nonzeros = 4 * num_rods,
              .flops = flops_a_rod * static_cast<double>(num_rods)};
}

// ---- what they hang on, island by island ----

void TreeSolver::Found::include(const Found& other) {
  largest_inverse.see(other.largest_inverse.value);
  right_side = larger(right_side, other.right_side);
  residual = larger(residual, other.residual);
  own_residual = larger(own_residual, other.own_residual);
}

trees::Tree TreeSolver::tree(const Island& island) {
  const std::size_t first = island.first_rod;
  return {rods_.data() + first, island.end_rod - first,       num_moving_, inverse_mass_.data(), u_.data() + first,
          h_.data() + first,    inverse_pivot_.data() + first};
}

trees::Motion TreeSolver::motion_of(const Island& island, const FreeMotion& motion, double* blocks, double* b) const {
  const std::size_t rod = island.first_rod;
  return {.r = motion.r,
          .v = motion.v,
          .w0 = motion.w0,
          .uniform = motion.uniform,
          .offset = offset_.empty() ? nullptr : offset_.data() + rod,
          .length_second = length_second_.empty() ? nullptr : length_second_.data() + rod,
          .sign = sign_.data() + rod,
          .block = block_.data() + rod,
          .blocks = blocks,
          .b = b};
}

/// Points that no rod holds.
void TreeSolver::prepare(const Island& island) {
  for (std::size_t k = island.first_point; k < island.end_point; ++k) {
    const auto point = static_cast<std::size_t>(points_[k]);
    mobility_[point] = trees::Mobility<Vec3>::of_free_point(inverse_mass_[point]);
  }
}

void TreeSolver::clear(const Island& island, std::vector<double>* points) const {
  for (std::size_t k = island.first_point; k < island.end_point; ++k) store(points->data(), points_[k], {});
}

/// lambda of z; what pulls at the roots of branches and dw of other points in dw_.
void TreeSolver::finish_substitution(const Island& island, double* x) {
  clear(island, &dw_);
  for (std::size_t k = island.first_root; k < island.end_root; ++k) store(dw_.data(), roots_[k].root, {});
  trees::substitute_down(tree(island), dw_.data(), x);
  for (std::size_t k = island.first_point; k < island.end_point; ++k) {
    const Index point = points_[k];
    store(dw_.data(), point, inverse_mass_[static_cast<std::size_t>(point)] * load(dw_.data(), point));
  }
}

/// |K'dw + b| of the rods, and what branches found.
void TreeSolver::find_residual(const Island& island, const double* b, Found* found) const {
  const auto dw = [&](Index point) { return point < num_moving_ ? load(dw_.data(), point) : Vec3{}; };
  Found own;
  for (std::size_t a = island.first_rod; a < island.end_rod; ++a) {
    const auto& [row, child, parent] = rods_[a];
    own.residual = larger(own.residual, std::abs(dot(u_[a], dw(parent) - dw(child)) + b[row]));
    own.right_side = larger(own.right_side, std::abs(b[row]));
  }
  for (std::size_t k = island.first_root; k < island.end_root; ++k) {
    const auto& [batch, lane, root] = roots_[k];
    own.residual = larger(own.residual, branch_residual_[batch * num_lanes + lane]);
    own.right_side = larger(own.right_side, branch_right_side_[batch * num_lanes + lane]);
  }
  own.own_residual = own_residual(own.residual, own.right_side);
  found->include(own);
}

void TreeSolver::forget_findings() {
  std::ranges::fill(found_, Found{});
  for (Workspace& work : workspaces_) work.largest_inverse = {};
}

Elimination TreeSolver::found() const {
  Found all;
  for (const Found& found : found_) all.include(found);
  for (const Workspace& work : workspaces_) all.largest_inverse.see(work.largest_inverse.value);
  return {1.0 / all.largest_inverse.value, all.right_side, all.residual, all.own_residual};
}

// ---- the calls: up along branches, up and down along what they hang on, down along branches ----

Elimination TreeSolver::solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks,
                              double* b, double* lambda, double* w) {
  forget_findings();
  bring_points(parallel, motion.source);
  for (const auto& [rod, length] : lengths_) length_second_[rod] = length->second;
  const bool renews = use == FactorUse::Renew;
  for_each_batch(parallel, [&](Lanes lanes) {
    const trees::BranchMotion own = lanes.read_motion(motion);
    if (renews) {
      lanes.evaluate_and_eliminate(own);
      lanes.hand_over_mobilities();
      lanes.write_directions(blocks);
    } else {
      lanes.evaluate(own);
      lanes.substitute_up();
    }
    lanes.hand_over_answers();
  });
  for_each_island(parallel, [&](const Island& island, Found* found) {
    const trees::Motion own = motion_of(island, motion, blocks, b);
    clear(island, &s_);
    if (renews) {
      prepare(island);
      trees::evaluate_and_eliminate(tree(island), own, mobility_.data(), s_.data(), lambda, &found->largest_inverse);
    } else {
      trees::evaluate(tree(island), own);
      trees::substitute_up(tree(island), b, s_.data(), lambda);
    }
    finish_substitution(island, lambda);
  });
  for_each_batch(parallel, [&](Lanes lanes) {
    lanes.substitute_down();
    lanes.find_residual();
    lanes.write_multipliers(lambda);
    motion.uniform != nullptr ? lanes.write_accelerations(*motion.uniform, w) : lanes.add_accelerations(w);
  });
  for_each_island(parallel, [&](const Island& island, Found* found) {
    for (std::size_t k = island.first_point; k < island.end_point; ++k) {
      const Index point = points_[k];
      store(w, point, (motion.uniform != nullptr ? *motion.uniform : load(w, point)) + load(dw_.data(), point));
    }
    find_residual(island, b, found);
  });
  return found();
}

Elimination TreeSolver::factorize(const Parallel& parallel, const double* blocks) {
  forget_findings();
  for_each_batch(parallel, [&](Lanes lanes) {
    lanes.read_directions(blocks);
    lanes.eliminate();
    lanes.hand_over_mobilities();
  });
  for_each_island(parallel, [&](const Island& island, Found* found) {
    for (std::size_t a = island.first_rod; a < island.end_rod; ++a)
      u_[a] = static_cast<double>(sign_[a]) * load(blocks, block_[a]);
    prepare(island);
    trees::eliminate(tree(island), mobility_.data(), &found->largest_inverse);
  });
  return {.reciprocal_condition = found().reciprocal_condition};
}

/// x := -S^-1 b, and what a task then does with dw of a batch in its lanes.
template <class Finish>
void TreeSolver::substitute(const Parallel& parallel, const double* b, double* x, const Finish& finish) {
  for_each_batch(parallel, [&](Lanes lanes) {
    lanes.read_right_side(b);
    lanes.substitute_up();
    lanes.hand_over_answers();
  });
  for_each_island(parallel, [&](const Island& island, Found*) {
    clear(island, &s_);
    trees::substitute_up(tree(island), b, s_.data(), x);
    finish_substitution(island, x);
  });
  for_each_batch(parallel, [&](Lanes lanes) {
    lanes.substitute_down();
    lanes.write_multipliers(x);
    finish(lanes);
  });
}

void TreeSolver::solve_negative(const Parallel& parallel, const double* b, double* x) {
  substitute(parallel, b, x, [](const Lanes&) {});
}

void TreeSolver::correct(const Parallel& parallel, const double*, double* rows, double* points) {
  substitute(parallel, rows, rows, [&](Lanes& lanes) { lanes.add_accelerations(points); });
  for_each_island(parallel, [&](const Island& island, Found*) { move(island, points); });
}

void TreeSolver::move(const Island& island, double* points) const {
  for (std::size_t k = island.first_point; k < island.end_point; ++k)
    add_to(points, points_[k], load(dw_.data(), points_[k]));
}

}  // namespace tanor
