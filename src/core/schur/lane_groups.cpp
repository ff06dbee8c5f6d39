#include "schur/lane_groups.hpp"

#include <cstring>
#include <numeric>

#include "plan/thresholds.hpp"

namespace tanor::detail {

// ---- the plan ----

LaneGroups::LaneGroups(LanePlan plan, const RodRows& given, std::span<const double> inverse_mass,
                       std::size_t num_moving, int threads)
    : plan_(std::move(plan)), num_moving_(static_cast<Index>(num_moving)) {
  read_rods(given);
  read_masses(inverse_mass);
  find_places();
  prepare_workspaces(threads);
}

/// Calls visit(rod, lane, whether there is one, the point at its first place).
template <class Visit>
void LaneGroups::for_each_rod(const Visit& visit) const {
  for (const LaneGroup& group : plan_.groups) {
    for (std::size_t k = 0; k < group.num_rods; ++k) {
      const std::size_t rod = group.first_rod + k,
                        first = group.structure == nullptr
                                    ? k
                                    : static_cast<std::size_t>(group.structure->topology.rods[k][0]);
      for (std::size_t lane = 0; lane < num_lanes; ++lane) {
        const Index point = plan_.point[(group.first_place + first) * num_lanes + lane];
        visit(rod, lane, plan_.row[rod * num_lanes + lane] >= 0, point < 0 ? ~point : point);
      }
    }
  }
}

void LaneGroups::read_rods(const RodRows& given) {
  const std::size_t num_rods = plan_.num_slots();
  block_.assign(num_rods * num_lanes, no_block);
  for (Packs* const moving : {&lengths_.first, &lengths_.second}) {
    if (!given.lengths.empty()) moving->resize(num_rods);
  }
  lengths_.value.resize(num_rods);
  are_shifted_ = !given.offset.empty();
  if (are_shifted_ || std::ranges::any_of(plan_.groups, &LaneGroup::is_padded)) offset_.resize(num_rods);
  for_each_rod([&](std::size_t rod, std::size_t lane, bool is_there, Index first) {
    const std::size_t slot = rod * num_lanes + lane;
    lengths_.value.data()[rod][lane] = 1.0;
    if (!is_there) return set_lane(&offset_[rod], lane, {1.0, 0.0, 0.0});  // gives it a direction
    const auto row = static_cast<std::size_t>(plan_.row[slot]);
    const auto block = static_cast<Index>(given.block[row]);
    block_[slot] = given.ends[row][0] == first ? block : ~block;
    lengths_.value.data()[rod][lane] = given.constant_length[row];
    if (const MovingScalar* const length = given.lengths.empty() ? nullptr : given.moving_length(row))
      moving_lengths_.emplace_back(slot, length);
  });
  read_offsets(given.offset);
}

void LaneGroups::read_masses(std::span<const double> inverse_mass) {
  inverse_mass_.resize(plan_.num_places());
  for (std::size_t k = 0; k < plan_.point.size(); ++k) {
    const Index point = plan_.point[k];
    inverse_mass_.data()[k / num_lanes][k % num_lanes] =
        inverse_mass[static_cast<std::size_t>(point < 0 ? ~point : point)];
  }
  if (plan_.parent.empty()) return;
  inverse_masses_.resize(plan_.num_slots());
  // Rods of nobody join free points to one that never moves, which leaves them out of all that is found.
  for (const LaneGroup& group : plan_.groups) {
    Pack<>* const own = inverse_mass_.data() + group.first_place;
    for (std::size_t lane = 0; lane < num_lanes && group.is_padded; ++lane) {
      for (std::size_t k = 0; k < group.num_rods && plan_.row[(group.first_rod + k) * num_lanes + lane] < 0; ++k)
        own[k][lane] = 1.0;
      own[group.num_rods + 1][lane] = 0.0;
    }
    for (std::size_t k = 0; k < group.num_rods * num_lanes; ++k) {
      const std::size_t slot = group.first_rod * num_lanes + k, parent = static_cast<std::size_t>(plan_.parent[slot]);
      inverse_masses_.data()[slot / num_lanes][k % num_lanes] =
          own[k / num_lanes][k % num_lanes] + own[parent][k % num_lanes];
    }
  }
}

void LaneGroups::find_places() {
  for (const LaneGroup& group : plan_.groups) {
    Places& found = places_.emplace_back();
    const Index* const point = plan_.point.data() + group.first_place * num_lanes;
    const auto follows = [&](std::size_t place) {
      for (std::size_t lane = 0; lane < num_lanes; ++lane) {
        const Index own = point[place * num_lanes + lane];
        if (own < 0 || own != point[lane] + static_cast<Index>(place)) return false;
      }
      return true;
    };
    std::copy_n(point, num_lanes, found.points.first.begin());
    while (found.points.count < group.num_places && follows(found.points.count)) ++found.points.count;
    if (group.is_padded) continue;
    found.rows = find_sequences(plan_.row.data() + group.first_rod * num_lanes, group.num_rods, 1);
    found.blocks = find_sequences(block_.data() + group.first_rod * num_lanes, group.num_rods, 3);
  }
}

/// Returns the sequences that numbers [k][lane] of so many things each form, if they do, in one order of all lanes.
/// Number ~k stands for k turned.
Sequences LaneGroups::find_sequences(const Index* numbers, std::size_t count, std::size_t width) {
  const auto is_turned = [&](std::size_t k, std::size_t lane) { return numbers[k * num_lanes + lane] < 0; };
  const auto number = [&](std::size_t k, std::size_t lane) {
    return is_turned(k, lane) ? ~numbers[k * num_lanes + lane] : numbers[k * num_lanes + lane];
  };
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t k) { return number(k, 0); });
  Sequences result{.count = count};
  SequencePlaces places;
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    result.first[lane] = number(order[0], lane);
    for (std::size_t k = 0; k < count; ++k) {
      const bool follows = number(order[k], lane) == result.first[lane] + static_cast<Index>(k);
      if (!follows || is_turned(order[k], lane) != is_turned(order[k], 0)) return {};
    }
  }
  for (std::size_t k = 0; k < width * count; ++k) {
    const std::size_t own = order[k / width];
    places.place.push_back(static_cast<int>(width * own + k % width));
    places.sign.push_back(is_turned(own, 0) ? -1.0 : 1.0);
  }
  result.sign = places.sign[0];
  const bool has_one_sign = std::ranges::count(places.sign, result.sign) == std::ssize(places.sign);
  if (has_one_sign && std::ranges::is_sorted(order)) return result;
  if (width == 1) return {};  // single numbers in another order are moved one by one in less time
  if (orders_.empty() || !(orders_.back() == places)) orders_.push_back(std::move(places));
  result.places = &orders_.back();
  return result;
}

