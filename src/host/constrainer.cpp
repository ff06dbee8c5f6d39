#include <tanor/constrainer.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "base/live.hpp"
#include "base/quiet_traps.hpp"
#include "base/text.hpp"
#include "dynamics/forms.hpp"
#include "dynamics/nearest_point.hpp"
#include "host/point_transfer.hpp"
#include "host/row_sums.hpp"
#include "host/schur_determinant.hpp"

namespace tanor {

namespace {

/// The host's masses and positions as a System; points of infinite mass are supports.
System make_system(std::span<const double> masses, std::vector<Constraint> constraints, const ConstPointArray& at) {
  if (!at) throw InputError("", "positions are missing");
  System system;
  system.masses.assign(masses.begin(), masses.end());
  system.constraints = std::move(constraints);
  const std::ptrdiff_t stride = at.stride != 0 ? at.stride : static_cast<std::ptrdiff_t>(3 * sizeof(double));
  const auto* const bytes = reinterpret_cast<const std::byte*>(at.data);
  Support supports{"supports", {}, {}};
  for (std::size_t i = 0; i < masses.size(); ++i) {
    const std::ptrdiff_t number = at.index != nullptr ? at.index[i] : static_cast<std::ptrdiff_t>(i);
    const auto* const point = reinterpret_cast<const double*>(bytes + number * stride);
    system.positions.insert(system.positions.end(), point, point + 3);
    if (masses[i] != std::numeric_limits<double>::infinity()) continue;
    supports.points.push_back(static_cast<Index>(i));
    system.masses[i] = 1.0;
  }
  if (!supports.points.empty()) system.supports = {supports};
  return system;
}

SolverOptions without_reuse(SolverOptions options) {
  options.reuse = false;  // of factors inside the steps of methods
  return options;
}

template <class Number>
void check_array(const BasicPointArray<Number>& array, std::size_t num_points, std::size_t width, const char* name) {
  if (!array || array.index != nullptr || array.size >= width * num_points) return;
  throw InputError("", std::string(name) + " has " + std::to_string(array.size) + " numbers; " +
                           std::to_string(width * num_points) + " are needed");
}

template <class Number>
void require_array(const BasicPointArray<Number>& array, std::size_t num_points, const char* name) {
  if (!array && num_points > 0) throw InputError("", std::string(name) + " are missing");
  check_array(array, num_points, 3, name);
}

void check_number(double number, const char* name) {
  if (!std::isfinite(number)) throw InputError("", std::string(name) + " = " + text(number) + " is not a number");
}

}  // namespace

/// Everything in the inner order, and what is known from call to call.
struct Constrainer::Implementation {
  Forms forms;
  Model& model = forms.model;
  MultiplierForm& form = *forms.normal;
  Linearization& linearization = form.linearization();
  const PointTransfer transfer{model.numbering, model.parallel};
  RowSums sums{model};
  // K and the factor of S stand at these positions [3n] and this time, where `stands`.
  std::vector<double> place;
  double place_time = 0.0;
  bool stands = false;
  bool was_checked = false;  // the host's first positions were on the constraints
  // Scratch: [3n] each, then [d] each.
  std::vector<double> r, v, f, w, eta;
  std::vector<double> rows, multipliers;
  std::vector<double> stress;                     // [9n], made where it is first wanted
  std::unique_ptr<SchurDeterminant> determinant;  // likewise

  Implementation(System system, const SolverOptions& options) : forms(std::move(system), without_reuse(options)) {
    for (std::vector<double>* array : {&place, &r, &v, &f, &w, &eta}) array->resize(3 * num_points());
    for (std::vector<double>* array : {&rows, &multipliers}) array->resize(model.num_rows());
  }

  std::size_t num_points() const { return model.num_points(); }
  /// The host's name for an inner row.
  std::size_t user_row(std::size_t row) const { return static_cast<std::size_t>(model.numbering.user_row[row]); }

