#include "motion/integration.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>

#include "base/text.hpp"
#include "motion/aside.hpp"
#include "motion/equal_steps.hpp"

namespace tanor::detail {

namespace {

// All thresholds of step control.

/// A fixed step that fails is halved at most so often.
constexpr int most_splits = 8;
/// A step that covers this part of what is left of an advance ends at its end.
constexpr double nearly_all = 0.99;
/// A step longer than this part of the time left is shortened to half of that time, so that no tiny step is left over.
constexpr double nearly_half = 0.51;
/// An advance fails after so many steps in a row that each cover less than this part of the time left.
constexpr double tiny = 1e-8;
constexpr int most_tiny_steps = 20000;
/// Fixed steps may pass over velocities up to this part of the largest speed without a warning.
constexpr double small = 1e-2;

}  // namespace

Integration::Integration(Method method, const IntegrationOptions& options, Mechanics& mechanics, MotionReport* report)
    : method_(method),
      options_(options),
      mechanics_(mechanics),
      report_(*report),
      scheme_(make_scheme(method, options, mechanics)),
      control_(scheme_->estimate_order()),
      drives_(options, *scheme_, mechanics),
      singular_(options, mechanics, scheme_->is_adaptive(), report),
      rounding_(options, mechanics),
      stiff_steps_(options, mechanics, method),
      trial_(options, mechanics, {state, scheme_, drives_, singular_}, report) {
  for (std::vector<double>* array : {&state.x, &state.v, &state.a}) array->resize(mechanics.size());
  state.reactions = mechanics.no_reactions();
}

void Integration::begin() {
  trial_.begin();
  trial_.events.note_changes();
  trial_.events.take_changes(&report_.contact_events);
  trial_.watch.begin(state.t);
  drives_.begin(state.t);
  singular_.begin(state.t);
  keep_memory();
}

Outcome Integration::return_to_constraints() {
  Outcome found = mechanics_.linearise(trial_.state.t, trial_.state.x.data());
  if (found.ok()) {
    // The acceleration is known to the state but not to the mechanics.
    found = mechanics_.accelerations(trial_.state.at(), options_.request(Gradients::Keep),
                                     trial_.state.output_without_power());
  }
  state.power = trial_.state.power;
  state.report = trial_.state.report;
  state.reactions = trial_.state.reactions;
  return found;
}

Outcome Integration::advance(double t_end, const Taken& taken, const Observer& observer) {
  has_stopped_ = false;
  drives_.advance(state.t, t_end);
  const bool adapts = scheme_->is_adaptive();
  Outcome found = adapts ? advance_adaptively(t_end, taken, observer) : advance_in_equal_steps(t_end, taken, observer);
  if (found.ok() && has_stopped_) found = trial_.end;
  if (adapts && report_.accuracy_warning.empty()) report_.accuracy_warning = rounding_.explain();
  return found;
}

double Integration::turn() const {
  // Other variables may belong to charts that have moved, and accelerations jump where equations change.
  if (!mechanics_.keeps_variables() || !trial_.is_before) return 0.0;
  return turns_.angle(mechanics_, trial_.state, state, knows_acceleration());
}

/// Takes over an accepted attempt. Its length is 0 if equations were switched at its start.
void Integration::take_trial(const StepAttempt& attempt, const Taken& taken) {
  const double h = trial_.state.t - state.t;
  swap(state, trial_.state);
  control_.limit = std::numeric_limits<double>::infinity();
  trial_.is_before = mechanics_.keeps_variables() && !attempt.has_switched;
  if (attempt.has_switched) singular_.forget();
  if (attempt.is_extrapolated) trial_.events.forget();
  if (attempt.has_stopped) has_stopped_ = true;
  trial_.watch.accept(state.t);
  report_.events_may_be_missed = trial_.watch.explain_missed();
  if (trial_.events.count() > report_.events) report_.last_change = trial_.events.last_change();
  report_.events = trial_.events.count();
  trial_.events.take_changes(&report_.contact_events);
  if (report_.contact_events.size() >= static_cast<std::size_t>(options_.max_contact_events)) {
    has_stopped_ = true;
    trial_.end = {Status::NotConverged, "the contact events are as many as solver.contact.max_events allows, " +
                                            text(options_.max_contact_events) + ", at t = " + text(state.t) +
                                            "; the last one: " + report_.last_change};
  }
  report_.last_event = trial_.events.last_time();
  if (h > 0.0) {
    report_.last_step = h;
    if (!scheme_->is_adaptive()) turns_.note(mechanics_, state);
    taken(attempt.step);
  }
  singular_.note(*scheme_, trial_.state, state, attempt.step);
  keep_memory();
}

/// Makes a fixed step, in pieces if events lie on the way. A step that fails is tried again in halves.
Outcome Integration::step_or_split(double t, int splits_left, const Taken& taken) {
  while (state.t < t && !has_stopped_) {
    const double h = t - state.t;
    const bool extrapolates = trial_.is_before && singular_.disturb(state.t, h);
    if (Outcome found = extrapolates ? Outcome{} : trial_.events.start(state); !found.ok()) return found;
    double clear = h;
    if (Outcome found = extrapolates ? Outcome{} : look_for_corner(h, &clear); !found.ok()) return found;
    const double end = clear < h ? state.t + clear : t;
    if (!extrapolates) drives_.shorten(state, end - state.t, end - state.t);
    const StepAttempt attempt = extrapolates   ? trial_.extrapolate(t)
                                : clear == 0.0 ? trial_.cross(t)
                                               : trial_.step_to_jump(end, splits_left == most_splits, &jumps_);
    if (attempt.is_good()) {
      if (trial_.state.t == t) drives_.note(state, h);
      take_trial(attempt, taken);
      continue;
    }
    if (splits_left == 0 && attempt.step.outcome.ok()) return step_too_small(clear, {});
    if (attempt.has_switched) return attempt.step.outcome;
    if (splits_left == 0) return explain_end(std::ldexp(clear, most_splits), attempt.step.outcome);
    ++report_.rejected;
    if (Outcome back = mechanics_.linearise(state.t, state.x.data()); !back.ok()) return back;
    if (Outcome first = step_or_split(state.t + 0.5 * clear, splits_left - 1, taken); !first.ok()) return first;
    return step_or_split(t, splits_left - 1, taken);
  }
  return {};
}

/// Finds how much of a step of length h may be made before a corner, see Corners::shorten.
Outcome Integration::look_for_corner(double h, double* clear) {
  *clear = h;
  if (trial_.corners.empty()) return {};
  if (trial_.corners.follow_motion()) {
    if (Outcome found = trial_.find_acceleration(); !found.ok()) return found;
  }
  return trial_.corners.shorten(state, h, clear);
}

double Integration::longest_step() const {
  return options_.max_step > 0.0 ? options_.max_step : std::numeric_limits<double>::infinity();
}

std::string Integration::explain_missed() {
  return drives_.missed() > small * turns_.fastest() ? drives_.describe() : "";
}

Outcome Integration::step_too_small(double resolution, Outcome reason) {
  // Steps that get ever shorter may lead to where an arm vanishes.
  if (!trial_.arms.is_empty()) {
    if (const auto arm = trial_.arms.find_ahead(state, false, 1e10 * resolution))
      return trial_.arms.explain(*arm, arm->time);
  }
  constexpr double farthest_jump = 1e7, farthest_corner = 1e7;
  if (reason.ok()) reason = trial_.find_jump(farthest_jump * resolution);
  if (reason.ok()) reason = find_end_ahead(resolution);
  reason = explain_end(farthest_corner * resolution, std::move(reason));
  if (reason.status == Status::NoSolution) return reason;
  return {Status::StepTooSmall, "the step falls below " + text(resolution) + " at t = " + text(state.t) +
                                    (reason.ok() ? "" : ": " + reason.what)};
}

/// Looks a little ahead for a place where forces are not finite, as for a bond at its limit, or where no accelerations
/// obey the law of friction, since reactions grow without bound (Painleve). Steps that get ever shorter may lead there.
/// The mechanics loses what it knows of the state, since the advance is over.
Outcome Integration::find_end_ahead(double resolution) {
  constexpr double nearest = 10.0, farthest = 1e7;
  std::vector<double> x(state.x.size()), v(x), a(x);
  for (double ahead = nearest * resolution; ahead <= farthest * resolution; ahead *= 10.0) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] = state.x[i] + ahead * state.v[i];
      v[i] = state.v[i] + ahead * state.a[i];
    }
    try {
      mechanics_.prescribe(state.t + ahead, x.data(), v.data());
      Outcome found = mechanics_.accelerations({state.t + ahead, x.data(), v.data()}, {}, a.data());
      if (found.status == Status::NotFinite || found.status == Status::NoSolution) return found;
    } catch (const InputError&) {  // a table ends there
      return {};
    }
  }
  return find_collision(farthest * resolution);
}

