#include <tanor/motion.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "dynamics/certificate.hpp"
#include "motion/equal_steps.hpp"
#include "motion/scheme.hpp"
#include "motion/step_control.hpp"
#include "system/text.hpp"

namespace tanor {

namespace {

void check_options(const MotionOptions& options) {
  const auto positive = [](const char* where, double value, const char* rule) {
    if (!(value > 0.0 && std::isfinite(value))) throw InputError(where, text(value) + " is not " + rule);
  };
  if (options.step != 0.0) positive("/motion/step", options.step, "a positive step, s");
  positive("/motion/rtol", options.rtol, "a positive tolerance");
  positive("/motion/atol", options.atol, "a positive tolerance, m and m/s");
}

Method resolve(const MotionOptions& options) {
  if (options.method != Method::Auto) return options.method;
  return options.step > 0.0 ? Method::Rk4 : Method::Dopri5;
}

/// rattle projects onto constraints: it steps in normal form.
SolverOptions resolve(SolverOptions solver, const System& system, Method method) {
  if (method != Method::Rattle || system.coordinates.empty()) return solver;
  if (solver.form == Form::Tangent || num_equations(system) == 0) {
    throw InputError("/motion/method",
                     "rattle projects onto constraints, the tangent form has none; rk4 and dopri5 "
                     "step in coordinates");
  }
  solver.form = Form::Normal;
  return solver;
}

void check_snapshot(const Snapshot& snapshot, std::size_t size) {
  const auto check_finite = [](const char* where, std::span<const double> numbers) {
    const auto bad = std::find_if_not(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
    if (bad != numbers.end()) throw InputError(where, text(*bad) + " is not a finite number");
  };
  const auto check_points = [&](const char* where, const std::vector<double>& numbers) {
    if (numbers.size() != size) {
      throw InputError(where, "holds " + std::to_string(numbers.size()) + " numbers, the system's points have " +
                                  std::to_string(size));
    }
    check_finite(where, numbers);
  };
  check_points("/snapshot/positions", snapshot.positions);
  check_points("/snapshot/velocities", snapshot.velocities);
  const EnergyReport& energy = snapshot.report.energy;
  check_finite("/snapshot/time", std::array{snapshot.time});
  check_finite("/snapshot/report/energy", std::array{energy.start, energy.work_of_supports, energy.work_of_forces});
  const auto check_size = [](const char* where, double value) {
    if (!(value >= 0.0 && std::isfinite(value)))
      throw InputError(where, text(value) + " is not 0 or a positive number");
  };
  check_size("/snapshot/next_step", snapshot.next_step);
  check_size("/snapshot/last_error", snapshot.last_error);
}

}  // namespace

double EnergyReport::drift_relative() const {
  const double drift = now - start - work_of_supports - work_of_forces - work_of_friction;
  return scale > 0.0 ? drift / scale : 0.0;
}

struct Simulation::Implementation {
  static constexpr int most_splits = 8;  // of a fixed step that fails

  MotionOptions options;
  SolverOptions solver_options;
  Forms forms;
  Model& model = forms.model;
  EquationsOfMotion& form = *forms.main;
  std::unique_ptr<Scheme> scheme;
  State state, trial;
  StepControl control;
  double next_step = 0.0;                         // adaptive: wanted by the control; 0: not known yet
  double advance_begin = 0.0, advance_end = 0.0;  // of the last advance in equal steps
  Outcome outcome;
  MotionReport report;
  // The state in the user's order.
  std::vector<double> r, v, w, lambda, eta, carried, q, q_dot;
  struct {
    std::vector<double> r, v, w;
  } points;                  // the state [3n] in the inner order
  std::vector<double> rows;  // [d]

  Implementation(System system, const MotionOptions& motion, const SolverOptions& solver, double t_start)
      : options((check_options(motion), motion)),
        solver_options(resolve(solver, system, resolve(motion))),
        forms(std::move(system), solver_options, t_start),
        scheme(make_scheme(resolve(motion), options, form)),
        control(scheme->order()) {
    report.method = resolve(motion);
    if (!scheme->is_adaptive() && !(options.step > 0.0)) {
      throw InputError("/motion/step", "method " + std::string(method_name(report.method)) +
                                           " has fixed steps: a positive step, s, is needed");
    }
    for (State* s : {&state, &trial}) {
      for (std::vector<double>* array : {&s->x, &s->v, &s->a}) array->resize(form.size());
    }
    for (std::vector<double>* array : {&points.r, &points.v, &points.w, &r, &v, &w, &eta, &carried}) {
      array->resize(3 * model.num_points());
    }
    for (std::vector<double>* array : {&q, &q_dot}) array->resize(forms.is_tangent() ? form.size() : 0);
    lambda.resize(model.numbering.num_user_rows);
    rows.resize(model.num_rows());

    state.t = t_start;
    model.numbering.gather_points(model.system.positions, points.r);
    model.numbering.gather_points(model.system.velocities, points.v);
    report.time = t_start;
    report.start = forms.start(t_start, points.r.data(), points.v.data(), options.start);
    outcome = report.start.outcome;
    if (outcome.ok()) outcome = complete_state();
    measure_start();
    publish();
  }

