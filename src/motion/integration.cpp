#include "motion/integration.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "base/text.hpp"
#include "motion/equal_steps.hpp"

namespace tanor {

namespace {

constexpr int most_splits = 8;  // of a fixed step that fails

/// visit(number) for all of a state but the works done.
template <class S, class Visit>
void for_each_number(S& state, const Visit& visit) {
  visit(state.t);
  for (double Power::*const part : {&Power::supports, &Power::forces, &Power::friction}) visit(state.power.*part);
  for (auto* array : {&state.x, &state.v, &state.a}) {
    for (auto& number : *array) visit(number);
  }
}

}  // namespace

Integration::Integration(Method method, const IntegrationOptions& options, Mechanics& mechanics, MotionReport* report)
    : method_(method),
      options_(options),
      mechanics_(mechanics),
      report_(*report),
      scheme_(make_scheme(method, options, mechanics)),
      control_(scheme_->estimate_order()),
      drives_(options, *scheme_, mechanics),
      events_(options, mechanics),
      places_(options, mechanics, scheme_->is_adaptive(), report),
      rounding_(options, mechanics),
      stiff_steps_(options, mechanics, method),
      watch_(options, mechanics),
      passages_(options, mechanics, scheme_->is_adaptive()) {
  for (std::vector<double>* array : {&state.x, &state.v, &state.a}) array->resize(mechanics.size());
}

void Integration::write(Snapshot* snapshot) {
  snapshot->next_step = next_step;
  snapshot->last_error = control_.last_error();
  snapshot->advance_begin = advance_begin_;
  snapshot->advance_end = advance_end_;
  snapshot->drive_memory = drives_.memory();
  snapshot->discrete_state = events_.discrete_state();
  snapshot->event_slopes = events_.slopes();
  snapshot->memory.clear();
  Memory memory(&snapshot->memory);
  exchange_memory(memory);
  scheme_->exchange_memory(memory);
  places_.write(&snapshot->singular_memory);
  if (scheme_->is_adaptive()) {
    snapshot->rounding_memory = rounding_.memory();
    snapshot->stiff_memory = stiff_steps_.memory();
  }
  std::vector<double>& before = snapshot->state_before;
  before.clear();
  if (!trial_is_before_ || !places_.may_coast()) return;
  before.push_back(control_.is_after_rejection());
  for_each_number(trial_, [&](double number) { before.push_back(number); });
  before.insert(before.end(), state.a.begin(), state.a.end());
}

/// All but the scheme's: what the solve that completes a restored state may change.
void Integration::exchange_memory(Memory& memory) {
  mechanics_.exchange_memory(memory);
  if (!mechanics_.keeps_variables()) memory.exchange(state.x, state.v);
  memory.exchange(state.a, state.power.supports, state.power.forces, state.power.friction, fastest_, fastest_before_);
  events_.exchange_memory(memory);
}

/// Where several accelerations are near to each other, those that were found depend on where iterations began.
void Integration::keep_memory() {
  good_memory_.clear();
  if (mechanics_.last_solve().friction.uniqueness != Uniqueness::Several) return;
  Memory memory(&good_memory_);
  exchange_memory(memory);
}

void Integration::restore_good_memory() {
  if (good_memory_.empty()) return;
  Memory memory{std::span<const double>(good_memory_)};
  exchange_memory(memory);
}

void Integration::restore(const Snapshot& snapshot) {
  const std::vector<double>& before = snapshot.state_before;
  if (const std::size_t expected = 5 + 4 * mechanics_.size(); !before.empty() && before.size() != expected) {
    throw InputError("/snapshot/state_before",
                     "holds " + std::to_string(before.size()) + " numbers, not " + std::to_string(expected));
  }
  stiff_steps_.restore(snapshot.stiff_memory);  // which says what steps
  std::unique_ptr<Scheme> scheme = make_scheme(is_stiff() ? Method::Radau5 : method_, options_, mechanics_);
  if (!snapshot.memory.empty()) {
    std::vector<double> own;
    Memory memory(&own);
    exchange_memory(memory);
    scheme->exchange_memory(memory);
    if (own.size() != snapshot.memory.size()) Memory::refuse();
  }
  places_.restore(snapshot.singular_memory);
  rounding_.restore(snapshot.rounding_memory);
  events_.restore_discrete_state(snapshot.discrete_state);
  next_step = snapshot.next_step;
  scheme_ = std::move(scheme);  // which remembers no other motion
  drives_.follow(*scheme_);
  control_ = StepControl(scheme_->estimate_order(), snapshot.last_error, !before.empty() && before[0] != 0.0);
  advance_begin_ = snapshot.advance_begin;
  advance_end_ = snapshot.advance_end;
  drives_.restore(snapshot.time, snapshot.drive_memory);
  events_.restore(snapshot.report.events, snapshot.report.last_event, snapshot.event_slopes);
  trial_is_before_ = !before.empty();
  if (!trial_is_before_) return;
  std::size_t next = 1;
  for_each_number(trial_, [&](double& number) { number = before[next++]; });
  state.a.assign(before.begin() + static_cast<std::ptrdiff_t>(next), before.end());
}

void Integration::begin() {
  trial_ = state;  // what does not move stands in both
  if (mechanics_.rank_monitor() != nullptr) beyond_ = state;
  trial_is_before_ = false;
  watch_.forget();
  drives_.begin(state.t);
  places_.begin(state.t);
  keep_memory();
}

Outcome Integration::return_to_constraints() {
  Outcome found = mechanics_.linearise(trial_.t, trial_.x.data());
  if (found.ok()) {
    // Which is known, but the mechanics has to know it.
    found = mechanics_.accelerations(trial_.at(), options_.request(Gradients::Keep), trial_.a.data());
  }
  state.power = trial_.power;
  return found;
}

void Integration::restore_memory(const Snapshot& snapshot) {
  if (snapshot.memory.empty()) return;
  Memory memory{std::span(snapshot.memory)};
  exchange_memory(memory);
  scheme_->exchange_memory(memory);
  memory.finish();
}

void Integration::resume(const Snapshot& snapshot) {
  if (!snapshot.memory.empty()) {
    Memory memory{std::span(snapshot.memory)};
    exchange_memory(memory);
  }
  if (!trial_is_before_) trial_ = state;
  watch_.forget();
  places_.resume();
  keep_memory();
}

Outcome Integration::advance(double t_end, const Taken& taken, const Observer& observer) {
  has_stopped_ = false;
  drives_.advance(state.t, t_end);
  if (!scheme_->is_adaptive()) return advance_in_equal_steps(t_end, taken, observer);
  Outcome found = advance_adaptively(t_end, taken, observer);
  if (report_.accuracy_warning.empty()) report_.accuracy_warning = rounding_.explain();
  return found;
}

/// With the scheme, to t or to the first event on the way.
Integration::Attempt Integration::try_step(double t, bool may_surprise) {
  Attempt attempt;
  StepResult& step = attempt.step;
  trial_.t = t;
  trial_is_before_ = false;
  step = scheme_->step(state, t - state.t, &trial_);
  attempt.error = step.error;
  if (attempt.is_good()) look_between(&attempt);
  attempt.has_surprised = may_surprise && attempt.is_good() && places_.have_surprised();
  if (!attempt.is_good()) return attempt;
  const Events::Meeting meeting = events_.meet(*scheme_, state, drives_.pieces(), &trial_, &step);
  step.outcome = meeting.outcome;
  if (step.outcome.ok()) look_out(&attempt);
  if (step.outcome.ok() && meeting.asks_for_switch && !attempt.has_stopped) {
    attempt.has_switched = true;
    step.outcome = events_.switch_equations(*scheme_, state, &trial_);
  }
  return attempt;
}

/// For forces between the places that the scheme looked at. A step that is fixed stays as it was told, with a warning.
void Integration::look_between(Attempt* attempt) {
  if (scheme_->is_adaptive()) {
    attempt->part = passages_.look(*scheme_, state, trial_);
  } else if (report_.accuracy_warning.empty() && passages_.look(*scheme_, state, trial_) < 1.0) {
    report_.accuracy_warning = "steps are too long: one passes a force between two evaluations at t = " + text(state.t);
  }
}

/// For the user's events on the way of a good attempt; ends it at one that stops.
void Integration::look_out(Attempt* attempt) {
  if (watch_.is_empty() || trial_.t == state.t) return;
  StepResult& step = attempt->step;
  const DenseOutput by_ends(*scheme_, state, trial_, true), dense(*scheme_, state, trial_, !step.is_interpolated);
  double stop = 0.0;
  if (step.outcome = watch_.look(state, &trial_, by_ends, dense, &stop); !step.outcome.ok()) return;
  if (stop > trial_.t) return;
  attempt->has_stopped = true;
  if (stop == trial_.t || attempt->has_coasted) return;
  events_.forget();
  if (step.outcome = mechanics_.linearise(state.t, state.x.data()); !step.outcome.ok()) return;
  trial_.t = stop;
  step = scheme_->step(state, stop - state.t, &trial_);
}

/// Past a singular place, or near it: on along the last two states. Events on the way are met at its end.
Integration::Attempt Integration::try_coasting(double t, bool takes_least_error) {
  Attempt attempt;
  attempt.has_coasted = true;
  if (beyond_.x.empty()) beyond_ = state;
  if (!knows_acceleration()) {
    Outcome& found = attempt.step.outcome;
    found = mechanics_.accelerations(state.at(), options_.request(Gradients::Keep), state.a.data());
    if (!found.ok()) return attempt;
  }
  beyond_.t = t;
  attempt.step = places_.coast(*scheme_, trial_, state, takes_least_error, &beyond_);
  attempt.error = attempt.step.error;
  if (!attempt.is_good()) return attempt;
  std::swap(trial_, beyond_);
  look_out(&attempt);
  trial_is_before_ = attempt.is_good();
  return attempt;
}

/// Turned by theta in a step, on a circle:
///
///   |x1 - x0 - h (v0 + v1)/2| = theta^2/12 h |v|,   h |a1 - a0| = theta^2 |v|
double Integration::turn() const {
  // Other numbers than places, in charts that may have moved; and where equations change accelerations jump.
  if (!mechanics_.keeps_variables() || !trial_is_before_) return 0.0;
  constexpr double least_move = 1e-9;  // over positions, whose rounding would be seen
  // While a motion gathers its speed, as from rest, there is none yet to compare with.
  constexpr double gathering = 1.2;
  if (fastest_ > gathering * fastest_before_) return 0.0;
  const double h = state.t - trial_.t;
  const State &from = trial_, &to = state;
  double missed = 0.0, changed = 0.0, size = 0.0;
  for (std::size_t i = 0; i < to.x.size(); ++i) {
    missed = std::max(missed, std::abs(to.x[i] - from.x[i] - 0.5 * h * (from.v[i] + to.v[i])));
    changed = std::max(changed, std::abs(to.a[i] - from.a[i]));
    size = std::max(size, std::abs(to.x[i]));
  }
  if (!(h * fastest_ > least_move * size)) return 0.0;
  const double by_x = 12.0 * missed / (h * fastest_), by_a = knows_acceleration() ? h * changed / fastest_ : 0.0;
  return std::sqrt(std::max(by_x, by_a));
}

/// A step that was accepted; of length 0 where equations were switched before it.
void Integration::take_trial(const Attempt& attempt, const Taken& taken) {
  const double h = trial_.t - state.t;
  std::swap(state, trial_);
  limit_ = std::numeric_limits<double>::infinity();
  trial_is_before_ = mechanics_.keeps_variables() && !attempt.has_switched;
  if (attempt.has_switched) places_.forget();
  if (attempt.has_coasted) events_.forget();
  if (attempt.has_stopped) has_stopped_ = true;
  watch_.accept();
  report_.events = events_.count();
  report_.last_event = events_.last_time();
  if (h > 0.0) {
    report_.last_step = h;
    fastest_before_ = fastest_;
    if (!scheme_->is_adaptive()) {
      for (const double v : state.v) fastest_ = std::max(fastest_, std::abs(v));
    }
    taken(attempt.step);
  }
  places_.note(*scheme_, trial_, state, attempt.step);
  keep_memory();
}

/// A fixed step, in pieces where events lie on the way; one that fails is tried again in halves.
Outcome Integration::step_or_split(double t, int splits_left, const Taken& taken) {
  while (state.t < t && !has_stopped_) {
    const double h = t - state.t;
    const bool coasts = trial_is_before_ && places_.disturb(state.t, h);
    if (Outcome found = coasts ? Outcome{} : events_.start(state); !found.ok()) return found;
    if (!coasts) drives_.watch(state, h);
    const Attempt attempt = coasts ? try_coasting(t) : try_step(t, splits_left == most_splits);
    if (attempt.is_good()) {
      if (trial_.t == t) drives_.note(state, h);
      take_trial(attempt, taken);
      continue;
    }
    if (attempt.has_switched || splits_left == 0) return attempt.step.outcome;
    ++report_.rejected;
    if (Outcome back = mechanics_.linearise(state.t, state.x.data()); !back.ok()) return back;
    if (Outcome first = step_or_split(state.t + 0.5 * h, splits_left - 1, taken); !first.ok()) return first;
    return step_or_split(t, splits_left - 1, taken);
  }
  return {};
}

double Integration::longest_step() const {
  return options_.max_step > 0.0 ? options_.max_step : std::numeric_limits<double>::infinity();
}

std::string Integration::explain_missed() const {
  constexpr double small = 1e-2;  // of the largest speed
  return drives_.missed() > small * fastest_ ? drives_.describe() : "";
}

Outcome Integration::step_too_small(double resolution, const Outcome& reason) const {
  return {Status::StepTooSmall, "the step falls below " + text(resolution) + " s at t = " + text(state.t) +
                                    (reason.ok() ? "" : ": " + reason.what)};
}

/// Steps of at most `options.step` that end exactly at t_end. An advance that was stopped on its way there goes on
/// with its own steps.
Outcome Integration::advance_in_equal_steps(double t_end, const Taken& taken, const Observer& observer) {
  const double length = std::min(options_.step, longest_step());
  EqualSteps steps(advance_begin_, t_end, length);
  double k = steps.nearest(state.t);
  if (advance_end_ != t_end || steps.time(k) != state.t) {
    steps = EqualSteps(state.t, t_end, length);
    k = 0.0;
  }
  advance_begin_ = steps.begin();
  advance_end_ = t_end;
  const double resolution =
      16.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(t_end), std::abs(state.t));
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
  limit_ = std::numeric_limits<double>::infinity();
  report_.method = method;
}