/// Names the arm that vanishes within so many seconds, as a rod that turns ever faster while it runs out. If there is
/// none, adds the name of a corner that the state meets within them, if there is one, to the reason of a failure.
Outcome Integration::explain_end(double within, Outcome reason) {
  if (!trial_.arms.is_empty()) {
    if (const auto arm = trial_.arms.find_ahead(state, false, within)) return trial_.arms.explain(*arm, arm->time);
  }
  const std::string name = trial_.corners.name_next(state, within);
  if (name.empty()) return reason;
  const std::string corner = "the corner of " + name + " is too near";
  return {Status::Singular, reason.what.empty() ? corner : reason.what + "; " + corner};
}

/// Names two points that collide within so many seconds. Forces of a pair whose law has no bound are finite up to the
/// point of collision.
Outcome Integration::find_collision(double within) {
  UnseenForces* const forces = mechanics_.unseen_forces();
  if (forces == nullptr) return {};
  std::vector<double> r(3 * forces->num_points()), v(r.size());
  std::string found = mechanics_.first_text(forces->find_collision(
      forces->find_points({state.t, state.x.data(), state.v.data()}, r.data(), v.data()), within));
  return found.empty() ? Outcome{} : Outcome{Status::NotFinite, std::move(found)};
}

/// Makes steps of at most `options.step` that end exactly at t_end. An advance that was stopped on its way to t_end
/// continues with its own steps.
Outcome Integration::advance_in_equal_steps(double t_end, const Taken& taken, const Observer& observer) {
  const double length = std::min(options_.step, longest_step());
  EqualSteps steps(last_advance_.begin, t_end, length);
  double k = steps.nearest(state.t);
  if (last_advance_.end != t_end || steps.time(k) != state.t) {
    steps = EqualSteps(state.t, t_end, length);
    k = 0.0;
  }
  last_advance_ = {steps.begin(), t_end};
  const double resolution = time_resolution(t_end, std::abs(state.t));
  if (steps.length() < resolution) return step_too_small(resolution, {});
  while (k < steps.count() && !has_stopped_) {
    if (Outcome found = step_or_split(steps.time(++k), most_splits, taken); !found.ok()) return found;
    if (observer && !observer(report_)) break;
  }
  return {};
}

