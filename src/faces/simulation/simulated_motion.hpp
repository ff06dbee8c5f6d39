#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>

#include <tanor/motion.hpp>

#include "base/live.hpp"
#include "base/quiet_traps.hpp"
#include "base/text.hpp"
#include "certificate/certificate.hpp"
#include "dynamics/constraint_arms.hpp"
#include "dynamics/multiplier_form.hpp"
#include "dynamics/prestress_rigidity.hpp"
#include "motion/integration.hpp"
#include "ranks/cut_team.hpp"
#include "simulation/motion_input.hpp"
#include "simulation/motion_measures.hpp"
#include "simulation/saved_state.hpp"
#include "simulation/solution.hpp"
#include "system/enum_check.hpp"
#include "system/fingerprint.hpp"

namespace tanor::detail {

/// The motion of one system, which stays the same.
struct SimulatedMotion {
  static constexpr std::uint64_t fingerprint_of_progress = 0;

  Part part;
  MotionOptions options;
  SolverOptions solver_options;
  double t_begin;  // s, where the motion began
  Forms forms;
  Workspace& work = forms.work;
  const Model& model = forms.model;
  EquationsOfMotion& form = *forms.main;
  Outcome outcome;
  MotionReport report;
  ChosenMethod chosen;
  Integration integration;
  State& state = integration.state;
  Solution now;                 // the state as the last call left it
  std::optional<System> given;  // the given system, if points held rigid by prestress became supports of `model.system`
  PointState points;            // the state in the inner order
  MotionMeasures measures{options, work, form, integration, &points, &report};
  bool is_advancing = false;
  struct {
    std::vector<double> rows;  // [d]
    std::vector<double> a, memory;
    Reactions found;
  } scratch;  // of solves inside observers

  // Simulation::Implementation overrides these for what users ask of the motion.
  virtual void observe_step() {}
  virtual void verify_observables(const Reactions& /*anew*/, Certificate* /*certificate*/) {}
  virtual void collect_passages() {}
  virtual void write_requests(Snapshot* /*snapshot*/) {}
  virtual void read_requests(const Snapshot& /*snapshot*/) {}
  virtual ~SimulatedMotion() = default;

  SimulatedMotion(System system, const MotionOptions& motion, const SolverOptions& solver, const Part& of_all,
                  double t_start)
      : part(of_all),
        options(motion),
        solver_options(check_together(part, system, motion, solver, t_start)),
        t_begin(t_start),
        forms(std::move(system), solver_options, t_start, team_of(part), part.is_whole() ? nullptr : part.ranks),
        chosen(choose_method(motion, model.system, form, forms.is_tangent())),
        integration(chosen.method, {options, wants_exact_accelerations(), solver_options.contact}, form, &report) {
    note_method();
    if (!integration.scheme().is_adaptive() && !(options.step > 0.0)) {
      throw InputError("/motion/step", "method " + std::string(name_of(report.method)) +
                                           " has fixed steps: a positive step, s, is needed");
    }
    for (std::vector<double>* array : {&points.r, &points.v, &points.w}) array->resize(3 * model.num_points());
    now = make_solution(model.system, forms.is_tangent() ? form.size() : 0);
    scratch.rows.resize(model.num_rows());

    watch_arms();

    state.t = t_start;
    model.numbering.gather_points(model.system.positions, points.r);
    model.numbering.gather_points(model.system.velocities, points.v);
    report.time = t_start;
    report.start = forms.start(t_start, points.r.data(), points.v.data(), options.start);
    outcome = report.start.outcome;
    if (outcome.ok()) outcome = complete_state(nullptr);
    integration.begin();
    measures.begin();
    if (model.has_friction()) measures.measure_friction(outcome.ok());
    publish();
  }

  /// Returns true if some rank has friction. Collective.
  bool has_friction() { return form.any(model.has_friction()); }

  bool has_sides() const { return !model.numbering.one_sided.empty(); }

  /// Steps with such tolerances would see residuals of 1e-12 as noise. The fixed point of friction leaves as much
  /// anyway.
  bool wants_exact_accelerations() {
    constexpr double demanding = 1e-10;
    return !has_fixed_steps(chosen.method) && options.rtol < demanding && !has_friction();
  }