void LaneGroups::read_offsets(std::span<const Vec3> by_row) {
  if (by_row.empty()) return;
  for_each_rod([&](std::size_t rod, std::size_t lane, bool is_there, Index) {
    const std::size_t slot = rod * num_lanes + lane;
    if (!is_there) return;
    const Vec3 offset = by_row[static_cast<std::size_t>(plan_.row[slot])];
    set_lane(&offset_[rod], lane, block_[slot] < 0 ? -offset : offset);
  });
}

void LaneGroups::take_lengths() {
  for (const auto& [slot, length] : moving_lengths_) {
    const std::size_t rod = slot / num_lanes, lane = slot % num_lanes;
    lengths_.value.data()[rod][lane] = length->value;
    lengths_.first.data()[rod][lane] = length->first;
    lengths_.second.data()[rod][lane] = length->second;
  }
}

std::size_t LaneGroups::num_shares(std::size_t num_slots, const Parallel& parallel) const {
  const std::size_t most = std::min(workspaces_.size(), static_cast<std::size_t>(parallel.threads()));
  return std::clamp<std::size_t>(num_slots * num_lanes / plan::rows_of_batches_worth_a_thread, 1, most);
}

void LaneGroups::prepare_workspaces(int threads) {
  const bool are_pieces = !plan_.parent.empty();
  factor_.resize(plan_.size_of_factor);
  if (are_pieces) {
    u_.resize(plan_.num_slots());
    joints_.resize(plan_.groups.size());
  }
  std::size_t of_group = 0;
  LanePlan::Extent most{};
  for (const LaneGroup& group : plan_.groups) of_group = std::max(of_group, group.num_places);
  for (std::size_t grove = 0; grove < plan_.num_groves(); ++grove) {
    const LanePlan::Extent own = plan_.extent(grove);
    most = {std::max(most.groups, own.groups), std::max(most.rods, own.rods), std::max(most.places, own.places)};
  }
  workspaces_.resize(static_cast<std::size_t>(Parallel(threads).threads()));
  for (Workspace& work : workspaces_) {
    for (auto* points : {&work.r, &work.v, &work.w, &work.s, &work.dw}) points->resize(of_group);
    if (are_pieces) work.mobility.resize(of_group);
    work.u.resize(are_pieces ? 0 : most.rods);
    work.directions.resize(most.rods);
    work.points.resize(most.places);
    for (Packs* rods : {&work.b, &work.z, &work.sum}) rods->resize(most.rods);
    for (Packs* groups : {&work.right_side, &work.residual}) groups->resize(most.groups);
  }
}

