#include "schur/tree_trunks.hpp"

#include <algorithm>
#include <cmath>

namespace tanor::detail {

void TreeFindings::include(const TreeFindings& other) {
  largest_inverse.see(other.largest_inverse.value);
  right_side = larger(right_side, other.right_side);
  residual = larger(residual, other.residual);
  own_residual = larger(own_residual, other.own_residual);
}

// ---- the plan ----

TreeTrunks::TreeTrunks(std::span<const RodTree> trees, const EqualBranches& branches, const RodRows& given,
                       std::span<const double> inverse_mass, std::size_t num_moving)
    : inverse_mass_(inverse_mass), num_moving_(static_cast<Index>(num_moving)) {
  list_trunks(trees, branches);
  read_rods(given);
}

/// Lists rods, points and roots of branches by tree.
void TreeTrunks::list_trunks(std::span<const RodTree> trees, const EqualBranches& branches) {
  std::vector<Branch> in_order;
  for (std::size_t batch = 0; batch < branches.batches.size(); ++batch) {
    const auto num_rods = static_cast<Index>(branches.shape(branches.batches[batch]).num_rods);
    for (std::size_t lane = 0; lane < num_lanes; ++lane)
      in_order.push_back({batch, lane, branches.batches[batch].first_point[lane] + num_rods});
  }
  std::ranges::sort(in_order, {}, &Branch::root);
  auto next = in_order.begin();
  for (std::size_t k = 0; k < trees.size(); ++k) {
    const RodTree& tree = trees[k];
    const auto is_inside = [&](Index point) {
      return branches.is_inside[k][static_cast<std::size_t>(point - tree.first_point)] != 0;
    };
    Trunk trunk{};
    trunk.first_rod = rods_.size();
    trunk.first_point = points_.size();
    trunk.first_root = roots_.size();
    trunk.points_of_tree = {tree.first_point, tree.end_point};
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
    trunk.end_rod = rods_.size();
    trunk.end_point = points_.size();
    trunk.end_root = roots_.size();
    trunks_.push_back(trunk);
  }
}

void TreeTrunks::read_rods(const RodRows& given) {
  for (const auto& [inner_row, child, parent] : rods_) {
    const auto row = static_cast<std::size_t>(inner_row);
    sign_.push_back(given.ends[row][0] == child ? 1 : -1);
    block_.push_back(given.block[row]);
    length_.push_back(given.constant_length[row]);
    if (const MovingScalar* const length = given.moving_length(row))
      moving_lengths_.emplace_back(block_.size() - 1, length);
  }
  if (!moving_lengths_.empty()) length_second_.resize(rods_.size(), 0.0);
  for (std::vector<Vec3>* array : {&u_, &h_}) array->resize(rods_.size());
  inverse_pivot_.resize(rods_.size());
  read_offsets(given.offset);
}

void TreeTrunks::read_offsets(std::span<const Vec3> by_row) {
  if (by_row.empty()) return;
  offset_.resize(rods_.size());
  for (std::size_t rod = 0; rod < rods_.size(); ++rod)
    offset_[rod] = static_cast<double>(sign_[rod]) * by_row[static_cast<std::size_t>(rods_[rod].row)];
}

trees::Tree TreeTrunks::tree(const Trunk& trunk) {
  const std::size_t first = trunk.first_rod;
  return {rods_.data() + first, trunk.end_rod - first,        num_moving_, inverse_mass_.data(), u_.data() + first,
          h_.data() + first,    inverse_pivot_.data() + first};
}

// ---- the factor ----

void TreeTrunks::read_directions(std::size_t k, const double* blocks) {
  for (std::size_t a = trunks_[k].first_rod; a < trunks_[k].end_rod; ++a)
    u_[a] = static_cast<double>(sign_[a]) * load(blocks, block_[a]);
}

void TreeTrunks::find_directions(std::size_t k, const double* r, double* blocks) {
  trees::find_directions(tree(trunks_[k]),
                         motion_of(trunks_[k], {.r = r, .v = nullptr, .w0 = nullptr}, blocks, nullptr));
}

/// Returns the positions and the motion of a trunk, and where the results for its rods go.
trees::Motion TreeTrunks::motion_of(const Trunk& trunk, const FreeMotion& motion, double* blocks, double* b) const {
  const std::size_t rod = trunk.first_rod;
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

/// Resets the mobility of the trunk's points, as if no rod of the trunk were eliminated.
void TreeTrunks::forget_rods(const Trunk& trunk, TreePoints* points) const {
  for (std::size_t k = trunk.first_point; k < trunk.end_point; ++k) {
    const auto point = static_cast<std::size_t>(points_[k]);
    points->mobility[point] = trees::Mobility<Vec3>::of_free_point(inverse_mass_[point]);
  }
}

void TreeTrunks::clear(const Trunk& trunk, std::vector<double>* points) const {
  for (std::size_t k = trunk.first_point; k < trunk.end_point; ++k) store(points->data(), points_[k], {});
}

void TreeTrunks::eliminate(std::size_t k, TreePoints* points, TreeFindings* found) {
  forget_rods(trunks_[k], points);
  trees::eliminate(tree(trunks_[k]), points->mobility.data(), &found->largest_inverse);
}

void TreeTrunks::substitute_up(std::size_t k, const double* b, TreePoints* points, double* z) {
  clear(trunks_[k], &points->s);
  trees::substitute_up(tree(trunks_[k]), b, points->s.data(), z);
}

void TreeTrunks::solve_up(std::size_t k, const FreeMotion& motion, FactorUse use, double* blocks, double* b,
                          TreePoints* points, double* z, TreeFindings* found) {
  const Trunk& trunk = trunks_[k];
  const trees::Motion own = motion_of(trunk, motion, blocks, b);
  if (use == FactorUse::Keep) {
    trees::evaluate(tree(trunk), own);
    return substitute_up(k, b, points, z);
  }
  clear(trunk, &points->s);
  forget_rods(trunk, points);
  trees::evaluate_and_eliminate(tree(trunk), own, points->mobility.data(), points->s.data(), z,
                                &found->largest_inverse);
}

void TreeTrunks::substitute_down(std::size_t number, TreePoints* points, double* z) {
  const Trunk& trunk = trunks_[number];
  double* const dw = points->dw.data();
  clear(trunk, &points->dw);
  for (std::size_t k = trunk.first_root; k < trunk.end_root; ++k) store(dw, roots_[k].root, {});
  trees::substitute_down(tree(trunk), dw, z);
  for (std::size_t k = trunk.first_point; k < trunk.end_point; ++k) {
    const Index point = points_[k];
    store(dw, point, inverse_mass_[static_cast<std::size_t>(point)] * load(dw, point));
  }
}

// ---- what is done with dw ----

void TreeTrunks::move(std::size_t number, const TreePoints& points, double* to) const {
  const Trunk& trunk = trunks_[number];
  for (std::size_t k = trunk.first_point; k < trunk.end_point; ++k)
    add_to(to, points_[k], load(points.dw.data(), points_[k]));
}

void TreeTrunks::accelerate(std::size_t number, const TreePoints& points, const Vec3* uniform, double* w) const {
  const Trunk& trunk = trunks_[number];
  for (std::size_t k = trunk.first_point; k < trunk.end_point; ++k) {
    const Index point = points_[k];
    store(w, point, (uniform != nullptr ? *uniform : load(w, point)) + load(points.dw.data(), point));
  }
}

void TreeTrunks::find_residual(std::size_t number, const TreePoints& points, const double* b,
                               const TreeBranches& branches, TreeFindings* found) const {
  const Trunk& trunk = trunks_[number];
  const auto dw = [&](Index point) { return point < num_moving_ ? load(points.dw.data(), point) : Vec3{}; };
  TreeFindings own;
  for (std::size_t a = trunk.first_rod; a < trunk.end_rod; ++a) {
    const auto& [row, child, parent] = rods_[a];
    own.residual = larger(own.residual, std::abs(dot(u_[a], dw(parent) - dw(child)) + b[row]));
    own.right_side = larger(own.right_side, std::abs(b[row]));
  }
  for (std::size_t k = trunk.first_root; k < trunk.end_root; ++k)
    own.residual = larger(own.residual, branches.residual(roots_[k].batch, roots_[k].lane));
  include_branches(trunk, branches, &own);
  own.own_residual = own_residual(own.residual, own.right_side);
  found->include(own);
}

void TreeTrunks::include_branches(const Trunk& trunk, const TreeBranches& branches, TreeFindings* found) const {
  for (std::size_t k = trunk.first_root; k < trunk.end_root; ++k)
    found->right_side = larger(found->right_side, branches.right_side(roots_[k].batch, roots_[k].lane));
}

void TreeTrunks::add_reactions(std::size_t number, const double* rows, double* points) const {
  const Trunk& trunk = trunks_[number];
  for (std::size_t a = trunk.first_rod; a < trunk.end_rod; ++a) {
    const auto& [row, child, parent] = rods_[a];
    const Vec3 force = rows[row] * u_[a];
    add_to(points, parent, inverse_mass_[static_cast<std::size_t>(parent)] * force);
    if (child < num_moving_) add_to(points, child, -inverse_mass_[static_cast<std::size_t>(child)] * force);
  }
}

// ---- what is violated ----

/// Returns the vector from the child to the parent.
Vec3 TreeTrunks::distance(std::size_t rod, const double* r) const {
  const Vec3 apart = load(r, rods_[rod].parent) - load(r, rods_[rod].child);
  return offset_.empty() ? apart : apart + offset_[rod];
}

void TreeTrunks::find_values(std::size_t number, const double* r, double* xi, const TreeBranches& branches,
                             TreeFindings* found) const {
  const Trunk& trunk = trunks_[number];
  for (std::size_t a = trunk.first_rod; a < trunk.end_rod; ++a) {
    double& value = xi[rods_[a].row];
    value = norm(distance(a, r)) - length_[a];
    found->right_side = larger(found->right_side, std::abs(value) / length_[a]);
  }
  include_branches(trunk, branches, found);
}

void TreeTrunks::find_rates(std::size_t number, const double* r, const double* v, double* rates,
                            const TreeBranches& branches, TreeFindings* found) const {
  const Trunk& trunk = trunks_[number];
  for (std::size_t a = trunk.first_rod; a < trunk.end_rod; ++a) {
    const auto& [row, child, parent] = rods_[a];
    const Vec3 apart = distance(a, r);
    rates[row] = dot(apart, load(v, parent) - load(v, child)) / norm(apart);
    found->right_side = larger(found->right_side, std::abs(rates[row]));
  }
  include_branches(trunk, branches, found);
}

void TreeTrunks::add_rows(std::size_t number, const double* rows, double* sum) const {
  const Trunk& trunk = trunks_[number];
  for (std::size_t a = trunk.first_rod; a < trunk.end_rod; ++a) sum[rods_[a].row] += rows[rods_[a].row];
}

}  // namespace tanor::detail
