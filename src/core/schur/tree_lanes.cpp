#include "schur/tree_lanes.hpp"

#include <utility>

namespace tanor::detail {

// ---- the plan ----

TreeLanes::TreeLanes(TreePieces pieces, const RodRows& given, std::span<const double> inverse_mass,
                     std::size_t num_moving, int threads)
    : pieces_(std::move(pieces)), num_moving_(static_cast<Index>(num_moving)), joints_(pieces_.groups.size()) {
  read_rods(given, inverse_mass);
  find_blocks_that_follow();
  are_shifted_ = !given.offset.empty();
  if (are_shifted_ || std::ranges::any_of(pieces_.groups, &PieceGroup::is_padded)) offset_.resize(pieces_.num_slots());
  for_each_rod([&](std::size_t rod, std::size_t lane, bool is_there, Index) {
    if (!is_there) set_lane(&offset_[rod], lane, {1.0, 0.0, 0.0});  // gives it a direction
  });
  read_offsets(given.offset);
  prepare_workspaces(threads);
}

/// Calls visit(rod, lane, whether there is one, the point at the child's place).
template <class Visit>
void TreeLanes::for_each_rod(const Visit& visit) const {
  for (const PieceGroup& group : pieces_.groups) {
    for (std::size_t k = 0; k < group.num_rods; ++k) {
      for (std::size_t lane = 0; lane < num_lanes; ++lane) {
        const Index child = pieces_.point[(group.first_place + k) * num_lanes + lane];
        const std::size_t rod = group.first_rod + k;
        visit(rod, lane, pieces_.row[rod * num_lanes + lane] >= 0, child < 0 ? ~child : child);
      }
    }
  }
}

void TreeLanes::read_rods(const RodRows& given, std::span<const double> inverse_mass) {
  const std::size_t num_rods = pieces_.num_slots();
  block_.resize(num_rods * num_lanes);
  for (Packs* const moving : {&lengths_.first, &lengths_.second}) {
    if (!given.lengths.empty()) moving->resize(num_rods);
  }
  lengths_.value.resize(num_rods);
  inverse_mass_.resize(pieces_.num_places());
  for (std::size_t k = 0; k < pieces_.point.size(); ++k) {
    const Index point = pieces_.point[k];
    inverse_mass_.data()[k / num_lanes][k % num_lanes] =
        inverse_mass[static_cast<std::size_t>(point < 0 ? ~point : point)];
  }
  for_each_rod([&](std::size_t rod, std::size_t lane, bool is_there, Index child) {
    const std::size_t slot = rod * num_lanes + lane;
    lengths_.value.data()[rod][lane] = 1.0;
    if (!is_there) return;
    const auto row = static_cast<std::size_t>(pieces_.row[slot]);
    const auto block = static_cast<Index>(given.block[row]);
    block_[slot] = given.ends[row][0] == child ? block : ~block;
    lengths_.value.data()[rod][lane] = given.constant_length[row];
    if (const MovingScalar* const length = given.lengths.empty() ? nullptr : given.moving_length(row))
      moving_lengths_.emplace_back(slot, length);
  });
  inverse_masses_.resize(num_rods);
  // Rods of nobody join free points to one that never moves, which leaves them out of all that is found.
  for (const PieceGroup& group : pieces_.groups) {
    for (std::size_t lane = 0; lane < num_lanes && group.is_padded; ++lane) {
      Pack<>* const own = inverse_mass_.data() + group.first_place;
      for (std::size_t k = 0; k < group.num_rods && pieces_.row[(group.first_rod + k) * num_lanes + lane] < 0; ++k)
        own[k][lane] = 1.0;
      own[group.num_rods + 1][lane] = 0.0;
    }
    for (std::size_t k = 0; k < group.num_rods * num_lanes; ++k) {
      const std::size_t slot = group.first_rod * num_lanes + k, parent = static_cast<std::size_t>(pieces_.parent[slot]);
      const Pack<>* const own = inverse_mass_.data() + group.first_place;
      inverse_masses_.data()[slot / num_lanes][k % num_lanes] =
          own[k / num_lanes][k % num_lanes] + own[parent][k % num_lanes];
    }
  }
}

void TreeLanes::find_blocks_that_follow() {
  for (const PieceGroup& group : pieces_.groups) {
    Blocks& blocks = blocks_.emplace_back();
    const Index* const block = block_.data() + group.first_rod * num_lanes;
    const bool are_turned = block[0] < 0;
    bool follow = group.follow;
    for (std::size_t lane = 0; lane < num_lanes; ++lane) blocks.first[lane] = are_turned ? ~block[lane] : block[lane];
    for (std::size_t k = 0; k < group.num_rods * num_lanes; ++k) {
      const Index own = are_turned ? ~block[k] : block[k];
      follow = follow && own == blocks.first[k % num_lanes] + static_cast<Index>(k / num_lanes);
    }
    if (follow) blocks.sign = are_turned ? -1.0 : 1.0;
  }
}

void TreeLanes::read_offsets(std::span<const Vec3> by_row) {
  if (by_row.empty()) return;
  for_each_rod([&](std::size_t rod, std::size_t lane, bool is_there, Index) {
    const std::size_t slot = rod * num_lanes + lane;
    if (!is_there) return;
    const Vec3 offset = by_row[static_cast<std::size_t>(pieces_.row[slot])];
    set_lane(&offset_[rod], lane, block_[slot] < 0 ? -offset : offset);
  });
}

void TreeLanes::take_lengths() {
  for (const auto& [slot, length] : moving_lengths_) {
    const std::size_t rod = slot / num_lanes, lane = slot % num_lanes;
    lengths_.value.data()[rod][lane] = length->value;
    lengths_.first.data()[rod][lane] = length->first;
    lengths_.second.data()[rod][lane] = length->second;
  }
}

void TreeLanes::prepare_workspaces(int threads) {
  const std::size_t num_groups = pieces_.groups.size(), num_rods = pieces_.num_slots();
  u_.resize(num_rods);
  factor_.resize(num_rods);
  b_.resize(num_rods);
  z_.resize(num_rods);
  found_.largest_inverse.resize(num_groups);
  for (std::vector<double>* array : {&found_.right_side, &found_.residual}) array->resize(num_groups * num_lanes);
  std::size_t most_places = 0, num_kept = 0;
  for (const PieceGroup& group : pieces_.groups) {
    most_places = std::max(most_places, group.num_places());
    first_kept_.push_back(num_kept);
    if (group.has_joints()) num_kept += group.num_places();
  }
  kept_dw_.resize(num_kept);
  workspaces_.resize(static_cast<std::size_t>(Parallel(threads).threads()));
  for (Workspace& work : workspaces_) {
    for (auto* points : {&work.r, &work.v, &work.w, &work.s, &work.dw}) points->resize(most_places);
    work.mobility.resize(most_places);
    work.rows.resize(most_places);
  }
}

// ---- a group ----

TreeLanes::Group::Group(TreeLanes* all, std::size_t group, std::size_t workspace)
    : all_(*all),
      number_(group),
      group_(all->pieces_.groups[group]),
      work_(all->workspaces_[workspace]),
      in_{.shape = {all->pieces_.parent.data() + num_lanes * group_.first_rod, group_.num_rods, group_.num_places(),
                    group_.have_same_parents},
          .points = {all->inverse_mass_.data() + group_.first_place, work_.mobility.data(), work_.s.data()},
          .rods = {all->u_.data() + group_.first_rod, all->factor_.data() + group_.first_rod,
                   all->b_.data() + group_.first_rod, all->z_.data() + group_.first_rod,
                   all->inverse_masses_.data() + group_.first_rod},
          .dw = group_.has_joints() ? all->kept_dw_.data() + all->first_kept_[group] : work_.dw.data()} {}

namespace {

/// Returns the derivatives of a group's lengths; null if no length moves.
const Pack<>* group_of(Packs* all, const PieceGroup& group) {
  return all->size() > 0 ? all->data() + group.first_rod : nullptr;
}

}  // namespace

// ---- what pieces hand to one another ----

void TreeLanes::Group::take_mobilities() {
  trees::free_points(in_.shape, in_.points);
  if (group_.has_joints()) trees::take_mobilities(joints(), all_.joints_.data(), in_.points.mobility);
}

void TreeLanes::Group::answer_at_joints(const Pack3<>* force) {
  if (group_.has_joints()) trees::answer_at_joints(joints(), all_.joints_.data(), force, in_.points.s);
}

void TreeLanes::Group::take_force() {
  trees::clear(in_.shape, in_.dw);
  Pack3<> force = own_joint().dw;
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    const std::size_t own = std::min(lane, group_.num_pieces - 1);
    set_lane(&force, lane, group_.has_joint_as_root[lane] ? Vec3{force.x[own], force.y[own], force.z[own]} : Vec3{});
  }
  force.write(&in_.dw[group_.num_rods]);
}