// ---- a group ----

LaneGroups::Group::Group(LaneGroups* all, std::size_t group, std::size_t first_group, std::size_t of_grove,
                         std::size_t of_thread)
    : all_(*all),
      number_(group),
      group_(all->plan_.groups[group]),
      places_(all->places_[group]),
      work_(all->workspaces_[of_thread]),
      grove_(all->workspaces_[of_grove]) {
  const LaneGroup& first = all->plan_.groups[first_group];
  const std::size_t rod = group_.first_rod - first.first_rod, place = group_.first_place - first.first_place;
  const bool is_piece = group_.structure == nullptr;
  own_ = {grove_.points.data() + place,
          grove_.directions.data() + rod,
          grove_.sum.data() + rod,
          grove_.right_side.data() + (group - first_group),
          grove_.residual.data() + (group - first_group),
          all->plan_.point.data() + num_lanes * group_.first_place,
          all->plan_.row.data() + num_lanes * group_.first_rod,
          all->block_.data() + num_lanes * group_.first_rod};
  in_ = {
      .shape = {group_.num_rods, group_.num_places, group_.structure,
                is_piece ? all->plan_.parent.data() + num_lanes * group_.first_rod : nullptr, group_.have_same_parents},
      .points = {all->inverse_mass_.data() + group_.first_place, work_.mobility.data(),
                 is_piece ? work_.s.data() : nullptr},
      .rods = {is_piece ? all->u_.data() + group_.first_rod : grove_.u.data() + rod,
               all->factor_.data() + group_.first_factor, grove_.b.data() + rod, grove_.z.data() + rod,
               is_piece ? all->inverse_masses_.data() + group_.first_rod : nullptr},
      .dw = work_.dw.data()};
}

namespace {

/// Returns the derivatives of a group's lengths; null if no length moves.
const Pack<>* group_of(const Packs& all, const LaneGroup& group) {
  return all.size() > 0 ? all.data() + group.first_rod : nullptr;
}

}  // namespace

// ---- what pieces hand to one another ----

void LaneGroups::Group::take_mobilities() {
  if (!in_.shape.are_pieces()) return;
  lanes::free_points(in_.shape, in_.points);
  if (group_.has_joints()) lanes::take_mobilities(joints(), all_.joints_.data(), in_.points.mobility);
}

void LaneGroups::Group::answer_at_joints(const Pack3<>* force) {
  if (group_.has_joints()) lanes::answer_at_joints(joints(), all_.joints_.data(), force, in_.points.s);
}

void LaneGroups::Group::hand_over_roots(const Pack3<>* points) {
  if (!group_.stands_alone) points[group_.num_rods].write(&own_joint().dw);
}

void LaneGroups::Group::take_joints(Pack3<>* points) {
  if (!group_.has_joints()) return;
  lanes::take_joints(joints(), all_.joints_.data(), points);
  hand_over_roots(points);  // one that is a joint itself has several pieces, one after the other
}

// ---- up ----