  /// Equations that reach from rank to rank need a team. Whole islands do without.
  static Workspace::MakeTeam team_of(const Part& part) {
    if (part.is_whole() || !part.is_cut()) return {};
    return [&](Workspace& work) { return std::make_unique<CutTeam>(work, part); };
  }

  /// Ends the motion where a part of a rope, a leg of an angle or a rod has length 0. Coordinates need no direction
  /// there.
  void watch_arms() {
    const auto arms = std::make_shared<ConstraintArms>(model);
    integration.arms().watch({form.keeps_variables() ? arms->size() : 0,
                              [arms](const Kinematics& at, Vec3* vectors) { arms->evaluate(at.x, vectors); },
                              [arms](const Kinematics& at, std::size_t k) { return arms->size(at.x, k); },
                              [arms](double t, std::size_t k) { return arms->given_length(t, k); },
                              [arms](std::size_t k) { return arms->name(k); }});
  }

  void note_method() {
    report.method = chosen.method;
    report.method_reason = chosen.reason;
    if (!integration.is_stiff()) return;
    report.method = Method::Radau5;
    report.method_reason = integration.explain_stiffness();
  }

  /// Returns an array [3n] of the last answer without the points outside.
  std::span<const double> of_users(std::vector<double> Solution::*array) const {
    return std::span(now.*array).first(3 * system().num_points());
  }

  const System& system() const { return given ? *given : model.system; }

  std::vector<std::byte> save() {
    std::vector<double> r = points.r, v = points.v, w = points.w;
    form.write_points(state.at(), state.a.data(), state.reactions, r.data(), v.data(), w.data());
    Snapshot snapshot;
    snapshot.time = state.t;
    snapshot.positions.resize(r.size());
    snapshot.velocities.resize(v.size());
    write_requests(&snapshot);
    snapshot.report = report;
    integration.write(&snapshot);
    model.numbering.scatter_points(r, snapshot.positions);
    model.numbering.scatter_points(v, snapshot.velocities);
    return pack(snapshot, fingerprint_of(system()));
  }

  /// Saves everything except the points and the memory on which later numbers depend in their last bits. The result
  /// serves any division into ranks.
  std::vector<std::byte> save_progress() {
    Snapshot snapshot;
    snapshot.time = state.t;
    snapshot.report = report;
    integration.write_progress(&snapshot);
    return pack(snapshot, fingerprint_of_progress);
  }

  void restore_progress(std::span<const std::byte> saved, std::span<const double> r, std::span<const double> v) {
    refuse_inside_advance("restore_progress");
    Snapshot snapshot = unpack(saved, fingerprint_of_progress);
    snapshot.positions.assign(r.begin(), r.end());
    snapshot.velocities.assign(v.begin(), v.end());
    restore(snapshot);
  }

  void restore(const Snapshot& snapshot) {
    check_snapshot(snapshot, points.r.size());
    collect_passages();
    integration.restore(snapshot);
    report = snapshot.report;
    note_method();
    report.time = snapshot.time;
    forms.main->resume(report.counters, report.times);

    state.t = snapshot.time;
    model.numbering.gather_points(snapshot.positions, points.r);
    model.numbering.gather_points(snapshot.velocities, points.v);
    state.work = {.supports = report.energy.work_of_supports,
                  .forces = report.energy.work_of_forces,
                  .potentials = report.energy.work_of_potentials,
                  .friction = report.energy.work_of_friction,
                  .impacts = report.energy.work_of_impacts};
    work.prescribe_all(state.t, points.r.data(), points.v.data());
    form.fetch_guests(points.r.data(), points.v.data());
    outcome = complete_state(snapshot.memory.empty() && (has_friction() || has_sides()) ? nullptr : &snapshot);
    integration.resume(snapshot);
    measures.resume();
    work.counters = snapshot.report.counters;  // the work of restoring does not count for the motion
    read_requests(snapshot);
    publish();
  }