/// From steps that stability holds short to implicit ones, and back where these get shorter.
Outcome Integration::look_for_stiffness(double t_end) {
  if (stiff_steps_.gives_up(next_step)) {
    take_scheme(method_, next_step);
    report_.method_reason = "implicit steps got shorter than explicit ones at t = " + text(state.t);
    return {};
  }
  const double h = report_.last_step;
  if (places_.is_coasting() || !stiff_steps_.is_due(h, t_end - state.t)) return {};
  if (stiff_steps_.look(state, h, &rounding_)) {
    take_scheme(Method::Radau5, stiff_steps_.implicit_step());
    report_.method_reason = stiff_steps_.explain();
  }
  // The forces of the step are evaluated again, as they were before the look.
  Outcome found = mechanics_.linearise(state.t, state.x.data());
  if (found.ok()) found = mechanics_.accelerations(state.at(), options_.request(Gradients::Keep), state.a.data());
  return found;
}

Outcome Integration::advance_adaptively(double t_end, const Taken& taken, const Observer& observer) {
  // Of what is left: at such a pace nobody would see the end.
  constexpr double tiny = 1e-8;
  constexpr int most_tiny_steps = 20000;
  for (int tiny_steps = 0; state.t < t_end && !has_stopped_;) {
    const double t = state.t;
    const bool is_disturbed = places_.disturb(t, std::min(next_step, t_end - t));
    const bool coasts = is_disturbed && trial_is_before_;
    if (is_disturbed && !coasts && places_.approach()) limit_ = next_step = std::min(next_step, places_.half_way(t));
    if (Outcome found = coasts ? coast_adaptively(t_end, taken) : step_adaptively(t_end, taken); !found.ok())
      return found;
    if (Outcome found = look_for_stiffness(t_end); !found.ok()) return found;
    if (state.t == t) continue;
    tiny_steps = state.t - t < tiny * (t_end - t) ? tiny_steps + 1 : 0;
    if (tiny_steps == most_tiny_steps) return step_too_small(tiny * (t_end - t), {});
    if (observer && !observer(report_)) break;
  }
  return {};
}