  Snapshot snapshot() {
    write_points();
    Snapshot snapshot{.time = state.t,
                      .positions = std::vector<double>(points.r.size()),
                      .velocities = std::vector<double>(points.v.size()),
                      .report = report,
                      .next_step = next_step,
                      .last_error = control.last_error(),
                      .advance_begin = advance_begin,
                      .advance_end = advance_end};
    model.numbering.scatter_points(points.r, snapshot.positions);
    model.numbering.scatter_points(points.v, snapshot.velocities);
    return snapshot;
  }

  void restore(const Snapshot& snapshot) {
    check_snapshot(snapshot, points.r.size());
    report = snapshot.report;
    report.method = resolve(options);
    report.time = snapshot.time;
    next_step = snapshot.next_step;
    advance_begin = snapshot.advance_begin;
    advance_end = snapshot.advance_end;
    control = StepControl(scheme->order(), snapshot.last_error);
    scheme = make_scheme(report.method, options, form);  // which remembers no other motion
    form.resume(report.counters, report.times);

    state.t = snapshot.time;
    model.numbering.gather_points(snapshot.positions, points.r);
    model.numbering.gather_points(snapshot.velocities, points.v);
    state.work = {.supports = report.energy.work_of_supports, .forces = report.energy.work_of_forces};
    model.prescribe_all(state.t, points.r.data(), points.v.data());
    outcome = complete_state();
    publish();
  }

  /// The state at t from its points, with all that belongs to it.
  Outcome complete_state() {
    Outcome found = form.adopt(state.t, points.r.data(), points.v.data(), state.x.data(), state.v.data());
    if (found.ok()) found = form.linearise(state.t, state.x.data());
    if (found.ok()) found = refresh(Gradients::Keep);
    if (found.ok() && form.has_work()) state.power = form.power(state.x.data(), state.v.data());
    trial = state;  // fixed supports stand in both
    return found;
  }

  void write_points() {
    form.write_points(state.t, state.x.data(), state.v.data(), state.a.data(), points.r.data(), points.v.data(),
                      points.w.data());
  }

  double position_violation() { return model.position_violation(state.t, points.r.data()); }
  double velocity_violation() { return model.velocity_violation(state.t, points.r.data(), points.v.data()); }

  void measure_start() {
    const Energy energy = form.energy(state.t, state.x.data(), state.v.data());
    report.energy.start = energy.kinetic + energy.potential;
    report.energy.scale = std::max(std::abs(report.energy.start), energy.kinetic);
    report.energy.now = report.energy.start;
    report.position_violation = position_violation();
    report.velocity_violation = velocity_violation();
    report.reciprocal_condition = form.last_solve().reciprocal_condition;
    report.reciprocal_condition_time = state.t;
    report.acceleration_violation = form.last_solve().residual;
  }

  /// Projections know what they leave; without them it is measured here.
  void measure_violations(const StepResult& step) {
    double position = step.position_violation, velocity = step.velocity_violation;
    if (options.stabilisation == Stabilisation::None) {
      write_points();
      position = position_violation();
      velocity = velocity_violation();
    }
    report.position_violation = std::max(report.position_violation, position);
    report.velocity_violation = std::max(report.velocity_violation, velocity);
  }

  void measure_step(const StepResult& step) {
    ++report.steps;
    report.time = state.t;
    measure_violations(step);
    if (form.last_solve().reciprocal_condition < report.reciprocal_condition) {
      report.reciprocal_condition = form.last_solve().reciprocal_condition;
      report.reciprocal_condition_time = state.t;
    }
    report.acceleration_violation = std::max(report.acceleration_violation, form.last_solve().residual);
    const Energy energy = form.energy(state.t, state.x.data(), state.v.data());
    report.energy.now = energy.kinetic + energy.potential;
    report.energy.scale = std::max(report.energy.scale, energy.kinetic);
    report.energy.work_of_supports = state.work.supports;
    report.energy.work_of_forces = state.work.forces;
    report.counters = model.counters;
    report.times = model.times;
    if (report.rank_changes.count != model.rank_changes.count) report.rank_changes = model.rank_changes;
  }

  /// Points that do not move though K alone would let them.
  std::vector<Index> find_taut() {
    constexpr double rounding = 1e-12;  // lengths that are not those of the given places: another system
    if (!outcome.ok() || model.rank_changes.count == 0 || report.start.relative > rounding) return {};
    return find_rank().taut_points;
  }