/// Hands the forces on joints down.
void TreeLanes::Group::hand_over_forces(const Pack3<>* known) {
  if (group_.has_joints()) trees::pull_joints(joints(), in_.dw, known, all_.joints_.data());
}

/// Forces on other points become dw, and that of the roots goes up.
void TreeLanes::Group::accelerate() {
  trees::accelerate(in_.shape, in_.points, in_.dw);
  hand_over_roots(in_.dw);
}

void TreeLanes::Group::take_joints(Pack3<>* points) {
  if (!group_.has_joints()) return;
  trees::take_joints(joints(), all_.joints_.data(), points);
  hand_over_roots(points);  // one that is a joint itself has several pieces, one after the other
}

// ---- up ----

trees::Motion TreeLanes::Group::read_motion(const FreeMotion& motion) {
  read_points(motion.r, &work_.r);
  read_points(motion.v, &work_.v);
  const bool is_uniform = motion.uniform != nullptr && !group_.has_supports;
  if (!is_uniform) read_points(motion.w0, &work_.w);
  for (std::size_t k = 0; group_.has_supports && motion.uniform != nullptr && k < in_.shape.num_places * num_lanes;
       ++k) {
    const Index point = points()[k] < 0 ? ~points()[k] : points()[k];
    if (point < all_.num_moving_) set_lane(&work_.w[k / num_lanes], k % num_lanes, *motion.uniform);
  }
  return {.r = work_.r.data(),
          .v = work_.v.data(),
          .w0 = is_uniform ? nullptr : work_.w.data(),
          .offset = offsets(),
          .length_second = group_of(&all_.lengths_.second, group_)};
}