lanes::Motion LaneGroups::Group::read_motion(const FreeMotion& motion) {
  read_points(motion.r, work_.r.data());
  read_points(motion.v, work_.v.data());
  const bool is_uniform = motion.uniform != nullptr && !group_.has_supports;
  if (!is_uniform) read_points(motion.w0, work_.w.data());
  for (std::size_t k = 0; !is_uniform && motion.uniform != nullptr && k < group_.num_places * num_lanes; ++k) {
    const Index point = own_.point_list[k] < 0 ? ~own_.point_list[k] : own_.point_list[k];
    if (point < all_.num_moving_) set_lane(&work_.w[k / num_lanes], k % num_lanes, *motion.uniform);
  }
  if (next() != nullptr) call_for(in_.points.inverse_mass + group_.num_places, group_.num_places);
  return {.r = work_.r.data(),
          .v = work_.v.data(),
          .w0 = is_uniform ? nullptr : work_.w.data(),
          .offset = offsets(),
          .length_second = group_of(all_.lengths_.second, group_)};
}

void LaneGroups::Group::evaluate(const lanes::Motion& motion) {
  lanes::evaluate(in_.shape, motion, in_.rods, own_.right_side);
}

void LaneGroups::Group::eliminate() {
  take_mobilities();
  lanes::eliminate(in_.shape, in_.points, in_.rods, &work_.found);
  if (!group_.stands_alone) own_joint().mobility = in_.points.mobility[group_.num_rods];
}

void LaneGroups::Group::evaluate_and_eliminate(const lanes::Motion& motion) {
  take_mobilities();
  answer_at_joints(nullptr);
  lanes::evaluate_and_eliminate(in_.shape, motion, in_.points, in_.rods, own_.right_side, &work_.found);
  own_joint().mobility = in_.points.mobility[group_.num_rods];
  hand_over_answers();
}

void LaneGroups::Group::solve(const lanes::Motion& motion, const Vec3* uniform, FactorUse use, double* w) {
  const bool is_in_one_pass = use == FactorUse::Renew && in_.shape.are_pieces();
  if (is_in_one_pass) {
    evaluate_and_eliminate(motion);
  } else {
    evaluate(motion);
    // It is made as elsewhere, so that its bits do not tell what was solved before.
    if (use == FactorUse::Renew) eliminate();
    if (in_.shape.are_pieces()) std::memset(in_.points.s, 0, group_.num_places * sizeof(Pack3<>));
  }
  lanes::finish(in_.shape, in_.points, in_.rods, is_in_one_pass, in_.dw, motion.w0,
                uniform != nullptr ? *uniform : Vec3{}, work_.w.data(), own_.right_side, &work_.found);
  write_points(work_.w.data(), w);
  if (next() != nullptr) {
    const Pack<>* const factor = all_.factor_.data() + all_.plan_.groups[number_ + 1].first_factor;
    call_for(factor, static_cast<std::size_t>(factor - in_.rods.factor));  // the next one is mostly as large
  }
}

void LaneGroups::Group::substitute_up() {
  if (in_.shape.are_pieces()) std::memset(in_.points.s, 0, group_.num_places * sizeof(Pack3<>));
  answer_at_joints(nullptr);
  lanes::substitute_up(in_.shape, in_.points, in_.rods);
  hand_over_answers();
}

// ---- down ----

void LaneGroups::Group::substitute_down(Pack3<>* points, const Pack3<>* known, bool lambda_is_known) {
  Pack3<> force = group_.stands_alone ? Pack3<>{} : own_joint().dw;
  for (std::size_t lane = 0; lane < num_lanes && !group_.stands_alone; ++lane) {
    const std::size_t own = std::min(lane, group_.num_members - 1);
    set_lane(&force, lane, group_.has_joint_as_root[lane] ? Vec3{force.x[own], force.y[own], force.z[own]} : Vec3{});
  }
  lanes::substitute_down(in_.shape, in_.points.inverse_mass, in_.rods, lambda_is_known,
                         group_.stands_alone ? nullptr : &force, in_.dw, points);
  if (group_.has_joints()) lanes::pull_joints(joints(), in_.dw, known, all_.joints_.data());
  if (points != nullptr) hand_over_roots(points);
}