  RankReport find_rank() {
    write_points();
    return forms.rank(points.r.data(), false);
  }

  /// The state in the user's order.
  void publish() {
    write_points();
    const Numbering& numbering = model.numbering;
    numbering.scatter_points(points.r, r);
    numbering.scatter_points(points.v, v);
    numbering.scatter_points(points.w, w);
    if (forms.is_tangent()) {
      model.coordinates.scatter(state.x.data(), q.data());
      model.coordinates.scatter(state.v.data(), q_dot.data());
    }
    const Outcome known = forms.reactions(state.t, points.r.data(), points.v.data(), rows.data(), points.w.data());
    if (outcome.ok()) outcome = known;
    numbering.scatter_rows(rows, lambda);
    numbering.scatter_points(points.w, eta);
    // What supports carry: eta + f there
    for (std::size_t i = 0; i < 3 * model.num_moving(); ++i) points.w[i] = 0.0;
    for (std::size_t i = 3 * model.num_moving(); i < points.w.size(); ++i) points.w[i] += model.f[i];
    numbering.scatter_points(points.w, carried);
    report.counters = model.counters;
    report.times = model.times;
    report.rank_changes = model.rank_changes;
  }

  Certificate certify() {
    Outcome found = form.accelerations(state.t, state.x.data(), state.v.data(), Gradients::Evaluate, trial.a.data());
    if (!found.ok()) return make_failed_certificate(found);
    std::vector<double> at_r(points.r.size()), at_v(at_r), at_w(at_r), at_eta(at_r);
    form.write_points(state.t, state.x.data(), state.v.data(), trial.a.data(), at_r.data(), at_v.data(), at_w.data());
    found = forms.reactions(state.t, at_r.data(), at_v.data(), rows.data(), at_eta.data());
    if (!found.ok()) return make_failed_certificate(found);
    return tanor::certify(forms, {state.t, at_r, at_v, at_w, at_eta, rows});
  }

  /// Accelerations and multipliers at the state itself, after steps that left others behind.
  Outcome refresh(Gradients gradients) {
    return form.accelerations(state.t, state.x.data(), state.v.data(), gradients, state.a.data());
  }

  /// A first step from the time in which velocities or positions change by themselves.
  double first_step(double span) {
    if (options.step > 0.0) return std::min(options.step, span);
    write_points();
    const double speed = std::max(model.largest_norm(points.v.data()), model.velocity_scale);
    const double acceleration = model.largest_norm(points.w.data());
    const double time = acceleration > 0.0 ? speed / acceleration : span;
    return std::min(span, time * std::pow(options.rtol, 1.0 / scheme->order()));
  }

  Outcome advance(double t_end, const Observer& observer) {
    if (!outcome.ok()) return outcome;
    if (!(t_end > state.t) || !std::isfinite(t_end)) {
      throw InputError("/motion/t_end", text(t_end) + " does not lie after the time reached, " + text(state.t));
    }
    outcome = scheme->is_adaptive() ? advance_adaptively(t_end, observer) : advance_in_equal_steps(t_end, observer);
    const bool rejected_last = !outcome.ok();
    if (rejected_last || !scheme->knows_acceleration()) {
      const Outcome at_state = refresh(rejected_last ? Gradients::Evaluate : Gradients::Keep);
      if (outcome.ok()) outcome = at_state;
    }
    publish();
    return outcome;
  }

  /// A step that was accepted.
  void take_trial(const StepResult& step, double h) {
    std::swap(state, trial);
    form.recentre(state.t, state.x.data(), state.v.data(), state.a.data());
    report.last_step = h;
    measure_step(step);
  }

  /// A fixed step; one that fails is tried again in halves.
  Outcome step_or_split(double t, int splits_left) {
    trial.t = t;
    const double h = t - state.t;
    const StepResult step = scheme->step(state, h, &trial);
    if (step.outcome.ok()) {
      take_trial(step, h);
      return {};
    }
    if (splits_left == 0) return step.outcome;
    ++report.rejected;
    if (Outcome back = form.linearise(state.t, state.x.data()); !back.ok()) return back;
    if (Outcome first = step_or_split(state.t + 0.5 * h, splits_left - 1); !first.ok()) return first;
    return step_or_split(t, splits_left - 1);
  }

  Outcome step_too_small(double resolution, const Outcome& reason) const {
    return {Status::StepTooSmall, "the step falls below " + text(resolution) + " s at t = " + text(state.t) +
                                      (reason.ok() ? "" : ": " + reason.what)};
  }

