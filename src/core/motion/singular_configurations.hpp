#pragma once

#include <cmath>
#include <limits>

#include "motion/extrapolation.hpp"
#include "motion/passage_finder.hpp"
#include "motion/scheme.hpp"
#include "motion/singular_forecast.hpp"

namespace tanor::detail {

/// Handles configurations where K loses rank during one motion. They are foreseen, passed by extrapolation, and named
/// in the report. If the mechanics has no rank monitor, there are none.
class SingularConfigurations {
 public:
  /// If `follows` is true, K is compared from step to step, as for steps that choose their own lengths; otherwise only
  /// past configurations that are foreseen.
  SingularConfigurations(const IntegrationOptions& options, Mechanics& mechanics, bool follows, MotionReport* report)
      : options_(options),
        mechanics_(mechanics),
        monitor_(mechanics.rank_monitor()),
        follows_(follows),
        report_(*report),
        finder_(options, mechanics) {}

  /// Begins a motion at t, where the mechanics has solved.
  void begin(double t);
  /// Resumes a motion from a snapshot at t, maybe of a system that has changed there. The mechanics has solved where it
  /// was on the constraints last.
  void resume(double t);
  /// Exchanges what the next steps depend on; nothing without a rank monitor.
  void exchange_memory(Memory& memory);
  /// Forgets the previous steps, which tell nothing any more after the equations have changed.
  void forget() { memory_ = {}; }
  /// Takes note of an accepted step. The mechanics is at its end, and is there again afterwards.
  void note(Scheme& scheme, const State& from, const State& to, const StepResult& step);

  // ---- whether the next step extrapolates ----

  /// Returns true if the state is extrapolated and has not come back to the constraints yet.
  bool is_extrapolating() const { return memory_.is_extrapolating; }
  /// Returns true if the next step may extrapolate, as far as is foreseen. It then depends on the previous state, too.
  bool may_extrapolate() const { return is_extrapolating() || std::isfinite(memory_.forecast.time()); }
  /// Returns true if a step of length h from t has to extrapolate.
  bool disturb(double t, double h) const {
    const bool was_approached = memory_.is_in_the_way && memory_.approaches > 0;
    return is_extrapolating() || (was_approached && memory_.forecast.lies_ahead_of(t)) ||
           memory_.forecast.disturbs(t, memory_.is_in_the_way ? singular::reach * h : h);
  }
  /// Takes note of a rejected step. If a singular configuration lies ahead, a longer step leads beyond it.
  void note_rejection() { memory_.is_in_the_way = true; }
  /// Returns true if the last step met a singular configuration that was not foreseen. A shorter step foresees it
  /// first.
  bool have_surprised() const;

  // ---- approaches, each to half the distance ----

  /// Returns true if the error of the last extrapolation has fallen as its order predicts, so that it will be less from
  /// nearer. It does not fall if the motion only seems to approach a singular configuration, nor if only rounding is
  /// left.
  bool pays_to_approach() const { return memory_.pays_to_approach; }
  /// Asks for a shorter step. Returns false if that was asked for often enough.
  bool approach() {
    memory_.is_in_the_way = false;  // until that step is taken
    return ++memory_.approaches <= singular::most_approaches;
  }
  /// Tells why the motion ends at t, after the last approach.
  Outcome explain_stop(double t) const;
  double half_way(double t) const { return 0.5 * (memory_.forecast.time() - t); }

  // ---- extrapolations ----

  /// Returns the length of a step that extrapolates, half as far beyond the singular configuration as that lies ahead.
  /// An extrapolated state goes on by the last step's length, halved with each approach.
  double extrapolation_length(double t_before, double t) const;
  /// Returns the length to try instead of h. A step that returns to the constraints had a smaller error when it was
  /// twice as long.
  double longer(double h) const { return is_extrapolating() && memory_.approaches > 0 ? 2.0 * h : h; }
  bool lies_near_end(double t, double t_end) const { return memory_.forecast.lies_near(t_end, t_end - t); }
  /// Continues from `from` along `before` and `from` to `to`, whose time is given. An error above 1 asks for a shorter
  /// step.
  StepResult extrapolate(Scheme& scheme, const State& before, const State& from, bool takes_least_error, State* to);

 private:
  bool is_at_one() const;
  void note_end(double t);
  void note_nearest(double t);
  void note_at_one(double t);
  void remember(double t);
  void find_passages(Scheme& scheme, const State& from, const State& to, bool is_interpolated);
  void note_found(double t, double h);
  void note_passage(double t, double reciprocal_condition);
  void withdraw_passage();
  void forget_approaches();
  void note_rank(double t);
  bool keeps_last_passage() const;

  IntegrationOptions options_;
  Mechanics& mechanics_;
  RankMonitor* const monitor_;  // null if K keeps its rank
  bool follows_;
  MotionReport& report_;
  /// Knowledge from the previous steps.
  struct Past {
    SingularForecast forecast;
    bool is_extrapolating = false;
    bool is_at_one = false;      // true if the last step ended at a singular configuration
    bool is_in_the_way = false;  // true if a zero ahead stopped a step, or was approached
    bool pays_to_approach = false;
    bool is_foreseen = false;                                              // the last passage's time is a forecast
    int approaches = 0;                                                    // to the foreseen configuration …
    double extrapolation_error = std::numeric_limits<double>::infinity();  // … and the error from the last of them
    double last_passage = std::numeric_limits<double>::quiet_NaN();
    double remembered = std::numeric_limits<double>::quiet_NaN();  // time of the K to compare with
  } memory_;
  double regular_ = 0.0;  // reciprocal condition of S that masses alone may cause, or the largest one so far
  PassageFinder finder_;
  Extrapolation extrapolation_;
};

}  // namespace tanor::detail