  void check(const ConstraintForces& wanted) const {
    if (!wanted.multipliers.empty() && wanted.multipliers.size() != model.num_rows()) {
      throw InputError("", "multipliers has " + std::to_string(wanted.multipliers.size()) + " numbers; " +
                               std::to_string(model.num_rows()) + " are needed");
    }
    check_array(wanted.forces, num_points(), 3, "forces");
    check_array(wanted.stress, num_points(), 9, "stress");
  }
  static bool wants_multipliers(const ConstraintForces& wanted) {
    return !wanted.multipliers.empty() || wanted.forces || wanted.stress;
  }

  bool gather_place(const ConstPointArray& positions, double t);
  Outcome stand_at(const ConstPointArray& positions, double t);
  Outcome check_place();
  ProjectionReport step_positions(const PositionStep& step);
  double support_work(double h);
  void measure_step(const PositionStep& step, ConstraintReport* report);
  void write(double factor, const ConstraintForces& wanted);
  void note_worst_position(ConstraintReport* report);
};

/// `place` := the host's positions. Returns whether K and the factor of S stand there already.
bool Constrainer::Implementation::gather_place(const ConstPointArray& positions, double t) {
  const bool is_elsewhere = transfer.gather_changes(positions, place.data());
  const bool is_other_time = t != std::exchange(place_time, t) && model.constraints.depends_on_time();
  stands = stands && !is_elsewhere && !is_other_time && linearization.has_factor();
  return stands;
}

/// K and the factor of S at the host's positions.
Outcome Constrainer::Implementation::stand_at(const ConstPointArray& positions, double t) {
  if (gather_place(positions, t)) return {};
  Outcome outcome = linearization.update(t, place.data());
  stands = outcome.ok();
  const auto is_finite = [](double x) { return std::isfinite(x); };
  if (!stands && !std::ranges::all_of(place, is_finite)) return model.not_finite(t);
  return outcome;
}

/// A step from positions off the constraints would put its correction into the velocities.
Outcome Constrainer::Implementation::check_place() {
  constexpr double allowed = 1e-8;
  if (was_checked) return {};
  const double violation = linearization.evaluate_values(place.data(), rows.data());
  was_checked = violation <= allowed;
  if (was_checked) return {};
  if (!std::isfinite(violation)) return model.not_finite(place_time);
  return {Status::NotConverged, "the positions where the step begins violate " +
                                    model.name_row(sums.worst_position_row(rows)) + " by " + text(violation) +
                                    " of its length; project_positions puts them right, before the first forces"};
}

/// The host's positions into `r` and velocities into `v`, moved onto the constraints.
ProjectionReport Constrainer::Implementation::step_positions(const PositionStep& step) {
  transfer.gather(step.positions, r.data());
  if (step.velocities) transfer.gather(step.velocities, v.data());
  return form.steps().project_step(step.time, step.step, r.data(), step.velocities ? v.data() : nullptr);
}

/// -h/2 lambda'(K'v_s + xi_t) with the velocities v_s of supports, those in `v`: what lengths that depend on time, and
/// supports that move, do to the points by the `multipliers`.
double Constrainer::Implementation::support_work(double h) {
  const auto moving = static_cast<std::ptrdiff_t>(3 * model.num_moving());
  std::fill(w.begin(), w.begin() + moving, 0.0);
  std::copy(v.begin() + moving, v.end(), w.begin() + moving);
  const bool rest = std::all_of(w.begin() + moving, w.end(), [](double x) { return x == 0.0; });
  if ((rest && !model.constraints.depends_on_time()) || model.num_rows() == 0) return 0.0;
  (void)linearization.evaluate_rates(place.data(), w.data(), rows.data());
  return -0.5 * h * model.parallel.sum(rows.size(), [&](std::size_t a) { return multipliers[a] * rows[a]; });
}

/// Writes what is wanted of the `multipliers` times `factor`, which belong to the K that stands.
void Constrainer::Implementation::write(double factor, const ConstraintForces& wanted) {
  const double* const blocks = linearization.blocks().data();
  if (!wanted.multipliers.empty()) {
    model.parallel.for_ranges(multipliers.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t a = begin; a < end; ++a) wanted.multipliers[user_row(a)] = factor * multipliers[a];
    });
  }
  if (wanted.forces) {
    model.gather.reactions(model.parallel, blocks, multipliers.data(), eta.data());
    for (double& number : eta) number *= factor;
    (void)transfer.scatter(eta.data(), num_points(), wanted.forces);
  }
  if (wanted.stress) {
    stress.resize(9 * num_points());
    sums.share_virial(multipliers.data(), factor, blocks, place.data(), stress.data());
    transfer.scatter_tensors(stress.data(), wanted.stress);
  }
}