void Integration::take_scheme(Method method, double first_step) {
  scheme_ = make_scheme(method, options_, mechanics_);
  drives_.follow(*scheme_);
  control_ = StepControl(scheme_->estimate_order());
  next_step = first_step;
  report_.method = method;
}

/// Changes from steps that stability keeps short to implicit ones, and back if the implicit ones get shorter.
Outcome Integration::look_for_stiffness(double t_end) {
  if (stiff_steps_.gives_up(next_step)) {
    take_scheme(method_, next_step);
    report_.method_reason = "implicit steps got shorter than explicit ones at t = " + text(state.t);
    return {};
  }
  const double h = report_.last_step;
  if (singular_.is_extrapolating() || !stiff_steps_.is_due(h, t_end - state.t)) return {};
  bool is_stiff = false;
  const auto look = [&] { is_stiff = stiff_steps_.look(state, h, rounding_); };
  Outcome found = solve_aside(mechanics_, options_, state, std::cref(look), rounding_.aside());
  if (!is_stiff) return found;
  take_scheme(Method::Radau5, stiff_steps_.implicit_step());
  report_.method_reason = stiff_steps_.explain();
  return found;
}

Outcome Integration::advance_adaptively(double t_end, const Taken& taken, const Observer& observer) {
  for (int tiny_steps = 0; state.t < t_end && !has_stopped_;) {
    const double t = state.t;
    const bool is_disturbed = singular_.disturb(t, std::min(next_step, t_end - t));
    const bool extrapolates = is_disturbed && trial_.is_before;
    if (is_disturbed && !extrapolates && singular_.approach())
      control_.limit = next_step = std::min(next_step, singular_.half_way(t));
    if (Outcome found = extrapolates ? extrapolate_adaptively(t_end, taken) : step_adaptively(t_end, taken);
        !found.ok())
      return found;
    if (Outcome found = look_for_stiffness(t_end); !found.ok()) return found;
    if (state.t == t) continue;
    tiny_steps = state.t - t < tiny * (t_end - t) ? tiny_steps + 1 : 0;
    if (tiny_steps == most_tiny_steps) return step_too_small(tiny * (t_end - t), refusal_);
    if (observer && !observer(report_)) break;
  }
  return {};
}