  /// Completes the state at t from its points, at the beginning of a motion or (with `snapshot`) when one is resumed.
  Outcome complete_state(const Snapshot* snapshot) {
    const bool begins = snapshot == nullptr;
    Outcome found = form.set_state(state.t, points.r.data(), points.v.data(), state.x.data(), state.v.data());
    if (!begins) integration.restore_memory(*snapshot);
    if (found.ok() && begins && (has_friction() || has_sides())) {
      Request at_start = integration.request(Gradients::Keep);
      at_start.refuses_several = true;
      found = form.begin(state.t, state.x.data(), state.v.data(), at_start, state.output());
    } else if (found.ok() && integration.is_extrapolating()) {
      found = integration.return_to_constraints();
    } else {
      // A start in points leaves the equations linearised there, unless coordinates are compared with constraints.
      const bool is_linearised = begins && part.is_whole() && forms.tangent == nullptr;
      if (found.ok() && !is_linearised) found = form.linearise(state.t, state.x.data());
      if (found.ok()) found = form.accelerations(state.at(), integration.request(Gradients::Keep), state.output());
    }
    return found;
  }

  void write_points() {
    form.write_points(state.at(), state.a.data(), state.reactions, points.r.data(), points.v.data(), points.w.data());
  }

  /// Finds points held rigid by prestress, which do not move although K alone would let them.
  std::vector<Index> find_prestress_rigid_points() {
    if (part.is_cut()) return {};
    constexpr double rounding = 1e-12;  // a larger correction at the start means another system
    if (!outcome.ok() || work.rank == model.numbering.first_idle_row() || report.start.relative > rounding) return {};
    if (forms.normal == nullptr) return {};
    return detail::find_prestress_rigid_points(model.system, forms.normal->linearization().dependences().list_rows());
  }

  RankReport find_rank() {
    write_points();
    return forms.rank(points.r.data(), false);
  }

  void publish() {
    write_points();
    const Outcome known = write_solution(state.reactions, &now);
    if (outcome.ok()) outcome = known;
    report.counters = work.counters;
    report.times = work.times;
  }

  /// The parts of an answer that `write_solution` writes. In normal form the state holds the places that multipliers
  /// need.
  enum class Parts { All, Multipliers };
  bool needs_points(Parts parts) const { return parts == Parts::All || forms.is_tangent(); }

  /// Writes the state, in the user's order, with what was found with the accelerations there.
  Outcome write_solution(const Reactions& found, Solution* at) {
    return write_solution(state.at(), found, Parts::All, at);
  }
  Outcome write_solution(const Kinematics& here, const Reactions& found, Parts parts, Solution* at) {
    const Numbering& numbering = model.numbering;
    if (parts == Parts::Multipliers) {
      const Kinematics places = forms.is_tangent() ? points.at(here.t) : here;
      Outcome known = forms.reactions({here, places}, {}, found, scratch.rows.data(), nullptr);
      numbering.scatter_rows(scratch.rows, at->multipliers);
      return known;
    }
    numbering.scatter_points(points.r, at->positions);
    numbering.scatter_points(points.v, at->velocities);
    numbering.scatter_points(points.w, at->accelerations);
    if (forms.is_tangent()) {
      work.coordinates.scatter(here.x, at->coordinates.data());
      work.coordinates.scatter(here.v, at->coordinate_rates.data());
    }
    Outcome known = forms.reactions({here, points.at(here.t)}, {}, found, scratch.rows.data(), points.w.data());
    numbering.scatter_rows(scratch.rows, at->multipliers);
    numbering.scatter_points(points.w, at->reactions);
    // The load of supports is eta + f there.
    for (std::size_t i = 0; i < 3 * model.num_moving(); ++i) points.w[i] = 0.0;
    for (std::size_t i = 3 * model.num_moving(); i < points.w.size(); ++i) points.w[i] += work.f[i];
    numbering.scatter_points(points.w, at->support_forces);
    return known;
  }

  /// Guards an evaluation at the present state, after which the motion goes on as if there had been none. It restores
  /// what later solves start from, and the counters.
  class Look {
   public:
    enum class Memory { Restored, Untouched };
    explicit Look(SimulatedMotion* at, Memory memory = Memory::Restored)
        : at_(*at), counters_(at->work.counters), times_(at->work.times), memory_(memory) {
      at_.scratch.memory.clear();
      if (memory_ == Memory::Restored) exchange(detail::Memory(&at_.scratch.memory));
    }
    ~Look() {
      if (memory_ == Memory::Restored) exchange(detail::Memory{std::span<const double>(at_.scratch.memory)});
      at_.work.counters = counters_;
      at_.work.times = times_;
    }
    Look(const Look&) = delete;
    Look& operator=(const Look&) = delete;

