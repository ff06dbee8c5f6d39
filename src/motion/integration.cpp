#include "motion/integration.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "motion/equal_steps.hpp"
#include "system/text.hpp"

namespace tanor {

namespace {

constexpr int most_splits = 8;  // of a fixed step that fails

}  // namespace

Integration::Integration(Method method, const MotionOptions& options, Mechanics& mechanics, MotionReport* report)
    : method_(method),
      options_(options),
      mechanics_(mechanics),
      report_(*report),
      scheme_(make_scheme(method, options, mechanics)),
      control_(scheme_->order()),
      events_(mechanics) {
  for (State* s : {&state, &trial}) {
    for (std::vector<double>* array : {&s->x, &s->v, &s->a}) array->resize(mechanics.size());
  }
}

void Integration::write(Snapshot* snapshot) const {
  snapshot->next_step = next_step;
  snapshot->last_error = control_.last_error();
  snapshot->advance_begin = advance_begin_;
  snapshot->advance_end = advance_end_;
  snapshot->discrete_state = mechanics_.discrete_state();
  snapshot->event_slopes = events_.slopes();
}

void Integration::restore(const Snapshot& snapshot) {
  mechanics_.restore_discrete_state(snapshot.discrete_state);
  next_step = snapshot.next_step;
  control_ = StepControl(scheme_->order(), snapshot.last_error);
  advance_begin_ = snapshot.advance_begin;
  advance_end_ = snapshot.advance_end;
  scheme_ = make_scheme(method_, options_, mechanics_);  // which remembers no other motion
  events_.restore(snapshot.report.events, snapshot.report.last_event, snapshot.event_slopes);
}

Outcome Integration::advance(double t_end, const Taken& taken, const Observer& observer) {
  if (Outcome found = events_.start(state); !found.ok()) return found;
  return scheme_->is_adaptive() ? advance_adaptively(t_end, taken, observer)
                                : advance_in_equal_steps(t_end, taken, observer);
}

/// A step that was accepted; of length 0 where equations were switched before it.
void Integration::take_trial(const StepResult& step, const Taken& taken) {
  const double h = trial.t - state.t;
  std::swap(state, trial);
  report_.events = events_.count();
  report_.last_event = events_.last_time();
  if (h == 0.0) return;
  report_.last_step = h;
  taken(step);
}

/// A fixed step, in pieces where events lie on the way; one that fails is tried again in halves.
Outcome Integration::step_or_split(double t, int splits_left, const Taken& taken) {
  while (state.t < t) {
    trial.t = t;
    const double h = t - state.t;
    StepResult step = scheme_->step(state, h, &trial);
    if (step.outcome.ok()) {
      const Events::Meeting meeting = events_.meet(*scheme_, state, &trial, &step);
      if (meeting.outcome.ok()) {
        take_trial(step, taken);
        continue;
      }
      if (meeting.has_switched) return meeting.outcome;
      step.outcome = meeting.outcome;
    }
    if (splits_left == 0) return step.outcome;
    ++report_.rejected;
    if (Outcome back = mechanics_.linearise(state.t, state.x.data()); !back.ok()) return back;
    if (Outcome first = step_or_split(state.t + 0.5 * h, splits_left - 1, taken); !first.ok()) return first;
    return step_or_split(t, splits_left - 1, taken);
  }
  return {};
}

Outcome Integration::step_too_small(double resolution, const Outcome& reason) const {
  return {Status::StepTooSmall, "the step falls below " + text(resolution) + " s at t = " + text(state.t) +
                                    (reason.ok() ? "" : ": " + reason.what)};
}

/// Steps of at most `options.step` that end exactly at t_end. An advance that was stopped on its way there goes on
/// with its own steps.
Outcome Integration::advance_in_equal_steps(double t_end, const Taken& taken, const Observer& observer) {
  EqualSteps steps(advance_begin_, t_end, options_.step);
  double k = steps.nearest(state.t);
  if (advance_end_ != t_end || steps.time(k) != state.t) {
    steps = EqualSteps(state.t, t_end, options_.step);
    k = 0.0;
  }
  advance_begin_ = steps.begin();
  advance_end_ = t_end;
  const double resolution =
      16.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(t_end), std::abs(state.t));
  if (steps.length() < resolution) return step_too_small(resolution, {});
  while (k < steps.count()) {
    if (Outcome found = step_or_split(steps.time(++k), most_splits, taken); !found.ok()) return found;
    if (observer && !observer(report_)) break;
  }
  return {};
}

Outcome Integration::advance_adaptively(double t_end, const Taken& taken, const Observer& observer) {
  while (state.t < t_end) {
    // End exactly at t_end, without a tiny last step.
    const double left = t_end - state.t;
    const bool last = next_step >= 0.99 * left;
    const double h = last ? left : std::min(next_step, 0.51 * left > next_step ? next_step : 0.5 * left);
    trial.t = last ? t_end : state.t + h;
    StepResult step = scheme_->step(state, h, &trial);
    const double error = step.error;
    bool has_switched = false;
    if (step.outcome.ok() && error <= 1.0) {
      const Events::Meeting meeting = events_.meet(*scheme_, state, &trial, &step);
      has_switched = meeting.has_switched;
      if (has_switched && !meeting.outcome.ok()) return meeting.outcome;
      step.outcome = meeting.outcome;
    }
    if (!step.outcome.ok() || !(error <= 1.0)) {
      ++report_.rejected;
      const bool has_error = step.outcome.ok() && std::isfinite(error);
      next_step = h * (has_error ? control_.reject(error) : 0.25);
      const double resolution = 16.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(state.t), left);
      if (next_step < resolution) {
        return step_too_small(resolution, step.outcome);
      }
      continue;
    }
    const double wanted = h * control_.accept(error);
    // A step cut short by t_end says little about the next one, one cut short by an event nothing: the whole one does,
    // but not that the next one may be longer.
    next_step = last ? std::max(wanted, std::min(next_step, 5.0 * wanted)) : wanted;
    if (has_switched) next_step = std::min(next_step, h);
    const bool has_moved = trial.t > state.t;
    take_trial(step, taken);
    if (has_moved && observer && !observer(report_)) break;
  }
  return {};
}

}  // namespace tanor