/// Tries a step past a singular configuration. If that fails, `next_step` is the length to try instead.
Outcome Integration::extrapolate_adaptively(double t_end, const Taken& taken) {
  const auto end_of = [&](double h) { return h >= nearly_all * (t_end - state.t) ? t_end : state.t + h; };
  const double wanted = std::min(singular_.extrapolation_length(trial_.state.t, state.t), longest_step());
  StepAttempt attempt = trial_.extrapolate(end_of(wanted));
  if (!attempt.is_good()) {
    ++report_.rejected;
    if (singular_.pays_to_approach() && singular_.approach()) {
      if (singular_.is_extrapolating()) return {};
      control_.limit = next_step = singular_.half_way(state.t);
      return mechanics_.linearise(state.t, state.x.data());
    }
    // Coming nearer would only increase the error. The scheme's own step passes a configuration that only seems
    // singular, the polynomial one that is singular.
    if (!singular_.is_extrapolating() && !singular_.lies_near_end(state.t, end_of(wanted)))
      attempt = trial_.pass(end_of(wanted));
    if (attempt.has_switched && !attempt.is_good()) return attempt.step.outcome;
    if (!attempt.is_good())
      attempt = trial_.extrapolate(end_of(std::min(singular_.longer(wanted), longest_step())), true);
  }
  if (attempt.is_good()) {
    take_trial(attempt, taken);
    return {};
  }
  if (singular_.is_extrapolating()) {
    if (singular_.approach()) return {};
    return attempt.step.outcome.ok() ? singular_.explain_stop(state.t) : attempt.step.outcome;
  }
  if (Outcome back = mechanics_.linearise(state.t, state.x.data()); !back.ok()) return back;
  return step_adaptively(t_end, taken);
}

/// Crosses a corner, and leaves `next_step` alone.
Outcome Integration::cross_corner(double t, const Taken& taken) {
  const StepAttempt attempt = trial_.cross(t);
  if (attempt.is_good()) take_trial(attempt, taken);
  return attempt.step.outcome;
}