   private:
    void exchange(detail::Memory memory) { at_.form.exchange_memory(memory); }

    SimulatedMotion& at_;
    const Counters counters_;
    const PhaseTimes times_;
    const Memory memory_;
  };

  /// Finds the multipliers alone where the last step left K, its factor and its forces. Those that later solves start
  /// from stay.
  void find_multipliers_at_end(Solution* at) {
    const Look look(this, Look::Memory::Untouched);
    at->outcome = {};
    const auto [free, largest] = integration.scheme().known_free(state.t);
    if (free != nullptr &&
        forms.normal->linearization().find_multipliers(state.at(), free, largest, scratch.rows.data()))
      return model.numbering.scatter_rows(scratch.rows, at->multipliers, model.parallel);
    std::vector<double>& lambda = forms.normal->dynamics().multipliers();
    lambda.swap(scratch.rows);
    scratch.a.resize(form.size());
    /// Accelerations that stand in their array.
    struct Known final : GivenMotion {
      void bring(std::size_t, std::size_t) const override {}
      double largest() const override { return size; }
      double size = 0.0;
    } known;
    known.size = largest;
    Request request = integration.request(Gradients::Keep);
    if (free != nullptr) {
      std::copy_n(free, scratch.a.size(), scratch.a.data());
      request.given = &known;
    }
    at->outcome = form.accelerations(state.at(), request, {scratch.a.data()});
    model.numbering.scatter_rows(lambda, at->multipliers, model.parallel);
    lambda.swap(scratch.rows);
  }

  /// Solves at the state inside an observer, where accelerations may be those of a stage. The state keeps its own.
  void solve_on_the_way(Parts parts, Solution* at) {
    // Steps that leave no accelerations leave K and its factor.
    const bool is_linearised = !integration.knows_acceleration();
    if (is_linearised && parts == Parts::Multipliers && part.is_whole() &&
        !forms.normal->linearization().dependences().is_found())
      return find_multipliers_at_end(at);
    const Look look(this);
    scratch.a.resize(form.size());
    if (scratch.found.lambda.empty()) scratch.found = form.no_reactions();
    const Request request = integration.request(is_linearised ? Gradients::Keep : Gradients::Evaluate);
    at->outcome = form.accelerations(state.at(), request, {scratch.a.data(), nullptr, nullptr, &scratch.found});
    if (needs_points(parts) || !at->outcome.ok())
      form.write_points(state.at(), scratch.a.data(), scratch.found, points.r.data(), points.v.data(), points.w.data());
    if (at->outcome.ok()) {
      at->outcome = write_solution(state.at(), scratch.found, parts, at);
    } else {
      model.numbering.scatter_points(points.r, at->positions);
      model.numbering.scatter_points(points.v, at->velocities);
    }
  }

  /// Returns the friction with some reactions, in the user's order.
  std::vector<double> friction_of(const Reactions& found) {
    std::vector<double> tau(points.r.size()), at(points.r.size());
    forms.main->write_friction(found, tau.data());
    model.numbering.scatter_points(tau, at);
    at.resize(3 * system().num_points());
    return at;
  }

  std::vector<double> friction_forces() {
    if (!is_advancing || !has_friction()) return friction_of(state.reactions);
    const Look look(this);
    std::vector<double> at_a(form.size());
    Reactions found = form.no_reactions();
    const Outcome solved = form.accelerations(state.at(), integration.request(Gradients::Evaluate),
                                              {at_a.data(), nullptr, nullptr, &found});
    return solved.ok() ? friction_of(found) : std::vector<double>(3 * system().num_points());
  }

  Solution solution() {
    Solution at = now;
    at.outcome = outcome;
    if (is_advancing) solve_on_the_way(Parts::All, &at);
    at.time = state.t;
    write_points();
    at.position_violation = form.largest(work.position_violation(state.t, points.r.data()));
    at.degrees_of_freedom = static_cast<std::size_t>(form.sum(forms.degrees_of_freedom()));
    for (auto array : {&Solution::positions, &Solution::velocities, &Solution::accelerations, &Solution::reactions,
                       &Solution::support_forces})
      (at.*array).resize(3 * system().num_points());
    return at;
  }

