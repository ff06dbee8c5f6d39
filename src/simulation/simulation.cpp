#include <tanor/motion.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <limits>

#include "base/live.hpp"
#include "base/quiet_traps.hpp"
#include "base/text.hpp"
#include "base/vec3.hpp"
#include "certificate/certificate.hpp"
#include "motion/integration.hpp"
#include "simulation/motion_input.hpp"
#include "simulation/solution.hpp"
#include "system/enum_check.hpp"

namespace tanor {

double EnergyReport::drift_relative() const {
  const double drift = now - start - work_of_supports - work_of_forces - work_of_friction;
  return scale > 0.0 ? drift / scale : 0.0;
}

namespace {

void check_start_time(double t) {
  if (!std::isfinite(t)) throw InputError("", "t_start = " + text(t) + " is not a time");
}

}  // namespace

struct Simulation::Implementation {
  MotionOptions options;
  SolverOptions solver_options;
  Forms forms;
  Model& model = forms.model;
  EquationsOfMotion& form = *forms.main;
  Outcome outcome;
  MotionReport report;
  ChosenMethod chosen;
  Integration integration;
  State& state = integration.state;
  // The state in the user's order.
  std::vector<double> r, v, w, lambda, eta, carried, q, q_dot;
  struct {
    std::vector<double> r, v, w;
  } points;                  // the state [3n] in the inner order
  std::vector<double> rows;  // [d]
  std::size_t num_events = 0;
  static constexpr double rounding_of_energies = 1e8 * std::numeric_limits<double>::epsilon();
  bool is_advancing = false;