/// Tries a step once. Afterwards `next_step` is the length to try next.
Outcome Integration::step_adaptively(double t_end, const Taken& taken) {
  if (Outcome found = trial_.events.start(state); !found.ok()) return found;
  if (Outcome found = rounding_.measure(state); !found.ok()) return found;
  const double expected = std::min(next_step, t_end - state.t);
  rounding_.allow(state, expected, scheme_->rounding_gain());
  const double left = t_end - state.t;
  const double resolution = time_resolution(state.t, left);
  if (const double proposed = scheme_->propose_step(state, resolution); proposed > 0.0)
    next_step = std::min(proposed, control_.limit);
  next_step = std::min(next_step, longest_step());
  // End exactly at t_end, without a tiny last step.
  const bool reaches = next_step >= nearly_all * left && left <= longest_step();
  const double fitting = reaches ? left : std::min(next_step, nearly_half * left > next_step ? next_step : 0.5 * left);
  const Cut cut = std::exchange(cut_, {});
  double clear = fitting;
  if (Outcome found = look_for_corner(fitting, &clear); !found.ok()) return found;
  if (clear == 0.0) return cross_corner(reaches ? t_end : state.t + fitting, taken);
  const double whole = drives_.shorten(state, clear, resolution);
  const bool is_cut = cut.length < whole;
  const double h = is_cut ? cut.length : whole;
  const bool last = reaches && h == fitting;
  if (!last && !is_cut && !(h >= resolution)) return step_too_small(resolution, refusal_);
  if (h != expected) rounding_.allow(state, h, scheme_->rounding_gain());
  const auto looks = is_cut && cut.is_over ? StepTrial::Looks::None : StepTrial::Looks::Between;
  const StepAttempt attempt = trial_.step_and_remember(last ? t_end : state.t + h, true, looks);
  if (attempt.is_good()) {
    const double wanted = scheme_->choose_step(h, h * control_.accept(attempt.error));
    // A step cut short by t_end, or by functions of time, tells little about the next one, so that the next length
    // stays as planned, up to 5 times what this step allows. The error of a step cut short by an event is that of the
    // whole step, but does not show that the next step may be longer. One that ends at a jump or before a corner tells
    // nothing about the next.
    next_step = is_cut || trial_.corners.is_ahead() ? std::max(wanted, next_step)
                : last || h < fitting               ? std::max(wanted, std::min(next_step, 5.0 * wanted))
                                                    : wanted;
    if (attempt.has_switched) next_step = std::min(next_step, h);
    rounding_.note_step(state);
    is_cut ? stiff_steps_.note_cut_step() : stiff_steps_.note_step();
    refusal_ = {};
    take_trial(attempt, taken);
    return {};
  }
  return reject(attempt, is_cut ? cut : Cut{}, h, resolution);
}

/// Chooses the length to try after an attempt of length h, perhaps cut, has failed.
Outcome Integration::reject(const StepAttempt& attempt, const Cut& cut, double h, double resolution) {
  const StepResult& step = attempt.step;
  if (attempt.has_switched) return step.outcome;
  ++report_.rejected;
  if (attempt.jump.exists()) {
    // A path with a large error may meet a jump that the motion does not, so that the plan has to shrink. Where a
    // motion may stay at a jump, plans that are too short would not see it any more.
    constexpr double shrinks = 0.3;
    cut_ = jumps_.cut_at(attempt.jump, scheme_->looks().size() > 2, h, resolution);
    const bool may_stay = cut_.is_over && attempt.jump.idle > 0.0;
    if (!cut.exists() && !may_stay && attempt.error > 1.0) next_step = shrinks * h;
    return cut_.is_over ? jumps_.note_jump(attempt.jump, state.t, resolution) : Outcome{};
  }
  if (cut.exists()) cut_ = jumps_.cut_again(cut, resolution);
  if (cut_.exists()) return {};
  singular_.note_rejection();
  if (step.outcome.ok() && attempt.error > 1.0) rounding_.note_rejection(h, attempt.error, scheme_->estimate_order());
  if (attempt.has_surprised) {
    singular_.approach();
    control_.limit = next_step = 0.5 * h;
    return {};
  }
  if (attempt.part < 1.0) {
    control_.limit = next_step = attempt.part * h;
    return {};
  }
  if (!step.outcome.ok()) refusal_ = step.outcome;
  const bool has_error = step.outcome.ok() && std::isfinite(attempt.error);
  control_.limit = next_step = h * (has_error ? control_.reject(attempt.error) : 0.25);
  return next_step < resolution ? step_too_small(resolution, refusal_) : Outcome{};
}

}  // namespace tanor::detail
