#include "motion/step_trial.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "base/text.hpp"

namespace tanor::detail {

StepTrial::StepTrial(const IntegrationOptions& options, Mechanics& mechanics, const Motion& motion,
                     MotionReport* report)
    : events(options, mechanics),
      watch(options, mechanics),
      corners(options, mechanics),
      arms(options, mechanics),
      options_(options),
      mechanics_(mechanics),
      motion_(motion),
      report_(*report),
      sampler_(options, mechanics, *motion.scheme) {}

void StepTrial::begin() {
  state = motion_.state;  // what does not move is the same in both
  if (mechanics_.rank_monitor() != nullptr) beyond_ = motion_.state;
  is_before = false;
}

StepAttempt StepTrial::step(double t, bool may_surprise, Looks looks) {
  StepAttempt attempt;
  StepResult& step = attempt.step;
  state.t = t;
  is_before = false;
  end = {};
  step = motion_.scheme->step(motion_.state, t - motion_.state.t, &state);
  attempt.error = step.error;
  if (looks == Looks::Between) look_between(&attempt);
  attempt.has_surprised = may_surprise && attempt.is_good() && motion_.singular.have_surprised();
  if (!step.outcome.ok() && !motion_.scheme->is_adaptive()) end_before_arms_vanish(&attempt);
  if (!attempt.is_good()) return attempt;
  const Events::Meeting meeting = events.meet(*motion_.scheme, motion_.state, motion_.drives.pieces(), &state, &step);
  step.outcome = meeting.outcome;
  if (step.outcome.ok() && !attempt.has_stopped) end_before_arms_vanish(&attempt);
  if (step.outcome.ok()) detect_user_events(&attempt);
  if (step.outcome.ok() && meeting.asks_for_switch && !attempt.has_stopped) {
    attempt.has_switched = true;
    step.outcome = events.switch_equations(*motion_.scheme, motion_.state, &state);
  }
  return attempt;
}

/// Where such short steps fail the step passes over the jump, and so do all that follow where jumps come one upon the
/// other.
StepAttempt StepTrial::step_to_jump(double t, bool may_surprise, JumpSteps* jumps) {
  constexpr int most_tries = 20;
  const State& from = motion_.state;
  const double resolution = time_resolution(from.t, t - from.t);
  StepAttempt attempt = step(t, may_surprise, jumps->are_passed ? Looks::None : Looks::Between);
  const auto try_again = [&](double to, Looks looks) {
    ++report_.rejected;
    attempt = {};
    attempt.step.outcome = mechanics_.linearise(from.t, from.x.data());
    if (attempt.step.outcome.ok()) attempt.step.outcome = events.start(from);
    if (attempt.step.outcome.ok()) attempt = step(to, may_surprise, looks);
  };
  bool is_short = false;
  for (int tries = 0; attempt.jump.exists() && !jumps->are_passed && tries < most_tries; ++tries) {
    const JumpSteps::Cut cut =
        jumps->cut_at(attempt.jump, motion_.scheme->looks().size() > 2, state.t - from.t, resolution);
    const Outcome goes_on = cut.is_over ? jumps->note_jump(attempt.jump, from.t, resolution) : Outcome{};
    jumps->are_passed = !goes_on.ok();
    if (jumps->are_passed && report_.accuracy_warning.empty()) report_.accuracy_warning = goes_on.what;
    is_short = from.t + cut.length < t;
    if (!jumps->are_passed) try_again(is_short ? from.t + cut.length : t, cut.is_over ? Looks::None : Looks::Between);
  }
  if (attempt.jump.exists() || (is_short && !attempt.is_good() && !attempt.has_switched)) try_again(t, Looks::None);
  return attempt;
}

/// Looks for forces between the instants at which the scheme evaluated them. A fixed step that passes one keeps its
/// length, with a warning. The error of an adaptive step over a jump tells nothing, and it may fail there. A step that
/// has passed a corner is not made.
void StepTrial::look_between(StepAttempt* attempt) {
  constexpr double half = 0.5;
  if (attempt->is_good() && corners.have_passed(*motion_.scheme, motion_.state, state)) {
    attempt->part = half;
    return;
  }
  if (motion_.scheme->is_adaptive()) {
    const bool is_good = attempt->is_good(), has_end = attempt->step.outcome.ok();
    if (!is_good && !sampler_.may_find_jumps()) return;
    const double part = has_end ? sampler_.look(*motion_.scheme, motion_.state, state) : 1.0;
    if (is_good) attempt->part = part;
    const bool has_found = has_end && sampler_.found_jump().exists();
    if (!is_good && !has_found) sampler_.look_along_parabola(*motion_.scheme, motion_.state, state.t);
    attempt->jump = sampler_.found_jump();
  } else if (attempt->step.outcome.ok() && (sampler_.may_find_jumps() || report_.accuracy_warning.empty())) {
    const double part = sampler_.look(*motion_.scheme, motion_.state, state);
    attempt->jump = sampler_.found_jump();
    if (part < 1.0 && report_.accuracy_warning.empty()) {
      report_.accuracy_warning = "steps are too long: one passes " + sampler_.name_passed() +
                                 " between two evaluations at t = " + text(motion_.state.t);
    }
  }
}

/// Looks for the user's events during a good attempt, which ends at one that stops.
void StepTrial::detect_user_events(StepAttempt* attempt) {
  if (watch.is_empty() || state.t == motion_.state.t) return;
  StepResult& step = attempt->step;
  const DenseOutput dense(*motion_.scheme, motion_.state, state, !step.is_interpolated);
  double stop = 0.0;
  if (step.outcome = watch.look(motion_.state, &state, dense, &stop); !step.outcome.ok()) return;
  if (stop > state.t) return;
  attempt->has_stopped = true;
  if (!attempt->is_extrapolated) watch.end_at(stop);
  if (stop == state.t || attempt->is_extrapolated) return;
  end = {};
  step_again(motion_.state, stop, attempt);
}

/// Makes the step again, to another end, or what is left of it from a state on its way.
void StepTrial::step_again(const State& from, double t, StepAttempt* attempt) {
  StepResult& step = attempt->step;
  events.forget();
  if (step.outcome = mechanics_.linearise(from.t, from.x.data()); !step.outcome.ok()) return;
  state.t = t;
  step = motion_.scheme->step(from, t - from.t, &state);
}

/// Ends a step in which an arm vanishes right before. A step may have met the instant although its end and the way
/// there do not show it: it failed, or the projection moved its end back. No error tells that of a motion along a line.
void StepTrial::end_before_arms_vanish(StepAttempt* attempt) {
  constexpr double margin = 1.1;  // for the error of the prediction
  const State& from = motion_.state;
  const double h = state.t - from.t;
  if (arms.is_empty() || !(h > 0.0)) return;
  StepResult& step = attempt->step;
  bool knows = knows_acceleration();
  std::optional<VanishingArms::Found> arm;
  if (!step.outcome.ok() || arms.are_short(from, state)) {
    const bool moves = !knows;
    if (moves) knows = mechanics_.linearise(from.t, from.x.data()).ok() && find_acceleration().ok();
    arm = arms.find_ahead(from, knows, margin * h);
    if (moves && !arm && step.outcome.ok()) step.outcome = mechanics_.linearise(state.t, state.x.data());
  }
  if (!arm && step.outcome.ok()) arm = arms.find(*motion_.scheme, from, state);
  if (!arm) return;
  if (!arms.is_unresolved(*arm, from)) return approach(*arm, arms.time_left(*arm, from, knows), attempt);
  attempt->has_stopped = true;
  step.outcome = end = arms.explain(*arm, arm->time);
}

/// Makes the step again, to a tenth of the time that is left and so on, since no step that ends behind the instant can
/// be trusted. A step that fails is made from where the last one led, since it may be too long beside what is left of
/// the arm. If steps fail long before the instant, the last good one is taken, and the motion goes on from it.
void StepTrial::approach(const VanishingArms::Found& arm, double left_at_begin, StepAttempt* attempt) {
  constexpr double part = 0.9, right_before = 1e-3;
  constexpr int most_steps = 100;
  const double begin = motion_.state.t, end_of_step = state.t;
  const double finest = 4.0 * time_resolution(arm.time, arm.time - begin);
  const double whole = left_at_begin > 0.0 ? std::min(arm.time - begin, left_at_begin) : arm.time - begin;
  double good = 0.0, left = whole, next = 0.5 * left;
  State reached, base;
  const State* from = &motion_.state;
  StepResult result;
  for (int step = 0; step < most_steps && left > finest && next > good; ++step) {
    step_again(*from, begin + next, attempt);
    const double ahead = attempt->step.outcome.ok() ? arms.time_left(arm, state, knows_acceleration()) : -1.0;
    if (ahead >= 0.0 && ahead < left) {
      reached = state;
      result = attempt->step;
      good = next;
      left = ahead;
      next = good + part * left;
    } else if (good > 0.0 && from->t < reached.t) {
      base = reached;
      from = &base;
      next = good + 0.5 * left;
    } else {
      next = good + 0.5 * (next - good);
    }
  }
  const double rounded = good > 0.0 ? std::max(finest, arms.rounding_of_time(arm, reached)) : finest;
  if (good > 0.0 && begin + good + left > end_of_step + rounded)  // the prediction was too early
    return step_again(motion_.state, end_of_step, attempt);
  if (good > 0.0 && (state.t != begin + good || !attempt->step.outcome.ok())) {
    state = reached;
    attempt->step = result;
    attempt->step.is_interpolated = false;
    attempt->step.outcome = mechanics_.linearise(state.t, state.x.data());
  }
  if (from == &base) attempt->step.is_interpolated = false;
  if (good > 0.0 && left > std::max(finest, right_before * whole)) return;
  end = arms.explain(arm, begin + good + left);
  attempt->has_stopped = true;
  if (!(good > 0.0)) attempt->step.outcome = end;
}

Outcome StepTrial::find_acceleration() {
  if (knows_acceleration()) return {};
  return mechanics_.accelerations(motion_.state.at(), options_.request(Gradients::Keep),
                                  motion_.state.output_without_power());
}

Outcome StepTrial::find_jump(double within) {
  if (!sampler_.may_find_jumps()) return {};
  sampler_.look_along_parabola(*motion_.scheme, motion_.state, motion_.state.t + within);
  return JumpSteps::explain(sampler_.found_jump(), motion_.state.t);
}

StepAttempt StepTrial::extrapolate(double t, bool takes_least_error) {
  StepAttempt attempt;
  attempt.is_extrapolated = true;
  end = {};
  if (beyond_.x.empty()) beyond_ = motion_.state;
  if (attempt.step.outcome = find_acceleration(); !attempt.step.outcome.ok()) return attempt;
  beyond_.t = t;
  attempt.step = motion_.singular.extrapolate(*motion_.scheme, state, motion_.state, takes_least_error, &beyond_);
  attempt.error = attempt.step.error;
  if (!attempt.is_good()) return attempt;
  swap(state, beyond_);
  detect_user_events(&attempt);
  is_before = attempt.is_good();
  return attempt;
}

StepAttempt StepTrial::pass(double t) {
  StepAttempt attempt;
  attempt.step.outcome = mechanics_.linearise(motion_.state.t, motion_.state.x.data());
  if (attempt.step.outcome.ok()) attempt.step.outcome = events.start(motion_.state);
  if (!attempt.step.outcome.ok()) return attempt;
  return step_and_remember(t, false);
}

StepAttempt StepTrial::cross(double t) {
  StepAttempt attempt;
  is_before = false;
  end = {};
  if (attempt.step.outcome = find_acceleration(); !attempt.step.outcome.ok()) return attempt;
  attempt.step = corners.cross(motion_.state, t, &state);
  attempt.has_switched = true;
  if (!attempt.step.outcome.ok()) return attempt;
  motion_.scheme->forget();
  events.note_crossing(state.t);
  detect_user_events(&attempt);
  return attempt;
}

StepAttempt StepTrial::step_and_remember(double t, bool may_surprise, Looks looks) {
  const bool remembers = is_before && motion_.singular.may_extrapolate();
  if (!remembers) return step(t, may_surprise, looks);
  if (beyond_.x.empty()) beyond_ = motion_.state;
  swap(state, beyond_);
  StepAttempt attempt = step(t, may_surprise, looks);
  if (!attempt.is_good() && !attempt.has_switched) {
    swap(state, beyond_);
    is_before = true;
  }
  return attempt;
}

}  // namespace tanor::detail
