#include <cstring>

#include "schur/lane_groups.hpp"

namespace tanor::detail {

LaneGroups::Group::Group(LaneGroups* all, Pass pass, std::size_t group, std::size_t first_group, std::size_t of_grove,
                         std::size_t of_thread)
    : GroupTransfers(all->plan_, group, all->places_, all->block_.data()),
      all_(*all),
      number_(group),
      group_(all->plan_.groups[group]),
      work_(all->workspaces_[of_thread]),
      grove_(all->workspaces_[of_grove]) {
  const LaneGroup& first = all->plan_.groups[first_group];
  const std::size_t rod = group_.first_rod - first.first_rod, place = group_.first_place - first.first_place;
  const bool goes_through = all->goes_through_memory(pass);
  Workspace& of_pass = goes_through ? work_ : grove_;
  const std::size_t pass_rod = goes_through ? 0 : rod, pass_place = goes_through ? 0 : place;
  const auto of_projection = [pass_rod](auto& kept) { return kept.size() > 0 ? kept.data() + pass_rod : nullptr; };
  own_ = {of_pass.points.data() + pass_place, of_projection(of_pass.directions), of_projection(of_pass.sum),
          grove_.right_side.data() + (group - first_group), grove_.residual.data() + (group - first_group)};
  in_ = {.shape = {all->plan_.program, group_.num_rods, group_.num_places, group_.structure,
                   is_tree() ? all->plan_.parent.data() + num_lanes * group_.first_rod : nullptr,
                   group_.have_same_parents},
         .points = {all->inverse_mass_.data() + group_.first_place, work_.mobility.data(),
                    is_tree() ? work_.s.data() : nullptr},
         .rods = {is_tree() ? all->u_.data() + group_.first_rod : of_pass.u.data() + pass_rod,
                  all->factor_.data() + group_.first_factor, grove_.b.data() + rod, of_pass.z.data() + pass_rod,
                  is_tree() ? all->inverse_masses_.data() + group_.first_rod : nullptr, &work_.border},
         .dw = work_.dw.data()};
}

namespace {

/// Returns the derivatives of a group's lengths; null if no length moves.
const Pack<>* group_of(const Packs& all, const LaneGroup& group) {
  return all.size() > 0 ? all.data() + group.first_rod : nullptr;
}

}  // namespace

// ---- what pieces hand to one another ----

/// Calls visit(separator, lane) for each piece of a path.
template <class Visit>
void LaneGroups::Group::for_separators(const Visit& visit) const {
  for (std::size_t lane = 0; is_path() && lane < group_.num_members; ++lane)
    visit(&all_.separators_[group_.separator[lane]], lane);
}

/// Returns the separator one place on from that of a lane, or one place back; null beyond the ends of an open path.
Separator* LaneGroups::Group::neighbour(std::size_t lane, bool is_behind) const {
  const auto [first, end, is_ring] = all_.plan_.paths[static_cast<std::size_t>(group_.island[lane])];
  const std::size_t own = group_.separator[lane], last = end - 1;
  if (own == (is_behind ? last : first)) return is_ring ? &all_.separators_[is_behind ? first : last] : nullptr;
  return &all_.separators_[is_behind ? own + 1 : own - 1];
}

void LaneGroups::Group::hand_over_factor() {
  for_separators([&](Separator* own, std::size_t lane) {
    own->first = lane_of(in_.rods.u[0], lane);
    own->u = lane_of(in_.rods.u[group_.num_rods - 1], lane);
    own->inverse_mass_before = in_.points.inverse_mass[0][lane];
    own->inverse_mass_behind = in_.points.inverse_mass[group_.num_rods][lane];
    own->diagonal = work_.border.diagonal[lane];
    own->pivot = work_.border.pivot[lane];
    own->spread = work_.border.spread[lane];
    own->taken = work_.border.taken[lane];
  });
  if (may_hang()) own_joint().mobility = in_.points.mobility[group_.num_rods];
}

void LaneGroups::Group::hand_over_answers() {
  for_separators([&](Separator* own, std::size_t lane) {
    own->b = in_.rods.b[group_.num_rods - 1][lane];
    own->y = work_.border.y[lane];
    own->taken_y = work_.border.taken_y[lane];
  });
  if (may_hang()) in_.points.s[group_.num_rods].write(&own_joint().s);
}

void LaneGroups::Group::read_separators(const double* blocks, const double* rows) {
  for_separators([&](Separator* own, std::size_t lane) {
    own->u = block(blocks, group_.num_rods - 1, lane);
    if (rows != nullptr) own->x = row(rows, group_.num_rods - 1, lane);
  });
}

/// Takes what the separators found.
void LaneGroups::Group::take_separators() {
  work_.border = lanes::Border();
  for_separators([&](const Separator* own, std::size_t lane) {
    work_.border.x[lane] = own->x;
    const Separator* const one_before = neighbour(lane, false);
    if (one_before == nullptr) return;
    work_.border.b_of_first[lane] = own->coupling * one_before->x + own->b_of_first;
    set_lane(&work_.border.force_before, lane, one_before->force());
  });
}

void LaneGroups::Group::take_mobilities() {
  if (!is_tree()) return;
  lanes::free_points(in_);
  lanes::take_from_joints(joints(), all_.joints_.data(), &Joint::mobility, in_.points.mobility);
}

void LaneGroups::Group::answer_at_joints(const Pack3<>* force) {
  if (!group_.has_joints()) return;
  if (force == nullptr) return lanes::take_from_joints(joints(), all_.joints_.data(), &Joint::s, in_.points.s);
  lanes::answer_at_joints(joints(), all_.joints_.data(), force, in_.points.s);
}

void LaneGroups::Group::hand_over_roots(const Pack3<>* points) {
  if (may_hang()) points[group_.num_rods].write(&own_joint().dw);
}

void LaneGroups::Group::take_joints(Pack3<>* points) {
  for_separators([&](const Separator*, std::size_t lane) {
    if (const Separator* const next = neighbour(lane, true)) set_lane(&points[group_.num_rods], lane, next->r.first);
  });
  if (!group_.has_joints()) return;
  lanes::take_from_joints(joints(), all_.joints_.data(), &Joint::dw, points);
  hand_over_roots(points);  // one that is a joint itself has several pieces, one after the other
}

void LaneGroups::Group::hand_over_ends(const Pack3<>* points) {
  for_separators([&](Separator* own, std::size_t lane) {
    own->r.before = points != nullptr ? lane_of(points[0], lane) : Vec3{};
    own->r.behind = points != nullptr ? lane_of(points[group_.num_rods], lane) : Vec3{};
  });
}

// ---- up ----

/// Returns the arrays that the next pieces of a path begin with.
lanes::Upcoming LaneGroups::Group::upcoming(std::array<const double*, 3> arrays) const {
  if (!is_path() || next() == nullptr) return {};
  const Index point = next()->points.first[0];
  const bool are_blocks_in_order = next()->blocks.count > 0;
  return {{arrays[0] + 3 * point, arrays[1] != nullptr ? arrays[1] + 3 * point : nullptr,
           are_blocks_in_order ? arrays[2] + 3 * next()->blocks.first[0] : nullptr}};
}

lanes::Motion LaneGroups::Group::read_motion(const FreeMotion& motion, const double* blocks) {
  read_points(motion.r, work_.r.data());
  read_points(motion.v, work_.v.data());
  const bool is_uniform = motion.uniform != nullptr && !group_.has_supports;
  if (!is_uniform) read_points(motion.w0, work_.w.data());
  for (std::size_t k = 0; !is_uniform && motion.uniform != nullptr && k < group_.num_places * num_lanes; ++k) {
    const Index point = point_list()[k] < 0 ? ~point_list()[k] : point_list()[k];
    if (point < all_.num_moving_) set_lane(&work_.w[k / num_lanes], k % num_lanes, *motion.uniform);
  }
  if (next() != nullptr && !is_path()) call_for(in_.points.inverse_mass + group_.num_places, group_.num_places);
  return {.r = work_.r.data(),
          .v = work_.v.data(),
          .w0 = is_uniform ? nullptr : work_.w.data(),
          .offset = offsets(),
          .length_second = group_of(all_.lengths_.second, group_),
          .upcoming = upcoming({motion.r, motion.v, blocks})};
}

void LaneGroups::Group::evaluate(const lanes::Motion& motion) {
  lanes::evaluate(in_, motion, false, own_.right_side, &work_.found);
}

void LaneGroups::Group::eliminate() {
  take_mobilities();
  lanes::eliminate(in_, &work_.found);
  hand_over_factor();
}

void LaneGroups::Group::evaluate_and_eliminate(const lanes::Motion& motion) {
  take_mobilities();
  answer_at_joints(nullptr);
  lanes::evaluate(in_, motion, true, own_.right_side, &work_.found);
  hand_over_factor();
  hand_over_answers();
}

void LaneGroups::Group::solve(const lanes::Motion& motion, const Vec3* uniform, FactorUse use, double* w) {
  const bool is_in_one_pass = use == FactorUse::Renew && is_tree();
  if (is_in_one_pass) {
    evaluate_and_eliminate(motion);
  } else {
    evaluate(motion);
    // It is made as elsewhere, so that its bits do not tell what was solved before.
    if (use == FactorUse::Renew) eliminate();
    if (is_tree()) std::memset(in_.points.s, 0, group_.num_places * sizeof(Pack3<>));
  }
  lanes::finish(in_, is_in_one_pass, motion.w0, uniform != nullptr ? *uniform : Vec3{},
                w != nullptr ? work_.w.data() : nullptr, own_.right_side, &work_.found);
  if (w != nullptr) write_points(work_.w.data(), w);
  if (next() != nullptr) {
    const Pack<>* const factor = all_.factor_.data() + all_.plan_.groups[number_ + 1].first_factor;
    call_for(factor, static_cast<std::size_t>(factor - in_.rods.factor));  // the next one is mostly as large
  }
}

void LaneGroups::Group::substitute_up() {
  if (is_tree()) std::memset(in_.points.s, 0, group_.num_places * sizeof(Pack3<>));
  answer_at_joints(nullptr);
  lanes::substitute_up(in_);
  hand_over_answers();
}

// ---- down ----

void LaneGroups::Group::substitute_down(Pack3<>* points, const Pack3<>* known, bool lambda_is_known) {
  if (is_path()) take_separators();
  if (is_path() && points != nullptr) {
    lanes::accelerate_pieces(in_, lambda_is_known, {}, points, {}, points, nullptr);
    return for_separators([&](Separator* own, std::size_t lane) {
      own->r.first = lane_of(points[0], lane);
      if (const Separator* const one_before = neighbour(lane, false))
        own->r.first = own->r.first + one_before->r.behind;
      set_lane(&points[0], lane, own->r.first);
    });
  }
  Pack3<> force = may_hang() ? own_joint().dw : Pack3<>{};
  for (std::size_t lane = 0; lane < num_lanes && may_hang(); ++lane) {
    const std::size_t own = std::min(lane, group_.num_members - 1);
    set_lane(&force, lane, group_.ends_island[lane] ? Vec3{} : Vec3{force.x[own], force.y[own], force.z[own]});
  }
  lanes::substitute_down(in_, lambda_is_known, may_hang() ? &force : nullptr, points);
  if (group_.has_joints()) lanes::pull_joints(joints(), in_.dw, known, all_.joints_.data());
  if (points != nullptr) hand_over_roots(points);
}

void LaneGroups::Group::substitute_down(const double* blocks, const Vec3* uniform, double* w) {
  const Vec3 everywhere = uniform != nullptr ? *uniform : Vec3{};
  if (is_path()) {
    read_directions(blocks);
    take_separators();
    lanes::accelerate_pieces(in_, false, upcoming({w, nullptr, blocks}), nullptr, everywhere,
                             uniform != nullptr ? work_.w.data() : nullptr, own_.residual);
    for_separators([&](Separator* own, std::size_t lane) {
      own->dw.first = lane_of(in_.dw[0], lane);
      own->dw.last = lane_of(in_.dw[group_.num_rods - 1], lane);
    });
    return uniform != nullptr ? write_points(work_.w.data(), w) : add_points(in_.dw, w);
  }
  if (uniform == nullptr) read_points(w, work_.w.data());
  substitute_down();
  lanes::accelerate(in_, uniform != nullptr ? nullptr : work_.w.data(), everywhere, work_.w.data(),
                    group_.has_joints() ? nullptr : own_.residual);
  hand_over_roots(in_.dw);
  if (group_.has_joints()) std::copy_n(in_.dw, group_.num_places, own_.points);
  write_points(work_.w.data(), w);
}

void LaneGroups::Group::find_residual() {
  take_joints(own_.points);
  lanes::find_residual(in_, own_.points, own_.residual);
}

// ---- projections ----

void LaneGroups::Group::evaluate_values() {
  lanes::evaluate_values(in_, own_.points, offsets(), all_.lengths_.value.data() + group_.first_rod, own_.right_side);
}

void LaneGroups::Group::evaluate_rates() {
  lanes::evaluate_rates(in_, own_.directions, own_.points, group_of(all_.lengths_.first, group_), own_.right_side);
}

void LaneGroups::Group::add_multipliers() {
  for (std::size_t k = 0; k < group_.num_rods; ++k) own_.sum[k] += in_.rods.z[k];
}

void LaneGroups::Group::move(const double* blocks, bool lambda_is_known, double* points) {
  read_directions(blocks);
  if (is_path()) {
    take_separators();
    lanes::accelerate_pieces(in_, lambda_is_known, upcoming({points, nullptr, blocks}), nullptr, {}, nullptr, nullptr);
    return add_points(in_.dw, points);
  }
  read_points(points, own_.points);
  substitute_down(own_.points, nullptr, lambda_is_known);
  write_points(own_.points, points);
}

// ---- in and out ----

const Pack3<>* LaneGroups::Group::offsets() const {
  return all_.are_shifted_ || group_.is_padded ? all_.offset_.data() + group_.first_offset : nullptr;
}

void LaneGroups::Group::find_directions(const double* r, Pack3<>* u) {
  read_points(r, work_.r.data());
  lanes::find_directions(in_, work_.r.data(), offsets(), u);
}

void LaneGroups::Group::read_directions(const double* blocks, bool are_new) {
  if (is_tree() && !are_new) return;  // kept since the factor was made
  read_blocks(blocks, in_.rods.u);
}

}  // namespace tanor::detail
