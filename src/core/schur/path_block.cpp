#include "schur/path_block.hpp"

#include <algorithm>

namespace tanor::detail {

PathFactor::PathFactor(const PathRows& rows) : separators(rows.num_separators) {
  for (Packs* array : {&inverse_mass, &l, &inverse_pivot, &b, &y}) array->resize(rows.num_slots);
  for (const PathPieces& of : rows.pieces) {
    for (std::size_t k = 0; k < (of.length + 1) * num_lanes; ++k)
      inverse_mass.data()[of.first_slot + k / num_lanes][k % num_lanes] =
          rows.inverse_mass[of.first_point + k % num_lanes * of.length + k / num_lanes];
  }
}

const Separator& PathFactor::before(const PathRows::Cut& cut, std::size_t separator) const {
  static const Separator nothing;
  if (separator > cut.first_separator) return separators[separator - 1];
  return cut.path.is_ring ? separators[cut.end_separator - 1] : nothing;
}

PathWorkspace::PathWorkspace(std::size_t most_rods) {
  for (auto* array : {&r, &v, &w, &offset, &u}) array->resize(most_rods + 1);
  for (Packs* array : {&changes, &spikes, &x}) array->resize(most_rods + 1);
}

PathBlock::PathBlock(const PathRows& rows, PathFactor* factor, const PathRows::Cut& cut, const PathPieces& of,
                     PathWorkspace* work)
    : rows_(rows),
      of_(of),
      work_(*work),
      separators_(std::span(factor->separators).subspan(of.first_separator).first<num_lanes>()),
      before_(factor->before(cut, of.first_separator)),
      is_followed_(&of + 1 < &rows.pieces[0] + cut.end_pieces),
      arrays_{of.length,
              factor->inverse_mass.data() + of.first_slot,
              work->u.data(),
              factor->l.data() + of.first_slot,
              factor->inverse_pivot.data() + of.first_slot,
              factor->b.data() + of.first_slot,
              factor->y.data() + of.first_slot} {}

// ---- up ----

void PathBlock::read_points(const double* from, std::size_t count, std::vector<Pack3<>>* to) const {
  gather_sequences(from, of_.sequences(of_.first_point, count), 3, &to->data()->x);
}

paths::Motion PathBlock::read_motion(const FreeMotion& motion, const double* blocks, double MovingScalar::*change) {
  paths::Motion result;
  result.r = work_.r.data();
  read_points(motion.r, of_.length + 1, &work_.r);
  if (motion.v != nullptr) {
    read_points(motion.v, of_.length + 1, &work_.v);
    result.v = work_.v.data();
    if (is_followed_)
      result.upcoming = {{motion.r + 3 * last_point(), motion.v + 3 * last_point(), next_blocks(blocks)}};
  }
  if (motion.w0 != nullptr && motion.uniform == nullptr) {
    read_points(motion.w0, of_.length + 1, &work_.w);
    result.w0 = work_.w.data();
  }
  if (!rows_.offset.empty()) {
    gather_sequences(&rows_.offset[0].x, rows_of_lanes(), 3, &work_.offset[0].x);
    result.offset = work_.offset.data();
  }
  if (rows_.read_length_changes(of_, change, work_.changes.data())) result.length_changes = work_.changes.data();
  return result;
}

void PathBlock::read_right_side(const double* b) {
  gather_sequences(b, rows_of_lanes(), 1, arrays_.b);
}

void PathBlock::evaluate_values(const double* r) {
  const paths::Motion motion = read_motion({r, nullptr, nullptr}, nullptr);
  paths::evaluate_values(arrays_, motion, rows_.lengths.data() + of_.first_slot, &work_.found);
}

void PathBlock::evaluate_rates(const double* r, const double* v) {
  paths::evaluate_rates(arrays_, read_motion({r, v, nullptr}, nullptr, &MovingScalar::first), &work_.found);
}

void PathBlock::hand_over_factor(const paths::Border& border) {
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    Separator& own = separators_[lane];
    own.first = lane_of(work_.u[0], lane);
    own.u = lane_of(work_.u[of_.length - 1], lane);
    own.inverse_mass_before = arrays_.inverse_mass[0][lane];
    own.diagonal = border.diagonal[lane];
    own.pivot = border.pivot[lane];
    own.spread = border.spread[lane];
    own.taken = border.taken[lane];
  }
}

void PathBlock::hand_over_right_side(const paths::Border& border) {
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    Separator& own = separators_[lane];
    own.b = arrays_.b[of_.length - 1][lane];
    own.y = border.y[lane];
    own.taken_y = border.taken_y[lane];
  }
}

void PathBlock::eliminate() {
  paths::Border border;
  paths::eliminate(arrays_, &border, &work_.found);
  hand_over_factor(border);
}

void PathBlock::evaluate_and_eliminate(const paths::Motion& motion) {
  paths::Border border;
  paths::evaluate_and_eliminate(arrays_, motion, &border, &work_.found);
  hand_over_factor(border);
  hand_over_right_side(border);
}

void PathBlock::substitute_forward() {
  paths::Border border;
  paths::substitute_forward(arrays_, &border);
  hand_over_right_side(border);
}

// ---- down ----

void PathBlock::substitute_backward() {
  paths::Border border;
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    border.y[lane] = separators_[lane].x;
    border.spread[lane] = separators_[lane].coupling;
    border.taken_y[lane] = lane > 0 ? separators_[lane - 1].x : before_.x;
  }
  paths::substitute_backward(arrays_, border, work_.spikes.data(), work_.x.data());
}

void PathBlock::read_multipliers(const double* rows) {
  gather_sequences(rows, rows_of_lanes(), 1, work_.x.data());
}

void PathBlock::write_multipliers(double* rows) const {
  scatter_sequences(work_.x.data(), rows_of_lanes(), 1, rows);
}

void PathBlock::add_multipliers(double* sum) const {
  add_sequences(work_.x.data(), rows_of_lanes(), 1, sum);
}

void PathBlock::accelerate(const double* blocks, const double* w, bool wants_residual) {
  Pack3<> force_before;
  for (std::size_t lane = 0; lane < num_lanes; ++lane)
    set_lane(&force_before, lane, (lane > 0 ? separators_[lane - 1] : before_).force());
  Pack3<>* const dw = work_.v.data();
  paths::Upcoming upcoming;
  if (is_followed_) upcoming = {{next_blocks(blocks), w + 3 * last_point()}};
  paths::accelerate(arrays_, work_.x.data(), force_before, upcoming, dw, wants_residual ? &work_.found : nullptr);
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    separators_[lane].first_dw = lane_of(dw[0], lane);
    separators_[lane].last_dw = lane_of(dw[of_.length - 1], lane);
  }
}

void PathBlock::write_accelerations(const Vec3* w0, double* w) {
  Pack3<>* const dw = work_.v.data();
  const Sequences places = of_.sequences(of_.first_point, of_.length);
  if (w0 == nullptr) return add_sequences(&dw->x, places, 3, w);
  paths::move(of_.length, *w0, dw);
  scatter_sequences(&dw->x, places, 3, w);
}

}  // namespace tanor::detail
