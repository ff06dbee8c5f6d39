/// \file The calls of a Constrainer on one of its parts.

#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/nearest_point.hpp"
#include "host/constrained_host.hpp"

namespace tanor::detail {

// ---- a step ----

void ConstrainedHost::find_positions(const PositionStep& step, PartReport* report) {
  const double start = step.time - step.step;
  IncomingPoints incoming(transfer);
  report->outcome = place.stand_at(step.old_positions, start, step.old_cell, &incoming);
  if (!report->outcome.ok()) return;
  if (report->outcome = check_place(step.step); !report->outcome.ok()) return;
  ProjectionReport found = step_positions(step);
  if (!found.outcome.ok()) {
    // The guess may have come from another motion. The second try begins without it.
    form.steps().forget_steps();
    moved.restore();
    place.set_offsets(place.cell);
    if (report->outcome = linearization.update(start, place.r.data()); report->outcome.ok())
      found = step_positions(step);
  }
  report->take(std::move(found));
  if (!report->outcome.ok()) {
    place.stands = false;
    note_worst_position(report);
    return;
  }
  multipliers = form.steps().sum().data();
  // If K lost rank, it was evaluated elsewhere in the meantime, and the multipliers are not known.
  place.stands = model.num_rows() == 0 || std::isfinite(multipliers[0]);
  if (step.measures) measure_step(step, report);
}

void ConstrainedHost::write_positions(const PositionStep& step, PartReport* report) {
  write_reactions(2.0 / step.step, step.wanted);  // the multipliers are a sum over h
  report->correction = write_moved(step.positions, step.measures);
  if (step.velocities) write_step_velocities(step.velocities);
}

double ConstrainedHost::find_speed(const VelocityStep& step, PartReport* report) {
  IncomingPoints incoming(transfer);
  velocities.take(step.velocities, true, &incoming, true);
  report->outcome = place.stand_at(step.positions, step.time, place.present_cell(), &incoming);
  if (!report->outcome.ok()) return 0.0;
  if (!may_move_in_place()) velocities.use_copy();
  // Rates are measured against the velocities of this call.
  const double speed = incoming.largest();
  if (!work.constraints.depends_on_time()) return speed;
  work.set_time(step.time);
  return larger(speed, linearization.evaluate_rates(place.r.data(), velocities.data(), rows.data()));
}

void ConstrainedHost::find_velocities(const VelocityStep& step, double speed, PartReport* report) {
  const bool sums_multipliers = step.measures || wants_multipliers(step.wanted);
  if (sums_multipliers) std::fill(sum.begin(), sum.end(), 0.0);
  multipliers = sum.data();
  double* const v = velocities.data();
  ProjectionReport found =
      form.projector().project_velocities(step.time, place.r.data(), v, sums_multipliers ? sum.data() : nullptr, speed);
  velocities.note_moved();
  report->take(std::move(found));
  if (!report->outcome.ok()) place.stands = false;
  if (model.num_rows() > 0 && (step.measures || !report->outcome.ok())) {
    (void)linearization.evaluate_rates(place.r.data(), v, rows.data());
    note_worst_rate(report);
  }
  if (!report->outcome.ok() || !step.measures) return;
  const double factor = step.step != 0.0 ? 2.0 / step.step : 1.0;
  report->virial = sums.virial(multipliers, factor, linearization.blocks().data(), place.r.data());
  report->work = factor * support_work(step.step, v);
}

void ConstrainedHost::write_velocities(const VelocityStep& step, PartReport* report) {
  write_reactions(step.step != 0.0 ? 2.0 / step.step : 1.0, step.wanted);
  report->correction = velocities.give_back(step.velocities, model.num_moving(), step.measures);
}

// ---- an instant ----

void ConstrainedHost::find_accelerations(const HostState& at, PartReport* report) {
  IncomingPoints incoming(transfer);
  const bool stood = place.find(at.positions, at.time, place.present_cell(), &incoming);
  const double* v = transfer.straight(at.velocities);
  if (v == nullptr) {
    double* const copy = velocities.use_copy();
    incoming.copy(at.velocities, copy);
    v = copy;
  }
  incoming.scale(at.forces, std::span(model.inverse_mass).first(model.num_moving()), w.data());
  ForwardDynamics& dynamics = form.dynamics();
  const Request request{.gradients = stood ? Gradients::Keep : Gradients::Evaluate, .exact = true, .given = &incoming};
  SolveReport solved;
  report->outcome = dynamics.solve({at.time, place.r.data(), v}, request, {w.data(), nullptr, &solved});
  place.stands = report->outcome.ok();
  report->iterations = solved.refinements;
  report->violation = solved.residual;
  if (!report->outcome.ok()) return;
  multipliers = dynamics.multipliers().data();
  if (!at.measures || model.num_rows() == 0) return;
  work.constraints.evaluate_right_side(model.parallel, place.r.data(), v, w.data(), rows.data(), nullptr);
  note_worst_rate(report);
  report->virial = sums.virial(multipliers, 1.0, linearization.blocks().data(), place.r.data());
}

void ConstrainedHost::write_accelerations(const HostState& at) {
  if (at.accelerations) transfer.write(w.data(), model.num_moving(), at.accelerations);
  write_reactions(1.0, at.wanted);
}

void ConstrainedHost::find_forces(const ConstPointArray& positions, const PointArray& forces, double time,
                                  PartReport* report) {
  IncomingPoints incoming(transfer);
  incoming.scale(forces, std::span(model.inverse_mass).first(model.num_moving()), w.data());  // w = M^-1 f
  std::fill(w.begin() + static_cast<std::ptrdiff_t>(3 * model.num_moving()), w.end(), 0.0);
  report->outcome = place.stand_at(positions, time, place.present_cell(), &incoming);
  if (!report->outcome.ok()) return;
  std::fill(sum.begin(), sum.end(), 0.0);
  multipliers = sum.data();
  const double scale = incoming.largest();
  if (!std::isfinite(scale)) {
    report->outcome = model.not_finite(time);
    return;
  }
  if (model.num_rows() == 0 || scale == 0.0) return;
  // S nu = -K'w, w += M^-1 K nu, lambda += nu
  constexpr double target = 1e-15;
  const auto measure = [&] {
    return report->violation = linearization.apply_transposed(w.data(), nullptr, rows.data()) / scale;
  };
  report->iterations = linearization.refine({rows.data(), w.data(), sum.data(), 5, 5}, measure,
                                            [](double violation) { return !(violation > target); });
  note_worst_rate(report);
  report->virial = sums.virial(multipliers, 1.0, linearization.blocks().data(), place.r.data());
}

void ConstrainedHost::write_forces(const PointArray& forces, const ConstraintForces& wanted, PartReport* report) {
  write_reactions(1.0, wanted);
  if (report->iterations == 0) return;  // the forces are right as they are
  model.parallel.for_ranges(model.num_moving(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) store(w.data(), i, model.mass[i] * load(w.data(), i));
  });
  report->correction = transfer.scatter(w.data(), model.num_moving(), forces);
}