void TreeLanes::Group::evaluate(const trees::Motion& motion) {
  Largest right_side;
  trees::evaluate(in_.shape, motion, in_.rods, &right_side);
  note_right_side(right_side);
}

void TreeLanes::Group::eliminate() {
  take_mobilities();
  all_.found_.largest_inverse[number_] = trees::eliminate(in_.shape, in_.points, in_.rods);
  own_joint().mobility = in_.points.mobility[group_.num_rods];
}

void TreeLanes::Group::evaluate_and_eliminate(const trees::Motion& motion) {
  Largest right_side;
  take_mobilities();
  answer_at_joints(nullptr);
  all_.found_.largest_inverse[number_] =
      trees::evaluate_and_eliminate(in_.shape, motion, in_.points, in_.rods, &right_side);
  note_right_side(right_side);
  own_joint().mobility = in_.points.mobility[group_.num_rods];
  hand_over_answers();
}

void TreeLanes::Group::substitute_up() {
  trees::clear(in_.shape, in_.points.s);
  answer_at_joints(nullptr);
  trees::substitute_up(in_.shape, in_.points, in_.rods);
  hand_over_answers();
}

void TreeLanes::Group::note_right_side(const Largest& found) {
  pack_to(&all_.found_.right_side[number_ * num_lanes]) = found.value + found.zero;
}

// ---- down ----

void TreeLanes::Group::call_for(const double* points) const {
  if (group_.follow) call_for_sequences(points, this->points(), 3, 3 * in_.shape.num_places);
}

void TreeLanes::Group::call_for_blocks(const double* blocks) const {
  if (all_.blocks_[number_].sign != 0.0)
    call_for_sequences(blocks, all_.blocks_[number_].first.data(), 3, 3 * in_.shape.num_rods);
}

void TreeLanes::Group::substitute_down() {
  take_force();
  trees::substitute_down(in_.shape, in_.rods, in_.dw);
  hand_over_forces(nullptr);
  accelerate();
}

void TreeLanes::Group::substitute_down(const Pack3<>* known, Pack3<>* points) {
  take_force();
  trees::substitute_down(in_.shape, in_.rods, in_.dw);
  hand_over_forces(known);
  trees::accelerate(in_.shape, in_.points, in_.dw, points);
  hand_over_roots(points);
}

void TreeLanes::Group::find_reactions(const double* rows) {
  take_force();
  read_rows(rows, work_.rows.data());
  trees::find_reactions(in_.shape, in_.rods, work_.rows.data(), in_.dw);
  hand_over_forces(nullptr);
  accelerate();
}

void TreeLanes::Group::find_residual() {
  take_joints(in_.dw);
  Largest residual;
  trees::find_residual(in_.shape, in_.rods, in_.dw, &residual);
  pack_to(&all_.found_.residual[number_ * num_lanes]) = residual.value + residual.zero;
}

