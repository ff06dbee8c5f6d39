#include <tanor/constrainer.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "base/live.hpp"
#include "base/quiet_traps.hpp"
#include "dynamics/nearest_point.hpp"
#include "host/constrained_host.hpp"
#include "host/host_input.hpp"

namespace tanor {

struct Constrainer::Implementation : ConstrainedHost {
  using ConstrainedHost::ConstrainedHost;
};

// ---- life ----

Constrainer::Constrainer(std::span<const double> masses, std::vector<Constraint> constraints, ConstPointArray at,
                         const SolverOptions& options) {
  check_array(at, masses.size(), 3, "positions");
  implementation_ = make_quietly<Implementation>(make_system(masses, std::move(constraints), at), options);
}
Constrainer::Constrainer(std::span<const double> masses, std::vector<Constraint> constraints, ConstPointArray at,
                         const Periodicity& periodicity, const SolverOptions& options) {
  check_array(at, masses.size(), 3, "positions");
  const QuietTraps quiet;
  System system = make_system(masses, std::move(constraints), at);
  validate(system);
  auto images = std::make_unique<PeriodicImages>(system, periodicity);
  images->prepare(&system);
  implementation_ = std::make_unique<Implementation>(std::move(system), options);
  images->use(implementation_->model.numbering);
  implementation_->set_images(std::move(images));
}
Constrainer::Constrainer(Constrainer&&) noexcept = default;
Constrainer& Constrainer::operator=(Constrainer&&) noexcept = default;
Constrainer::~Constrainer() = default;

void Constrainer::set_cell(const PeriodicCell& cell) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Constrainer");
  if (!self.images) throw InputError("/cell", "there is none; it is given where the Constrainer is made");
  if (cell == self.images->cell()) return;
  const PeriodicCell old = self.images->cell();
  self.images->set_cell(cell);
  try {
    self.check_cell();
  } catch (const InputError&) {
    self.images->set_cell(old);
    throw;
  }
  if (!self.images->close_ways()) return;
  auto planned = std::make_unique<Implementation>(self.move_offsets(), self.options);
  planned->set_images(std::move(self.images));
  implementation_ = std::move(planned);
}

std::size_t Constrainer::num_points() const {
  return live(implementation_, "Constrainer").num_points();
}
std::size_t Constrainer::num_rows() const {
  return live(implementation_, "Constrainer").model.num_rows();
}
std::string Constrainer::row_name(std::size_t row) const {
  const Implementation& self = live(implementation_, "Constrainer");
  if (row >= self.model.num_rows()) throw InputError("", "there is no row " + std::to_string(row));
  return equation_name(self.model.system, row);
}
const PlanSummary& Constrainer::plan() const {
  return live(implementation_, "Constrainer").forms.plan;
}
Counters Constrainer::counters() const {
  return live(implementation_, "Constrainer").work.counters;
}

// ---- a step ----

ConstraintReport Constrainer::constrain_positions(const PositionStep& step) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Constrainer");
  const std::size_t n = self.num_points();
  check_number(step.step, "step");
  check_number(step.time, "time");
  if (step.step == 0.0) throw InputError("", "step = 0: a step of no length has no velocities");
  require_array(step.old_positions, n, "old_positions");
  require_array(step.positions, n, "positions");
  check_array(step.velocities, n, 3, "velocities");
  self.check(step.wanted);
  if (step.old_cell != nullptr && self.images && self.images->close_ways() && *step.old_cell != self.images->cell())
    throw InputError("/cell", "rods close a way round the cell, so it cannot change within a step");

  ConstraintReport report;
  const double start = step.time - step.step;
  if (report.outcome = self.stand_at(step.old_positions, start, step.old_cell); !report.outcome.ok()) return report;
  if (report.outcome = self.check_place(); !report.outcome.ok()) return report;
  ProjectionReport found = self.step_positions(step);
  if (!found.outcome.ok()) {
    // The guess may have come from another motion.
    self.form.steps().forget_steps();
    if (report.outcome = self.linearization.update(start, self.place.r.data()); report.outcome.ok())
      found = self.step_positions(step);
  }
  report.outcome = std::move(found.outcome);
  report.iterations = found.iterations;
  report.violation = found.violation;
  if (!report.outcome.ok()) {
    self.place.stands = false;
    self.note_worst_position(&report);
    return report;
  }
  const double factor = 2.0 / step.step;  // of the sum over h
  self.multipliers = self.form.steps().sum().data();
  // Where K lost rank it stands elsewhere now, and the multipliers are not known.
  self.place.stands = self.model.num_rows() == 0 || std::isfinite(self.multipliers[0]);
  if (step.measures) self.measure_step(step, &report);
  self.write(factor, step.wanted);
  report.correction = self.scatter_moved(step.positions);
  if (step.velocities) self.transfer.write(self.v.data(), self.model.num_moving(), step.velocities);
  return report;
}