  Certificate certify() {
    if (part.is_cut()) throw InputError("/certificate", "nobody proves what lies on several ranks; take one rank");
    const Look look(this);
    std::vector<double> at_a(form.size()), at_eta(points.r.size()), at_tau(points.r.size());
    SolveReport solved;
    Reactions reactions;
    Outcome found = form.accelerations(state.at(), integration.request(Gradients::Evaluate),
                                       {at_a.data(), nullptr, &solved, &reactions});
    if (!found.ok()) return make_failed_certificate(found);
    form.write_points(state.at(), at_a.data(), reactions, points.r.data(), points.v.data(), points.w.data());
    found = forms.reactions({state.at(), points.at(state.t)}, {}, reactions, scratch.rows.data(), at_eta.data());
    if (!found.ok()) return make_failed_certificate(found);
    forms.main->write_friction(reactions, at_tau.data());
    Certificate certificate =
        detail::certify(forms, {state.t, points.r, points.v, points.w, at_eta, scratch.rows, at_tau, solved.friction});
    verify_observables(reactions, &certificate);
    return certificate;
  }

  /// Finds accelerations and multipliers at the state itself, after steps that left others behind.
  Outcome refresh(Gradients gradients) {
    return form.accelerations(state.at(), integration.request(gradients), state.output_without_power());
  }

  /// Chooses a first step from the time in which velocities or positions change considerably.
  double first_step(double span) {
    if (options.step > 0.0) return std::min(options.step, span);
    write_points();
    const std::vector<double> speeds = work.largest_norms(points.v.data());
    const std::vector<double> accelerations = work.largest_norms(points.w.data());
    double time = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < speeds.size(); ++k) {
      if (accelerations[k] > 0.0) time = std::min(time, std::max(speeds[k], work.scales.speed(k)) / accelerations[k]);
    }
    time = form.smallest(time);
    if (!std::isfinite(time)) time = span;
    return std::min(span, time * std::pow(options.rtol, 1.0 / integration.scheme().order()));
  }

  /// Refuses a call from the motion's own observers, events and callables, which may look at a step but not make
  /// another.
  void refuse_inside_advance(const char* what) const {
    if (is_advancing)
      throw InputError("",
                       std::string(what) + " was called inside advance_to; an observer returns false to stop there");
  }

  Outcome advance(double t_end, const Simulation::Observer& observer) {
    refuse_inside_advance("advance_to");
    struct Advancing {
      bool& flag;
      explicit Advancing(bool& is_advancing) : flag(is_advancing) { flag = true; }
      ~Advancing() { flag = false; }
    } const advancing(is_advancing);
    if (!outcome.ok()) return outcome;
    if (!(t_end > state.t) || !std::isfinite(t_end)) {
      const auto [end, reached] = texts_apart(std::array{t_end, state.t});
      throw InputError("/motion/t_end", end + " does not lie after the time reached, " + reached);
    }
    if (integration.scheme().is_adaptive() && integration.next_step == 0.0)
      integration.next_step = first_step(t_end - state.t);
    const auto goes_on = [&](const MotionReport& so_far) {
      return measures.check_growth().ok() && (!observer || observer(so_far));
    };
    outcome = integration.advance(
        t_end, [this](const StepResult& step) { take(step); }, goes_on);
    if (!outcome.ok() && has_friction() && form.events() != nullptr && !integration.scheme().is_adaptive())
      outcome.what += "; steps of a fixed length pass over how contacts stop and leave: take method dop853";
    if (report.accuracy_warning.empty()) report.accuracy_warning = integration.explain_missed();
    const bool rejected_last = !outcome.ok();
    if (rejected_last || !integration.knows_acceleration()) {
      if (rejected_last) integration.restore_good_memory();
      const Outcome at_state = refresh(rejected_last ? Gradients::Evaluate : Gradients::Keep);
      if (rejected_last && integration.knows_acceleration()) integration.restore_good_memory();
      if (outcome.ok()) outcome = at_state;
      if (outcome.ok() && state.t == t_end) measures.measure_acceleration();
    }
    if (outcome.ok()) outcome = measures.check_growth();
    publish();
    return outcome;
  }

  /// Takes over an accepted step.
  void take(const StepResult& step) {
    forms.main->recentre(state.t, state.x.data(), state.v.data(), state.a.data(), &state.reactions);
    measures.take(step, outcome.ok());
    observe_step();
  }
};

}  // namespace tanor::detail