// ---- projections ----

void TreeLanes::Group::evaluate_values(const double* r) {
  Largest largest;
  read_points(r, &work_.r);
  trees::evaluate_values(in_.shape, work_.r.data(), offsets(), all_.lengths_.value.data() + group_.first_rod, in_.rods,
                         &largest);
  note_right_side(largest);
}

void TreeLanes::Group::evaluate_rates(const double* r, const double* v) {
  Largest largest;
  read_points(r, &work_.r);
  read_points(v, &work_.v);
  trees::evaluate_rates(in_.shape, work_.r.data(), work_.v.data(), offsets(), group_of(&all_.lengths_.first, group_),
                        in_.rods, &largest);
  note_right_side(largest);
}

void TreeLanes::Group::add_multipliers(double* sum) {
  Pack<>* const lanes = work_.rows.data();
  read_rows(sum, lanes);
  for (std::size_t k = 0; k < in_.shape.num_rods; ++k) lanes[k] += in_.rods.z[k];
  write_rows(lanes, sum);
}

// ---- in and out ----

const Pack3<>* TreeLanes::Group::offsets() const {
  return all_.are_shifted_ || group_.is_padded ? all_.offset_.data() + group_.first_rod : nullptr;
}

void TreeLanes::Group::find_directions(const double* r) {
  read_points(r, &work_.r);
  trees::find_directions(in_.shape, work_.r.data(), offsets(), in_.rods);
}

void TreeLanes::Group::read_directions(const double* blocks) {
  const Index* const block = all_.block_.data() + group_.first_rod * num_lanes;
  for (std::size_t k = 0; k < in_.shape.num_rods * num_lanes; ++k) {
    Vec3 own{1.0, 0.0, 0.0};
    if (rows()[k] >= 0) own = block[k] < 0 ? -load(blocks, ~block[k]) : load(blocks, block[k]);
    set_lane(&in_.rods.u[k / num_lanes], k % num_lanes, own);
  }
}

void TreeLanes::Group::write_directions(double* blocks) {
  const Blocks& own = all_.blocks_[number_];
  if (own.sign != 0.0)
    return scatter_sequences(&in_.rods.u->x, own.first.data(), 3, 3 * in_.shape.num_rods, own.sign, blocks);
  trees::scatter_directions(in_.rods.u, rows(), all_.block_.data() + group_.first_rod * num_lanes, in_.shape.num_rods,
                            blocks);
}

void TreeLanes::Group::read_right_side(const double* b) {
  read_rows(b, in_.rods.b);
}

void TreeLanes::Group::write_multipliers(double* x) {
  write_rows(in_.rods.z, x);
}

void TreeLanes::Group::write_accelerations(Vec3 w0, double* w) {
  trees::add(in_.shape, w0, in_.dw, work_.w.data());
  write(work_.w.data(), w);
}

void TreeLanes::Group::add_accelerations(double* w) {
  read_points(w, &work_.w);
  add(in_.dw, in_.shape.num_places, work_.w.data());
  write(work_.w.data(), w);
}

void TreeLanes::Group::read_points(const double* from, std::vector<Pack3<>>* to) const {
  if (group_.follow) return gather_sequences(from, points(), 3, 3 * in_.shape.num_places, 1.0, &to->data()->x);
  trees::gather_places(from, points(), in_.shape.num_places, to->data());
}

void TreeLanes::Group::read(const double* from) {
  if (group_.follow) return gather_sequences(from, points(), 3, 3 * in_.shape.num_places, 1.0, &in_.dw->x);
  trees::gather_places(from, points(), in_.shape.num_places, in_.dw);
}

void TreeLanes::Group::write(const Pack3<>* from, double* to) const {
  if (group_.follow) return scatter_sequences(&from->x, points(), 3, 3 * in_.shape.num_places, 1.0, to);
  trees::scatter_places(from, points(), in_.shape.num_places, to);
}

void TreeLanes::Group::read_rows(const double* from, Pack<>* to) const {
  if (group_.follow) return gather_sequences(from, rows(), 1, in_.shape.num_rods, 1.0, to);
  trees::gather_some(from, rows(), in_.shape.num_rods, to);
}

void TreeLanes::Group::write_rows(const Pack<>* from, double* to) const {
  if (group_.follow) return scatter_sequences(from, rows(), 1, in_.shape.num_rods, 1.0, to);
  trees::scatter_some(from, rows(), in_.shape.num_rods, to);
}

}  // namespace tanor::detail