void LaneGroups::Group::accelerate(const Vec3* uniform, double* w) {
  if (uniform == nullptr) read_points(w, work_.w.data());
  lanes::accelerate(in_.shape, in_.points.inverse_mass, in_.dw, uniform != nullptr ? nullptr : work_.w.data(),
                    uniform != nullptr ? *uniform : Vec3{}, work_.w.data());
  hand_over_roots(in_.dw);
  if (group_.has_joints()) {
    std::copy_n(in_.dw, group_.num_places, own_.points);
  } else {
    lanes::find_residual(in_.shape, in_.rods, in_.dw, own_.residual);
  }
  write_points(work_.w.data(), w);
}

void LaneGroups::Group::find_residual() {
  take_joints(own_.points);
  lanes::find_residual(in_.shape, in_.rods, own_.points, own_.residual);
}

// ---- projections ----

void LaneGroups::Group::evaluate_values() {
  lanes::evaluate_values(in_.shape, own_.points, offsets(), all_.lengths_.value.data() + group_.first_rod, in_.rods.b,
                         own_.right_side);
}

void LaneGroups::Group::evaluate_rates() {
  lanes::evaluate_rates(in_.shape, own_.directions, own_.points, group_of(all_.lengths_.first, group_), in_.rods.b,
                        own_.right_side);
}

void LaneGroups::Group::add_multipliers() {
  for (std::size_t k = 0; k < group_.num_rods; ++k) own_.sum[k] += in_.rods.z[k];
}

// ---- in and out ----

void LaneGroups::Group::call_for_points(const double* points) const {
  if (next() != nullptr) call_for(points, next()->points, 3);
}
void LaneGroups::Group::call_for_blocks(const double* blocks) const {
  if (next() != nullptr) call_for(blocks, next()->blocks, 3);
}

const Pack3<>* LaneGroups::Group::offsets() const {
  return all_.are_shifted_ || group_.is_padded ? all_.offset_.data() + group_.first_rod : nullptr;
}

void LaneGroups::Group::find_directions(const double* r, Pack3<>* u) {
  read_points(r, work_.r.data());
  lanes::find_directions(in_.shape, work_.r.data(), offsets(), u);
}

void LaneGroups::Group::read_directions(const double* blocks, bool are_new) {
  if (in_.shape.are_pieces() && !are_new) return;  // kept since the factor was made
  if (places_.blocks.count > 0) return gather_sequences(blocks, places_.blocks, 3, &in_.rods.u->x);
  gather_blocks(blocks, own_.block_list, group_.num_rods, in_.rods.u);
}

void LaneGroups::Group::write_directions(double* blocks) const {
  if (places_.blocks.count > 0) return scatter_sequences(&in_.rods.u->x, places_.blocks, 3, blocks);
  scatter_blocks(in_.rods.u, own_.block_list, group_.num_rods, blocks);
}

void LaneGroups::Group::read_points(const double* from, Pack3<>* to) const {
  const std::size_t count = places_.points.count;
  if (count > 0) gather_sequences(from, places_.points, 3, &to->x);
  if (count < group_.num_places)
    gather_points(from, own_.point_list + count * num_lanes, group_.num_places - count, to + count);
}

void LaneGroups::Group::write_points(const Pack3<>* from, double* to) const {
  const std::size_t count = places_.points.count;
  if (count > 0) scatter_sequences(&from->x, places_.points, 3, to);
  if (count < group_.num_places)
    scatter_points(from + count, own_.point_list + count * num_lanes, group_.num_places - count, to);
}

void LaneGroups::Group::read_rows(const double* from, Pack<>* to) const {
  if (places_.rows.count > 0) return gather_sequences(from, places_.rows, 1, to);
  gather_rows(from, own_.row_list, group_.num_rods, to, group_.is_padded);
}

void LaneGroups::Group::write_rows(const Pack<>* from, double* to) const {
  if (next() != nullptr) call_for(to, next()->rows, 1);
  if (places_.rows.count > 0) return scatter_sequences(from, places_.rows, 1, to);
  scatter_rows(from, own_.row_list, group_.num_rods, to, group_.is_padded);
}

}  // namespace tanor::detail