ConstraintReport Constrainer::constrain_velocities(const VelocityStep& step) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Constrainer");
  const std::size_t n = self.num_points();
  check_number(step.step, "step");
  check_number(step.time, "time");
  require_array(step.positions, n, "positions");
  require_array(step.velocities, n, "velocities");
  self.check(step.wanted);

  ConstraintReport report;
  if (report.outcome = self.stand_at(step.positions, step.time); !report.outcome.ok()) return report;
  // Small is what is small beside the velocities of this call.
  double speed = self.transfer.gather(step.velocities, self.v.data());
  if (self.work.constraints.depends_on_time()) {
    self.work.set_time(step.time);
    speed = larger(speed, self.linearization.evaluate_rates(self.place.r.data(), self.v.data(), self.rows.data()));
  }
  const bool sums_multipliers = step.measures || ConstrainedHost::wants_multipliers(step.wanted);
  if (sums_multipliers) std::fill(self.sum.begin(), self.sum.end(), 0.0);
  self.multipliers = self.sum.data();
  ProjectionReport found = self.form.projector().project_velocities(
      step.time, self.place.r.data(), self.v.data(), sums_multipliers ? self.sum.data() : nullptr, speed);
  report.outcome = std::move(found.outcome);
  report.iterations = found.iterations;
  report.violation = found.violation;
  if (!report.outcome.ok()) self.place.stands = false;
  if (self.model.num_rows() > 0 && (step.measures || !report.outcome.ok())) {
    (void)self.linearization.evaluate_rates(self.place.r.data(), self.v.data(), self.rows.data());
    report.worst_row = self.user_row(RowSums::worst_row(self.rows));
  }
  if (!report.outcome.ok()) return report;
  const double factor = step.step != 0.0 ? 2.0 / step.step : 1.0;
  if (step.measures) {
    report.virial = self.sums.virial(self.multipliers, factor, self.linearization.blocks().data(), self.place.r.data());
    report.work = factor * self.support_work(step.step);
  }
  self.write(factor, step.wanted);
  report.correction = self.transfer.scatter(self.v.data(), self.model.num_moving(), step.velocities);
  return report;
}

// ---- an instant ----

ConstraintReport Constrainer::solve(const HostState& at) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Constrainer");
  const std::size_t n = self.num_points();
  check_number(at.time, "time");
  require_array(at.positions, n, "positions");
  require_array(at.velocities, n, "velocities");
  require_array(at.forces, n, "forces");
  check_array(at.accelerations, n, 3, "accelerations");
  self.check(at.wanted);

  ConstraintReport report;
  const bool stood = self.gather_place(at.positions, at.time, self.present_cell());
  const double* const v = self.read(at.velocities, &self.v);
  ForwardDynamics& dynamics = self.form.dynamics();
  const Request request{.gradients = stood ? Gradients::Keep : Gradients::Evaluate,
                        .exact = true,
                        .forces = self.read(at.forces, &self.f)};
  report.outcome = dynamics.solve({at.time, self.place.r.data(), v}, request, self.w.data());
  self.place.stands = report.outcome.ok();
  report.iterations = dynamics.report().refinements;
  report.violation = dynamics.report().residual;
  if (!report.outcome.ok()) return report;
  self.multipliers = dynamics.multipliers().data();
  const double* const blocks = self.linearization.blocks().data();
  if (at.accelerations) self.transfer.write(self.w.data(), n, at.accelerations);
  if (at.measures && self.model.num_rows() > 0) {
    (void)self.linearization.evaluate_right_side(self.place.r.data(), v, self.w.data(), false, self.rows.data());
    report.worst_row = self.user_row(RowSums::worst_row(self.rows));
    report.virial = self.sums.virial(self.multipliers, 1.0, blocks, self.place.r.data());
  }
  self.write(1.0, at.wanted);
  return report;
}