/// Tries a step past a singular place; where that fails, `next_step` is the length to try instead.
Outcome Integration::coast_adaptively(double t_end, const Taken& taken) {
  const auto end_of = [&](double h) { return h >= 0.99 * (t_end - state.t) ? t_end : state.t + h; };
  const double wanted = std::min(places_.coasting_length(trial_.t, state.t), longest_step());
  Attempt attempt = try_coasting(end_of(wanted));
  if (!attempt.is_good()) {
    ++report_.rejected;
    if (places_.pays_to_approach() && places_.approach()) {
      if (places_.is_coasting()) return {};
      limit_ = next_step = places_.half_way(state.t);
      return mechanics_.linearise(state.t, state.x.data());
    }
    // Nearer the error only grows: the scheme's own step passes what is no such place, the polynomial what is one.
    if (!places_.is_coasting() && !places_.lies_near_end(state.t, end_of(wanted)))
      attempt = try_passing(end_of(wanted));
    if (attempt.has_switched && !attempt.is_good()) return attempt.step.outcome;
    if (!attempt.is_good()) attempt = try_coasting(end_of(std::min(places_.longer(wanted), longest_step())), true);
  }
  if (attempt.is_good()) {
    take_trial(attempt, taken);
    return {};
  }
  if (places_.is_coasting()) {
    if (places_.approach()) return {};
    return attempt.step.outcome.ok() ? places_.explain_stop(state.t) : attempt.step.outcome;
  }
  if (Outcome back = mechanics_.linearise(state.t, state.x.data()); !back.ok()) return back;
  return step_adaptively(t_end, taken);
}