void ConstrainedHost::find_nearest(const PointArray& positions, double time, PartReport* report) {
  place.stands = false;
  gather_positions(positions);
  std::copy_n(moved.data(), w.size(), w.begin());
  NearestPoint nearest(work, linearization, form.projector());
  ProjectionReport found = nearest.find(time, moved.data());
  report->take(std::move(found));
  note_worst_position(report);
  if (!report->outcome.ok()) return;
  // The start is off the constraints, so the rods there are seen from those at the end, whose lengths are known.
  std::vector<double> blocks(linearization.blocks().size());
  work.constraints.evaluate_gradients(model.parallel, moved.data(), blocks.data());
  report->largest_turn = sums.largest_turn(blocks.data(), moved.data(), w.data(), {});
}

void ConstrainedHost::write_nearest(const PointArray& positions, PartReport* report) {
  report->correction = write_moved(positions, true);
}

// ---- questions ----

void ConstrainedHost::find_violation(const ConstPointArray& positions, double time, PartReport* report) {
  gather_positions(positions);
  report->violation = work.position_violation(time, moved.data());
  note_worst_position(report);
}

LogDeterminant ConstrainedHost::find_log_det(const ConstPointArray& positions, bool with_gradient, double time) {
  if (!determinant) determinant = std::make_unique<SchurDeterminant>(work);
  LogDeterminant result;
  if (result.outcome = place.stand_at(positions, time); !result.outcome.ok()) return result;
  const double* const blocks = linearization.blocks().data();
  result.value = determinant->evaluate(blocks);
  if (!std::isfinite(result.value)) {
    result.outcome = {Status::Singular, work.name_row(determinant->dependent_row()) +
                                            " depends on other rows: S has no logarithm of its determinant"};
    return result;
  }
  if (!with_gradient) return result;
  work.set_time(time);
  const auto is_finite = [](double x) { return std::isfinite(x); };
  if (!std::ranges::all_of(determinant->find_gradient(place.r.data(), blocks), is_finite))
    result.outcome = {Status::NotFinite, "second derivatives of constraints are not finite at these positions"};
  return result;
}

void ConstrainedHost::write_gradient(const PointArray& wanted) const {
  transfer.write(determinant->gradient().data(), model.num_moving(), wanted);
  transfer.add_last(determinant->gradient().data(), model.num_moving(), 3, wanted);
}

RankReport ConstrainedHost::find_rank(const ConstPointArray& positions, double time) {
  (void)place.stand_at(positions, time);
  place.stands = false;
  return forms.rank(place.r.data(), true);
}

}  // namespace tanor::detail
