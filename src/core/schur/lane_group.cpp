#include <cstring>

#include "schur/lane_groups.hpp"

namespace tanor::detail {

LaneGroups::Group::Group(LaneGroups* all, Pass pass, std::size_t group, std::size_t first_group, std::size_t of_grove,
                         std::size_t of_thread)
    : all_(*all),
      number_(group),
      group_(all->plan_.groups[group]),
      lists_(all->lists_[group]),
      next_(group + 1 < all->lists_.size() ? &lists_ + 1 : nullptr),
      work_(all->workspaces_[of_thread]),
      grove_(all->workspaces_[of_grove]) {
  const LaneGroup& first = all->plan_.groups[first_group];
  const std::size_t rod = group_.first_rod - first.first_rod, place = group_.first_place - first.first_place;
  const bool goes_through = all->goes_through_memory(pass);
  Workspace& of_pass = goes_through ? work_ : grove_;
  const std::size_t pass_rod = goes_through ? 0 : rod, pass_place = goes_through ? 0 : place;
  // Returns the group's part of an array that is empty if nothing needs it.
  const auto part_of = [](auto& all_of, std::size_t begin) {
    return all_of.size() > 0 ? all_of.data() + begin : nullptr;
  };
  in_ = {{.program = all->plan_.program,
          .num_rods = group_.num_rods,
          .num_places = group_.num_places,
          .schedule = group_.schedule,
          .parent = is_tree() ? all->plan_.parent.data() + num_lanes * group_.first_rod : nullptr,
          .have_same_parents = group_.have_same_parents},
         all->inverse_mass_.data() + group_.first_place,
         work_.mobility.data(),
         is_tree() ? work_.s.data() : nullptr,
         work_.dw.data(),
         of_pass.points.data() + pass_place,
         is_tree() ? all->u_.data() + group_.first_rod : of_pass.u.data() + pass_rod,
         all->factor_.data() + group_.first_factor,
         grove_.b.data() + rod,
         of_pass.z.data() + pass_rod,
         part_of(of_pass.directions, pass_rod),
         part_of(of_pass.sum, pass_rod),
         all->are_shifted_ || group_.is_padded ? all->offset_.data() + group_.first_offset : nullptr,
         all->length_.data() + group_.first_rod,
         part_of(all->length_first_, group_.first_rod),
         part_of(all->length_second_, group_.first_rod),
         part_of(all->borders_, group),
         grove_.right_side.data() + (group - first_group),
         grove_.residual.data() + (group - first_group),
         &work_.found};
}

// ---- what pieces hand to one another ----

void LaneGroups::Group::read_separators(const double* blocks, const double* rows) {
  if (!is_path()) return;
  lists_.blocks.read_at(group_.num_rods - 1, blocks, &in_.border->u.x);
  if (rows != nullptr) lists_.rows.read_at(group_.num_rods - 1, rows, &in_.border->x);
}

void LaneGroups::Group::hand_over_roots(const Pack3<>* points) {
  if (may_hang()) points[group_.num_rods].write(&own_joint().dw);
}

void LaneGroups::Group::hand_over_ends(const Pack3<>* points) {
  if (!is_path()) return;
  const Pack3<> nothing{};
  (points != nullptr ? points[0] : nothing).write(&in_.border->r_before);
  (points != nullptr ? points[group_.num_rods] : nothing).write(&in_.border->r_behind);
}

// ---- up ----

/// Returns the arrays that the next pieces of a path begin with.
lanes::Upcoming LaneGroups::Group::upcoming(std::array<const double*, 3> arrays) const {
  if (!is_path() || next_ == nullptr) return {};
  const Index point = next_->points.in_order().first[0];
  const bool are_blocks_in_order = next_->blocks.in_order().count > 0;
  return {{arrays[0] + 3 * point, arrays[1] != nullptr ? arrays[1] + 3 * point : nullptr,
           are_blocks_in_order ? arrays[2] + 3 * next_->blocks.in_order().first[0] : nullptr}};
}

lanes::Motion LaneGroups::Group::read_motion(const FreeMotion& motion, const double* blocks) {
  lists_.points.read(motion.r, work_.r.data());
  lists_.points.read(motion.v, work_.v.data());
  const bool is_uniform = motion.uniform != nullptr && !group_.has_supports;
  if (!is_uniform) lists_.points.read(motion.w0, work_.w.data());
  for (std::size_t k = 0; !is_uniform && motion.uniform != nullptr && k < group_.num_places * num_lanes; ++k) {
    const Index point = lists_.points.numbers()[k] < 0 ? ~lists_.points.numbers()[k] : lists_.points.numbers()[k];
    if (point < all_.num_moving_) set_lane(&work_.w[k / num_lanes], k % num_lanes, *motion.uniform);
  }
  if (next_ != nullptr && !is_path()) call_for(in_.inverse_mass + group_.num_places, group_.num_places);
  return {.r = work_.r.data(),
          .v = work_.v.data(),
          .w0 = is_uniform ? nullptr : work_.w.data(),
          .upcoming = upcoming({motion.r, motion.v, blocks})};
}

void LaneGroups::Group::evaluate_and_eliminate(const lanes::Motion& motion) {
  take_mobilities();
  answer_at_joints(nullptr);
  lanes::evaluate(in_, motion, true);
  if (may_hang()) own_joint().mobility = in_.mobility[group_.num_rods];
  hand_over_answers();
}

void LaneGroups::Group::substitute_up() {
  if (is_tree()) std::memset(in_.s, 0, group_.num_places * sizeof(Pack3<>));
  answer_at_joints(nullptr);
  lanes::substitute_up(in_);
  hand_over_answers();
}

// ---- projections ----

void LaneGroups::Group::move(const double* blocks, bool lambda_is_known, double* points) {
  read_directions(blocks);
  if (is_path()) {
    lanes::accelerate_pieces(in_, lambda_is_known, upcoming({points, nullptr, blocks}), nullptr, {}, nullptr, nullptr);
    return add_points(in_.dw, points);
  }
  lists_.points.read(points, in_.points);
  substitute_down(in_.points, nullptr, lambda_is_known);
  lists_.points.write(in_.points, points);
}

// ---- in and out ----

void LaneGroups::Group::write_rows(const Pack<>* from, double* to) const {
  if (next_ != nullptr) next_->rows.call_for(to);
  lists_.rows.write(from, to);
}

/// Adds numbers to points, of which no two lanes have the same one.
void LaneGroups::Group::add_points(const Pack3<>* from, double* to) const {
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    for (std::size_t k = 0; k < group_.num_places; ++k) {
      if (const Index point = lists_.points.numbers()[k * num_lanes + lane]; point >= 0)
        add_to(to, point, lane_of(from[k], lane));
    }
  }
}

void LaneGroups::Group::read_directions(const double* blocks) {
  if (is_tree()) return;  // kept since the factor was made
  lists_.blocks.read(blocks, in_.u);
}

}  // namespace tanor::detail