  /// Steps of at most `options.step` that end exactly at t_end. An advance that was stopped on its way there goes on
  /// with its own steps.
  Outcome advance_in_equal_steps(double t_end, const Observer& observer) {
    EqualSteps steps(advance_begin, t_end, options.step);
    double k = steps.nearest(state.t);
    if (advance_end != t_end || steps.time(k) != state.t) {
      steps = EqualSteps(state.t, t_end, options.step);
      k = 0.0;
    }
    advance_begin = steps.begin();
    advance_end = t_end;
    const double resolution =
        16.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(t_end), std::abs(state.t));
    if (steps.length() < resolution) return step_too_small(resolution, {});
    while (k < steps.count()) {
      if (Outcome found = step_or_split(steps.time(++k), most_splits); !found.ok()) return found;
      if (observer && !observer(report)) break;
    }
    return {};
  }

  Outcome advance_adaptively(double t_end, const Observer& observer) {
    if (next_step == 0.0) next_step = first_step(t_end - state.t);
    while (state.t < t_end) {
      // End exactly at t_end, without a tiny last step.
      const double left = t_end - state.t;
      const bool last = next_step >= 0.99 * left;
      const double h = last ? left : std::min(next_step, 0.51 * left > next_step ? next_step : 0.5 * left);
      trial.t = last ? t_end : state.t + h;
      const StepResult step = scheme->step(state, h, &trial);
      if (!step.outcome.ok() || !(step.error <= 1.0)) {
        ++report.rejected;
        const bool has_error = step.outcome.ok() && std::isfinite(step.error);
        next_step = h * (has_error ? control.reject(step.error) : 0.25);
        const double resolution = 16.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(state.t), left);
        if (next_step < resolution) {
          return step_too_small(resolution, step.outcome);
        }
        continue;
      }
      const double wanted = h * control.accept(step.error);
      // A step cut short by t_end says little about the next one.
      next_step = last ? std::max(wanted, std::min(next_step, 5.0 * wanted)) : wanted;
      take_trial(step, h);
      if (observer && !observer(report)) break;
    }
    return {};
  }
};

Simulation::Simulation(System system, MotionOptions motion, SolverOptions solver, double t_start)
    : implementation_(std::make_unique<Implementation>(std::move(system), motion, solver, t_start)) {
  const std::vector<std::size_t> idle = plan().idle_equations;
  std::vector<Index> all;
  for (std::vector<Index> taut; !(taut = implementation_->find_taut()).empty();) {
    all.insert(all.end(), taut.begin(), taut.end());
    System held = implementation_->model.system;
    held.supports.push_back({"taut rods", taut, {}});
    implementation_ = std::make_unique<Implementation>(std::move(held), motion, solver, t_start);
  }
  if (all.empty()) return;
  PlanSummary& plan = implementation_->forms.plan;
  plan.taut_points = std::move(all);
  std::set_difference(plan.idle_equations.begin(), plan.idle_equations.end(), idle.begin(), idle.end(),
                      std::back_inserter(plan.taut_equations));
}
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;
Simulation::~Simulation() = default;

Outcome Simulation::advance(double t_end, const Observer& observer) {
  return implementation_->advance(t_end, observer);
}

Snapshot Simulation::snapshot() const {
  return implementation_->snapshot();
}
Certificate Simulation::certify() {
  return implementation_->certify();
}
void Simulation::restore(const Snapshot& snapshot) {
  implementation_->restore(snapshot);
}

const System& Simulation::system() const {
  return implementation_->model.system;
}
const PlanSummary& Simulation::plan() const {
  return implementation_->forms.plan;
}
const Outcome& Simulation::outcome() const {
  return implementation_->outcome;
}
const MotionReport& Simulation::report() const {
  return implementation_->report;
}
double Simulation::time() const {
  return implementation_->state.t;
}
std::span<const double> Simulation::coordinates() const {
  return implementation_->q;
}
std::span<const double> Simulation::coordinate_rates() const {
  return implementation_->q_dot;
}
RankReport Simulation::rank() const {
  RankReport report = implementation_->find_rank();
  const std::vector<std::size_t>& taut = plan().taut_equations;
  for (RowDependence& dependence : report.dependences) {
    if (std::binary_search(taut.begin(), taut.end(), dependence.row))
      dependence.what = equation_name(system(), dependence.row) + " is taut between supports, its force not determined";
  }
  return report;
}
std::span<const double> Simulation::positions() const {
  return implementation_->r;
}
std::span<const double> Simulation::velocities() const {
  return implementation_->v;
}
std::span<const double> Simulation::accelerations() const {
  return implementation_->w;
}
std::span<const double> Simulation::multipliers() const {
  return implementation_->lambda;
}
std::span<const double> Simulation::reactions() const {
  return implementation_->eta;
}
std::span<const double> Simulation::support_forces() const {
  return implementation_->carried;
}

}  // namespace tanor