  Implementation(System system, const MotionOptions& motion, const SolverOptions& solver, double t_start)
      : options((check_options(motion), check_start_time(t_start), motion)),
        solver_options(resolve(solver, system, motion.method)),
        forms(std::move(system), solver_options, t_start),
        chosen(choose_method(motion, model.system, form, forms.is_tangent())),
        integration(chosen.method, {options, wants_exact_accelerations()}, form, &report) {
    note_method();
    if (!integration.scheme().is_adaptive() && !(options.step > 0.0)) {
      throw InputError("/motion/step", "method " + std::string(method_name(report.method)) +
                                           " has fixed steps: a positive step, s, is needed");
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
    if (outcome.ok()) outcome = complete_state(nullptr);
    integration.begin();
    measure_start();
    if (model.has_friction()) measure_friction();
    publish();
  }

  /// Residuals of 1e-12 would be the noise of such steps. The fixed point of friction leaves as much anyway.
  bool wants_exact_accelerations() const {
    constexpr double demanding = 1e-10;
    return !has_fixed_steps(chosen.method) && options.rtol < demanding && !model.has_friction();
  }

  void note_method() {
    report.method = chosen.method;
    report.method_reason = chosen.reason;
    if (!integration.is_stiff()) return;
    report.method = Method::Radau5;
    report.method_reason = integration.explain_stiffness();
  }

  Snapshot snapshot() {
    write_points();
    Snapshot snapshot;
    snapshot.time = state.t;
    snapshot.positions.resize(points.r.size());
    snapshot.velocities.resize(points.v.size());
    snapshot.report = report;
    integration.write(&snapshot);
    model.numbering.scatter_points(points.r, snapshot.positions);
    model.numbering.scatter_points(points.v, snapshot.velocities);
    return snapshot;
  }

  void restore(const Snapshot& snapshot) {
    refuse_inside_advance("restore");
    check_snapshot(snapshot, points.r.size());
    integration.restore(snapshot);
    report = snapshot.report;
    note_method();
    report.time = snapshot.time;
    form.resume(report.counters, report.times);

    state.t = snapshot.time;
    model.numbering.gather_points(snapshot.positions, points.r);
    model.numbering.gather_points(snapshot.velocities, points.v);
    state.work = {.supports = report.energy.work_of_supports,
                  .forces = report.energy.work_of_forces,
                  .friction = report.energy.work_of_friction};
    model.prescribe_all(state.t, points.r.data(), points.v.data());
    outcome = complete_state(&snapshot);
    integration.resume(snapshot);
    model.counters = snapshot.report.counters;  // what restoring takes is no work of the motion
    publish();
  }

  /// The state at t from its points, with all that belongs to it: a motion begins, or goes on from a snapshot.
  Outcome complete_state(const Snapshot* snapshot) {
    const bool begins = snapshot == nullptr;
    Outcome found = form.adopt(state.t, points.r.data(), points.v.data(), state.x.data(), state.v.data());
    if (!begins) integration.restore_memory(*snapshot);
    if (found.ok() && begins && model.has_friction()) {
      Request at_start = integration.request(Gradients::Keep);
      at_start.refuses_several = true;
      found = form.begin(state.t, state.x.data(), state.v.data(), at_start, state.a.data());
    } else if (found.ok() && integration.is_coasting()) {
      found = integration.return_to_constraints();
    } else {
      if (found.ok()) found = form.linearise(state.t, state.x.data());
      if (found.ok()) found = refresh(Gradients::Keep);
    }
    if (found.ok() && form.has_work() && !integration.is_coasting())
      state.power = form.power(state.x.data(), state.v.data());
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
    report.energy.now = report.energy.start;
    report.energy.potential_at_start = energy.potential;
    report.energy.scale =
        std::max(rounding_of_energies * (std::abs(energy.potential) + energy_of_a_fall()), energy.kinetic);
    warn_of_tolerance();
    report.position_violation = position_violation();
    report.velocity_violation = velocity_violation();
    report.acceleration_violation = form.last_solve().residual;
  }

  /// Projections know what they leave; without them it is measured here.
  void measure_violations(const StepResult& step) {
    double position = step.position_violation, velocity = step.velocity_violation;
    if (options.stabilisation == Stabilisation::None || !step.is_settled) {
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
    if (step.is_settled && integration.knows_acceleration()) measure_acceleration();
    const Energy energy = form.energy(state.t, state.x.data(), state.v.data());
    report.energy.now = energy.kinetic + energy.potential;
    report.energy.work_of_supports = state.work.supports;
    report.energy.work_of_forces = state.work.forces;
    report.energy.work_of_friction = state.work.friction;
    report.energy.scale =
        std::max({report.energy.scale, energy.kinetic, std::abs(energy.potential - report.energy.potential_at_start),
                  rounding_of_energies * std::abs(energy.potential), std::abs(state.work.supports),
                  std::abs(state.work.forces), std::abs(state.work.friction)});
    if (model.has_friction()) measure_friction();
    watch_accuracy();
    report.counters = model.counters;
    report.times = model.times;
  }

  /// K'w + phi of the last accelerations.
  void measure_acceleration() {
    report.acceleration_violation = std::max(report.acceleration_violation, form.last_solve().residual);
  }

  /// What the energies of a motion through the length and at the speed of each neighbourhood would be, J.
  double energy_of_a_fall() const {
    double sum = 0.0;
    for (std::size_t i = 0; i < model.num_moving(); ++i) {
      const double speed = model.scales.speed(model.scales.of_point(i));
      sum += 0.5 * model.mass[i] * speed * speed;
    }
    return sum;
  }

  /// An absolute tolerance that leaves a neighbourhood less than four digits.
  void warn_of_tolerance() {
    constexpr double coarse = 1e-4;
    if (!integration.scheme().is_adaptive() || !(options.atol > 0.0)) return;
    std::size_t smallest = 0;
    for (std::size_t k = 0; k + 1 < model.scales.size(); ++k)
      if (model.scales.length(k) < model.scales.length(smallest)) smallest = k;
    const double length = model.scales.length(smallest);
    if (!(options.atol > coarse * length)) return;
    std::array<char, 16> part{};
    std::snprintf(part.data(), part.size(), "%.3g", options.atol / length);
    report.accuracy_warning = "the absolute tolerance, " + text(options.atol) + " m, is " + std::string(part.data()) +
                              " of the size of what moves, " + text(length) + " m; left out, it is 1e-10 of that size";
  }

  /// What the energy may miss though all velocities and positions are within some thousand tolerances, J: nothing moves
  /// yet.
  double tolerated_energy() {
    constexpr double tolerances = 1e4;
    if (!integration.scheme().is_adaptive()) return 0.0;
    write_points();
    double sum = 0.0;
    for (std::size_t i = 0; i < model.num_moving(); ++i) {
      const double speed = norm(load(points.v.data(), i)), atol = model.scales.velocity_tolerance(options.atol, i);
      // m v dv + m a dr
      const double of_velocity = (speed + tolerances * atol) * (atol + options.rtol * speed);
      const double acceleration = model.scales.accelerations()[i];
      sum +=
          tolerances * model.mass[i] * (of_velocity + acceleration * model.scales.position_tolerance(options.atol, i));
    }
    return sum;
  }

  /// A motion that its steps cannot follow is told by what it does: a fixed step turns it far, or the energy drifts.
  void watch_accuracy() {
    constexpr double longest_turn = 0.4;
    std::string& warning = report.accuracy_warning;
    const bool is_of_drift = warning.find(drifts) != std::string::npos;
    if (!warning.empty() && !is_of_drift) return;
    const double turn = integration.scheme().is_adaptive() ? 0.0 : integration.turn();
    watch_drift(turn);
    warning = turn > longest_turn
                  ? "steps may be too long: one turns the motion by " + text(turn) + " rad at t = " + text(state.t)
                  : explain_drift();
  }

  static constexpr const char* drifts = "the energy drifts by ";

  void watch_drift(double turn) {
    const bool is_adaptive = integration.scheme().is_adaptive();
    EnergyReport& energy = report.energy;
    const double drift = std::abs(energy.drift_relative()) * energy.scale;
    if (!(drift > energy.largest_drift) || !(is_adaptive || turn > 0.0) || !(drift > tolerated_energy())) return;
    energy.largest_drift = drift;
    energy.largest_drift_time = state.t;
  }

  /// Beside all that has flowed so far; empty: it is little.
  std::string explain_drift() const {
    constexpr double largest_drift = 1e-2, least_drift = 1e-4, drift_of_rtol = 1e4;
    const bool is_adaptive = integration.scheme().is_adaptive();
    const double allowed =
        is_adaptive ? std::clamp(drift_of_rtol * options.rtol, least_drift, largest_drift) : largest_drift;
    const EnergyReport& energy = report.energy;
    if (!(energy.largest_drift > allowed * energy.scale)) return "";
    return std::string(is_adaptive ? "the tolerance may be missed: " : "steps may be too long: ") + drifts +
           text(energy.largest_drift / energy.scale) + " of its scale at t = " + text(energy.largest_drift_time);
  }

  /// At a step's end; iterations are counted wherever friction was found.
  void measure_friction() {
    const FrictionReport& last = form.last_solve().friction;
    FrictionSummary& all = report.friction;
    all.solves = model.counters.friction_solves;
    const auto iterations = static_cast<double>(model.counters.friction_iterations);
    all.iterations_mean = all.solves > 0 ? iterations / static_cast<double>(all.solves) : 0.0;
    all.iterations_max = std::max(all.iterations_max, last.iterations);
    all.contraction_max = std::max(all.contraction_max, last.contraction);
    all.residual_max = std::max(all.residual_max, last.residual);
    all.method_used = std::max(all.method_used, last.method_used);
    const bool is_first = all.uniqueness == Uniqueness::NotAsked;
    if (is_first || std::isnan(last.error_bound) || last.error_bound > all.error_bound)
      all.error_bound = last.error_bound;
    if (last.uniqueness > all.uniqueness) all.uniqueness_reason = last.uniqueness_reason;
    all.uniqueness = std::max(all.uniqueness, last.uniqueness);
    if (outcome.ok() && last.uniqueness == Uniqueness::Several && all.several++ == 0) all.first_several = state.t;
  }

  /// Points that do not move though K alone would let them.
  std::vector<Index> find_taut() {
    constexpr double rounding = 1e-12;  // lengths that are not those of the given places: another system
    if (!outcome.ok() || model.rank == model.numbering.first_idle_row() || report.start.relative > rounding) return {};
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
    const Outcome known =
        forms.reactions({state.t, points.r.data(), points.v.data()}, {}, rows.data(), points.w.data());
    if (outcome.ok()) outcome = known;
    numbering.scatter_rows(rows, lambda);
    numbering.scatter_points(points.w, eta);
    // What supports carry: eta + f there
    for (std::size_t i = 0; i < 3 * model.num_moving(); ++i) points.w[i] = 0.0;
    for (std::size_t i = 3 * model.num_moving(); i < points.w.size(); ++i) points.w[i] += model.f[i];
    numbering.scatter_points(points.w, carried);
    report.counters = model.counters;
    report.times = model.times;
  }

  Certificate certify() {
    std::vector<double> at_a(form.size());
    Outcome found = form.accelerations(state.at(), integration.request(Gradients::Evaluate), at_a.data());
    if (!found.ok()) return make_failed_certificate(found);
    form.write_points(state.t, state.x.data(), state.v.data(), at_a.data(), points.r.data(), points.v.data(),
                      points.w.data());
    std::vector<double> at_eta(points.r.size()), at_tau(points.r.size());
    found = forms.reactions({state.t, points.r.data(), points.v.data()}, {}, rows.data(), at_eta.data());
    if (!found.ok()) return make_failed_certificate(found);
    forms.friction_forces(at_tau.data());
    return tanor::certify(forms, {state.t, points.r, points.v, points.w, at_eta, rows, at_tau});
  }

  /// Accelerations and multipliers at the state itself, after steps that left others behind.
  Outcome refresh(Gradients gradients) {
    return form.accelerations(state.at(), integration.request(gradients), state.a.data());
  }

  /// A first step from the time in which velocities or positions change by themselves.
  double first_step(double span) {
    if (options.step > 0.0) return std::min(options.step, span);
    write_points();
    const std::vector<double> speeds = model.largest_norms(points.v.data());
    const std::vector<double> accelerations = model.largest_norms(points.w.data());
    double time = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < speeds.size(); ++k) {
      if (accelerations[k] > 0.0) time = std::min(time, std::max(speeds[k], model.scales.speed(k)) / accelerations[k]);
    }
    if (!std::isfinite(time)) time = span;
    return std::min(span, time * std::pow(options.rtol, 1.0 / integration.scheme().order()));
  }

  /// Its own observers, events and callables look at a step; they cannot make another one.
  void refuse_inside_advance(const char* what) const {
    if (is_advancing)
      throw InputError("", std::string(what) + " was called inside advance; an observer returns false to stop there");
  }

  Outcome advance(double t_end, const Observer& observer) {
    refuse_inside_advance("advance");
    struct Advancing {
      bool& flag;
      explicit Advancing(bool& is_advancing) : flag(is_advancing) { flag = true; }
      ~Advancing() { flag = false; }
    } const advancing(is_advancing);
    if (!outcome.ok()) return outcome;
    if (!(t_end > state.t) || !std::isfinite(t_end)) {
      throw InputError("/motion/t_end", text(t_end) + " does not lie after the time reached, " + text(state.t));
    }
    if (integration.scheme().is_adaptive() && integration.next_step == 0.0)
      integration.next_step = first_step(t_end - state.t);
    outcome = integration.advance(
        t_end, [this](const StepResult& step) { take(step); }, observer);
    if (!outcome.ok() && model.has_friction() && form.events() != nullptr && !integration.scheme().is_adaptive())
      outcome.what += "; steps of a fixed length pass over how contacts stop and leave: take method dop853";
    if (report.accuracy_warning.empty()) report.accuracy_warning = integration.explain_missed();
    const bool rejected_last = !outcome.ok();
    if (rejected_last || !integration.knows_acceleration()) {
      if (rejected_last) integration.restore_good_memory();
      const Outcome at_state = refresh(rejected_last ? Gradients::Evaluate : Gradients::Keep);
      if (rejected_last && integration.knows_acceleration()) integration.restore_good_memory();
      if (outcome.ok()) outcome = at_state;
      if (outcome.ok() && state.t == t_end) measure_acceleration();
    }
    publish();
    return outcome;
  }

  std::size_t add_event(Event event) {
    if (!event.value) throw InputError("/event", "\"" + event.name + "\" has no function");
    check_enum(event.direction, Event::Direction::Falling, "/event/direction");
    const auto value = [this, value = std::move(event.value), at_r = std::vector<double>(r.size()),
                        at_v = std::vector<double>(v.size())](double t, const double* x, const double* x_dot) mutable {
      form.write_points(t, x, x_dot, state.a.data(), points.r.data(), points.v.data(), points.w.data());
      model.numbering.scatter_points(points.r, at_r);
      model.numbering.scatter_points(points.v, at_v);
      return value(t, at_r, at_v);
    };
    integration.watch().add({value, event.direction, event.stops, event.name});
    return num_events++;
  }

  /// A step that was accepted.
  void take(const StepResult& step) {
    form.recentre(state.t, state.x.data(), state.v.data(), state.a.data());
    measure_step(step);
  }
};

Simulation::Simulation(System system, MotionOptions motion, SolverOptions solver, double t_start)
    : implementation_(make_quietly<Implementation>(std::move(system), motion, solver, t_start)) {
  const QuietTraps quiet;
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
  const QuietTraps quiet;
  return live(implementation_, "Simulation").advance(t_end, observer);
}

std::size_t Simulation::add_event(Event event) {
  return live(implementation_, "Simulation").add_event(std::move(event));
}
std::span<const Passage> Simulation::passages() const {
  return live(implementation_, "Simulation").integration.watch().passages();
}
Snapshot Simulation::snapshot() const {
  const QuietTraps quiet;
  return live(implementation_, "Simulation").snapshot();
}
Certificate Simulation::certify() {
  const QuietTraps quiet;
  return live(implementation_, "Simulation").certify();
}
void Simulation::restore(const Snapshot& snapshot) {
  const QuietTraps quiet;
  live(implementation_, "Simulation").restore(snapshot);
}

const System& Simulation::system() const {
  return live(implementation_, "Simulation").model.system;
}
const PlanSummary& Simulation::plan() const {
  return live(implementation_, "Simulation").forms.plan;
}
const Outcome& Simulation::outcome() const {
  return live(implementation_, "Simulation").outcome;
}
const MotionReport& Simulation::report() const {
  return live(implementation_, "Simulation").report;
}
double Simulation::time() const {
  return live(implementation_, "Simulation").state.t;
}
std::span<const double> Simulation::coordinates() const {
  return live(implementation_, "Simulation").q;
}
std::span<const double> Simulation::coordinate_rates() const {
  return live(implementation_, "Simulation").q_dot;
}
RankReport Simulation::rank() const {
  const QuietTraps quiet;
  RankReport report = live(implementation_, "Simulation").find_rank();
  const std::vector<std::size_t>& taut = plan().taut_equations;
  for (RowDependence& dependence : report.dependences) {
    if (std::binary_search(taut.begin(), taut.end(), dependence.row))
      dependence.what = equation_name(system(), dependence.row) + " is taut between supports, its force not determined";
  }
  return report;
}
std::span<const double> Simulation::positions() const {
  return live(implementation_, "Simulation").r;
}
std::span<const double> Simulation::velocities() const {
  return live(implementation_, "Simulation").v;
}
std::span<const double> Simulation::accelerations() const {
  return live(implementation_, "Simulation").w;
}
Solution Simulation::solution() const {
  Implementation& self = live(implementation_, "Simulation");
  Solution now = make_solution(self.model.system);
  now.outcome = self.outcome;
  now.time = self.state.t;
  now.positions = self.r;
  now.velocities = self.v;
  now.accelerations = self.w;
  now.multipliers = self.lambda;
  now.reactions = self.eta;
  now.support_forces = self.carried;
  now.position_violation = self.position_violation();
  return now;
}
std::span<const double> Simulation::multipliers() const {
  return live(implementation_, "Simulation").lambda;
}
std::span<const double> Simulation::reactions() const {
  return live(implementation_, "Simulation").eta;
}
std::span<const double> Simulation::support_forces() const {
  return live(implementation_, "Simulation").carried;
}

}  // namespace tanor