/// With the scheme past a place that is foreseen.
Integration::Attempt Integration::try_passing(double t) {
  Attempt attempt;
  attempt.step.outcome = mechanics_.linearise(state.t, state.x.data());
  if (attempt.step.outcome.ok()) attempt.step.outcome = events_.start(state);
  if (!attempt.step.outcome.ok()) return attempt;
  return try_step_and_remember(t, false);
}

/// A failed attempt leaves the state before alone where the next step may coast along it.
Integration::Attempt Integration::try_step_and_remember(double t, bool may_surprise) {
  const bool remembers = trial_is_before_ && places_.may_coast();
  if (!remembers) return try_step(t, may_surprise);
  if (beyond_.x.empty()) beyond_ = state;
  std::swap(trial_, beyond_);
  Attempt attempt = try_step(t, may_surprise);
  if (!attempt.is_good() && !attempt.has_switched) {
    std::swap(trial_, beyond_);
    trial_is_before_ = true;
  }
  return attempt;
}

/// Tries a step once; `next_step` is then the length to try next.
Outcome Integration::step_adaptively(double t_end, const Taken& taken) {
  if (Outcome found = events_.start(state); !found.ok()) return found;
  if (Outcome found = rounding_.measure(state); !found.ok()) return found;
  const double expected = std::min(next_step, t_end - state.t);
  rounding_.allow(state, expected, scheme_->rounding_gain());
  if (const double proposed = scheme_->propose_step(state); proposed > 0.0) next_step = std::min(proposed, limit_);
  next_step = std::min(next_step, longest_step());
  // End exactly at t_end, without a tiny last step.
  const double left = t_end - state.t;
  const double resolution = 16.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(state.t), left);
  const bool reaches = next_step >= 0.99 * left && left <= longest_step();
  const double fitting = reaches ? left : std::min(next_step, 0.51 * left > next_step ? next_step : 0.5 * left);
  const double h = drives_.shorten(state, fitting, resolution);
  const bool last = reaches && h == fitting;
  if (!last && !(h >= resolution)) return step_too_small(resolution, {});
  if (h != expected) rounding_.allow(state, h, scheme_->rounding_gain());
  const Attempt attempt = try_step_and_remember(last ? t_end : state.t + h, true);
  if (attempt.is_good()) {
    const double wanted = scheme_->choose_step(h, h * control_.accept(attempt.error));
    // A step cut short by t_end says little about the next one, one cut short by an event nothing: the whole one does,
    // but not that the next one may be longer. So does one that functions of time cut short.
    next_step = last || h < fitting ? std::max(wanted, std::min(next_step, 5.0 * wanted)) : wanted;
    if (attempt.has_switched) next_step = std::min(next_step, h);
    rounding_.note_step(state);
    stiff_steps_.note_step();
    take_trial(attempt, taken);
    return {};
  }
  const StepResult& step = attempt.step;
  if (attempt.has_switched) return step.outcome;
  ++report_.rejected;
  places_.note_rejection();
  if (step.outcome.ok() && attempt.error > 1.0) rounding_.note_rejection(h, attempt.error, scheme_->estimate_order());
  if (attempt.has_surprised) {
    places_.approach();
    limit_ = next_step = 0.5 * h;
    return {};
  }
  if (attempt.part < 1.0) {
    limit_ = next_step = attempt.part * h;
    return {};
  }
  const bool has_error = step.outcome.ok() && std::isfinite(attempt.error);
  limit_ = next_step = h * (has_error ? control_.reject(attempt.error) : 0.25);
  return next_step < resolution ? step_too_small(resolution, step.outcome) : Outcome{};
}

}  // namespace tanor