void Constrainer::Implementation::note_worst_position(ConstraintReport* report) {
  if (rows.empty()) return;
  (void)linearization.evaluate_values(r.data(), rows.data());
  report->worst_row = user_row(sums.worst_position_row(rows));
}

/// What a step from `place` to `r` says beside the positions.
void Constrainer::Implementation::measure_step(const PositionStep& step, ConstraintReport* report) {
  note_worst_position(report);
  model.set_time(step.time - step.step);
  const double factor = 2.0 / step.step;
  const double* const blocks = linearization.blocks().data();
  report->virial = sums.virial(multipliers.data(), factor, blocks, place.data());
  report->largest_turn = sums.largest_turn(blocks, place.data(), r.data());
  for (std::size_t k = 3 * model.num_moving(); k < v.size() && !step.velocities; ++k)
    v[k] = (r[k] - place[k]) / step.step;
  report->work = factor * support_work(step.step);
}

// ---- life ----

Constrainer::Constrainer(std::span<const double> masses, std::vector<Constraint> constraints, ConstPointArray at,
                         const SolverOptions& options) {
  check_array(at, masses.size(), 3, "positions");
  implementation_ = make_quietly<Implementation>(make_system(masses, std::move(constraints), at), options);
}
Constrainer::Constrainer(Constrainer&&) noexcept = default;
Constrainer& Constrainer::operator=(Constrainer&&) noexcept = default;
Constrainer::~Constrainer() = default;

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
  return live(implementation_, "Constrainer").model.counters;
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

  ConstraintReport report;
  const double start = step.time - step.step;
  if (report.outcome = self.stand_at(step.old_positions, start); !report.outcome.ok()) return report;
  if (report.outcome = self.check_place(); !report.outcome.ok()) return report;
  ProjectionReport found = self.step_positions(step);
  if (!found.outcome.ok()) {
    // The guess may have come from another motion.
    self.form.steps().forget_steps();
    if (report.outcome = self.linearization.update(start, self.place.data()); report.outcome.ok())
      found = self.step_positions(step);
  }
  report.outcome = std::move(found.outcome);
  report.iterations = found.iterations;
  report.violation = found.violation;
  if (!report.outcome.ok()) {
    self.stands = false;
    self.note_worst_position(&report);
    return report;
  }
  const double factor = 2.0 / step.step;  // of the sum over h
  self.multipliers = self.form.steps().sum();
  // Where K lost rank it stands elsewhere now, and the multipliers are not known.
  self.stands = self.multipliers.empty() || std::isfinite(self.multipliers[0]);
  if (step.measures) self.measure_step(step, &report);
  self.write(factor, step.wanted);
  const std::size_t moving = self.model.num_moving();
  report.correction = self.transfer.scatter(self.r.data(), moving, step.positions);
  if (step.velocities) (void)self.transfer.scatter(self.v.data(), moving, step.velocities);
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
  if (self.model.constraints.depends_on_time()) {
    self.model.set_time(step.time);
    speed = larger(speed, self.linearization.evaluate_rates(self.place.data(), self.v.data(), self.rows.data()));
  }
  const bool sums_multipliers = step.measures || Implementation::wants_multipliers(step.wanted);
  if (sums_multipliers) std::fill(self.multipliers.begin(), self.multipliers.end(), 0.0);
  ProjectionReport found = self.form.projector().project_velocities(
      step.time, self.place.data(), self.v.data(), sums_multipliers ? self.multipliers.data() : nullptr, speed);
  report.outcome = std::move(found.outcome);
  report.iterations = found.iterations;
  report.violation = found.violation;
  if (!report.outcome.ok()) self.stands = false;
  if (self.model.num_rows() > 0 && (step.measures || !report.outcome.ok())) {
    (void)self.linearization.evaluate_rates(self.place.data(), self.v.data(), self.rows.data());
    report.worst_row = self.user_row(RowSums::worst_row(self.rows));
  }
  if (!report.outcome.ok()) return report;
  const double factor = step.step != 0.0 ? 2.0 / step.step : 1.0;
  if (step.measures) {
    report.virial =
        self.sums.virial(self.multipliers.data(), factor, self.linearization.blocks().data(), self.place.data());
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
  const bool stood = self.gather_place(at.positions, at.time);
  (void)self.transfer.gather(at.velocities, self.v.data());
  (void)self.transfer.gather(at.forces, self.f.data());
  ForwardDynamics& dynamics = self.form.dynamics();
  const Request request{
      .gradients = stood ? Gradients::Keep : Gradients::Evaluate, .exact = true, .forces = self.f.data()};
  report.outcome = dynamics.solve({at.time, self.place.data(), self.v.data()}, request, self.w.data());
  self.stands = report.outcome.ok();
  report.iterations = dynamics.report().refinements;
  report.violation = dynamics.report().residual;
  if (!report.outcome.ok()) return report;
  self.multipliers = dynamics.multipliers();
  const double* const blocks = self.linearization.blocks().data();
  if (at.accelerations) (void)self.transfer.scatter(self.w.data(), n, at.accelerations);
  if (at.measures && self.model.num_rows() > 0) {
    (void)self.linearization.evaluate_right_side(self.place.data(), self.v.data(), self.w.data(), false,
                                                 self.rows.data());
    report.worst_row = self.user_row(RowSums::worst_row(self.rows));
    report.virial = self.sums.virial(self.multipliers.data(), 1.0, blocks, self.place.data());
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
  const double scale = model.accelerate(self.f.data(), self.w.data());  // w = M^-1 f
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
  self.stands = false;
  (void)self.transfer.gather(positions, self.r.data());
  NearestPoint nearest(self.model, self.linearization, self.form.projector());
  ProjectionReport found = nearest.find(time, self.r.data());
  ConstraintReport report{
      .outcome = std::move(found.outcome), .iterations = found.iterations, .violation = found.violation};
  if (self.model.num_rows() > 0) self.note_worst_position(&report);
  if (report.outcome.ok()) report.correction = self.transfer.scatter(self.r.data(), self.model.num_moving(), positions);
  return report;
}

// ---- questions ----

LogDeterminant Constrainer::log_det(ConstPointArray positions, PointArray gradient, double time) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Constrainer");
  check_number(time, "time");
  require_array(positions, self.num_points(), "positions");
  check_array(gradient, self.num_points(), 3, "gradient");
  if (!self.determinant) self.determinant = std::make_unique<SchurDeterminant>(self.model);
  if (gradient && !self.determinant->has_gradient())
    throw InputError("", "the gradient of log_det is known for rods alone; there are other constraints");
  LogDeterminant result;
  if (result.outcome = self.stand_at(positions, time); !result.outcome.ok()) return result;
  const double* const blocks = self.linearization.blocks().data();
  result.value = self.determinant->evaluate(blocks);
  if (!std::isfinite(result.value)) {
    result.outcome = {Status::Singular, self.model.name_row(self.determinant->dependent_row()) +
                                            " depends on other rows: S has no logarithm of its determinant"};
    return result;
  }
  if (!gradient) return result;
  self.determinant->write_gradient(blocks, self.sums.lengths().data(), self.eta.data());
  (void)self.transfer.scatter(self.eta.data(), self.num_points(), gradient);
  return result;
}

ConstraintReport Constrainer::violation(ConstPointArray positions, double time) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Constrainer");
  check_number(time, "time");
  require_array(positions, self.num_points(), "positions");
  (void)self.transfer.gather(positions, self.r.data());
  ConstraintReport report;
  report.violation = self.model.position_violation(time, self.r.data());
  self.note_worst_position(&report);
  return report;
}

RankReport Constrainer::rank(ConstPointArray positions, double time) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Constrainer");
  check_number(time, "time");
  require_array(positions, self.num_points(), "positions");
  (void)self.stand_at(positions, time);
  self.stands = false;
  return self.forms.rank(self.place.data(), true);
}

}  // namespace tanor