ConstraintReport Constrainer::project_forces(ConstPointArray positions, PointArray forces, double time) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Constrainer");
  const Model& model = self.model;
  check_number(time, "time");
  require_array(positions, self.num_points(), "positions");
  require_array(forces, self.num_points(), "forces");
  ConstraintReport report;
  if (report.outcome = self.stand_at(positions, time); !report.outcome.ok()) return report;
  (void)self.transfer.gather(forces, self.f.data());
  const double scale = self.work.accelerate(self.f.data(), self.w.data());  // w = M^-1 f
  std::fill(self.w.begin() + static_cast<std::ptrdiff_t>(3 * model.num_moving()), self.w.end(), 0.0);
  if (!std::isfinite(scale)) return report.outcome = model.not_finite(time), report;
  if (model.num_rows() == 0 || scale == 0.0) return report;
  // S nu = -K'w, w += M^-1 K nu
  constexpr double target = 1e-15;
  constexpr int most_corrections = 5;
  const auto measure = [&] {
    return self.linearization.apply_transposed(self.w.data(), nullptr, self.rows.data()) / scale;
  };
  report.violation = measure();
  double before = std::numeric_limits<double>::infinity();
  while (report.violation > target && report.violation < 0.5 * before && report.iterations < most_corrections) {
    self.linearization.correct_conjugately(report.iterations == 0, self.rows.data(), self.w.data());
    before = report.violation;
    report.violation = measure();
    ++report.iterations;
  }
  report.worst_row = self.user_row(RowSums::worst_row(self.rows));
  for (std::size_t k = 0; k < 3 * model.num_moving(); ++k) self.w[k] *= model.mass[k / 3];
  report.correction = self.transfer.scatter(self.w.data(), model.num_moving(), forces);
  return report;
}

ConstraintReport Constrainer::project_positions(PointArray positions, double time) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Constrainer");
  check_number(time, "time");
  require_array(positions, self.num_points(), "positions");
  self.place.stands = false;
  self.gather_moved(positions);
  NearestPoint nearest(self.work, self.linearization, self.form.projector());
  ProjectionReport found = nearest.find(time, self.r.data());
  ConstraintReport report{
      .outcome = std::move(found.outcome), .iterations = found.iterations, .violation = found.violation};
  if (self.model.num_rows() > 0) self.note_worst_position(&report);
  if (report.outcome.ok()) report.correction = self.scatter_moved(positions);
  return report;
}

// ---- questions ----

LogDeterminant Constrainer::log_det(ConstPointArray positions, PointArray gradient, double time) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Constrainer");
  check_number(time, "time");
  require_array(positions, self.num_points(), "positions");
  check_array(gradient, self.num_points(), 3, "gradient");
  if (!self.determinant) self.determinant = std::make_unique<SchurDeterminant>(self.work);
  if (gradient && !self.determinant->has_gradient())
    throw InputError("", "the gradient of log_det is known for rods alone; there are other constraints");
  LogDeterminant result;
  if (result.outcome = self.stand_at(positions, time); !result.outcome.ok()) return result;
  const double* const blocks = self.linearization.blocks().data();
  result.value = self.determinant->evaluate(blocks);
  if (!std::isfinite(result.value)) {
    result.outcome = {Status::Singular, self.work.name_row(self.determinant->dependent_row()) +
                                            " depends on other rows: S has no logarithm of its determinant"};
    return result;
  }
  if (!gradient) return result;
  self.determinant->write_gradient(blocks, self.sums.lengths().data(), self.eta.data());
  self.transfer.write(self.eta.data(), self.num_points(), gradient);
  return result;
}

ConstraintReport Constrainer::violation(ConstPointArray positions, double time) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Constrainer");
  check_number(time, "time");
  require_array(positions, self.num_points(), "positions");
  self.gather_moved(positions);
  ConstraintReport report;
  report.violation = self.work.position_violation(time, self.r.data());
  self.note_worst_position(&report);
  return report;
}

RankReport Constrainer::rank(ConstPointArray positions, double time) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Constrainer");
  check_number(time, "time");
  require_array(positions, self.num_points(), "positions");
  (void)self.stand_at(positions, time);
  self.place.stands = false;
  return self.forms.rank(self.place.r.data(), true);
}

}  // namespace tanor
