#pragma once

#include <cmath>
#include <limits>

#include "motion/extrapolation.hpp"
#include "motion/passage_finder.hpp"
#include "motion/scheme.hpp"
#include "motion/singular_forecast.hpp"

namespace tanor {

/// Configurations where K loses rank on the way of one motion. They are foreseen, passed by extrapolation, and named in
/// the report. Without a rank monitor of the mechanics there are none.
class SingularConfigurations {
 public:
  /// `follows`: K is compared from step to step, as steps that choose their own lengths allow; else past configurations
  /// that are foreseen.
  SingularConfigurations(const IntegrationOptions& options, Mechanics& mechanics, bool follows, MotionReport* report)
      : options_(options),
        mechanics_(mechanics),
        monitor_(mechanics.rank_monitor()),
        follows_(follows),
        report_(*report),
        finder_(options, mechanics) {}

  /// The motion begins at t, where the mechanics has solved.
  void begin(double t);
  /// The motion goes on from a snapshot; the mechanics has solved where it was on the constraints last.
  void resume();
  /// What the next steps depend on; nothing without a rank monitor.
  void exchange_memory(Memory& memory);
  /// The equations have changed: nothing of the steps before says what comes.
  void forget() { memory_ = {}; }
  /// A step was taken. The mechanics is where it ended, and stays there.
  void note(Scheme& scheme, const State& from, const State& to, const StepResult& step);

  // ---- whether the next step extrapolates ----

  /// The state is extrapolated: it has not come back to the constraints yet.
  bool is_extrapolating() const { return memory_.is_extrapolating; }
  /// The next step may extrapolate, as far as is foreseen: it then depends on the state before, too.
  bool may_extrapolate() const { return is_extrapolating() || std::isfinite(memory_.forecast.time()); }
  /// A step of length h from t has to extrapolate.
  bool disturb(double t, double h) const {
    const bool was_approached = memory_.is_in_the_way && memory_.approaches > 0;
    return is_extrapolating() || (was_approached && memory_.forecast.lies_ahead_of(t)) ||
           memory_.forecast.disturbs(t, memory_.is_in_the_way ? singular::reach * h : h);
  }
  /// A step from here was rejected. Where a singular configuration lies ahead, a longer step leads beyond it.
  void note_rejection() { memory_.is_in_the_way = true; }
  /// The last step came upon a singular configuration that was not foreseen. A shorter step first foresees it.
  bool have_surprised() const;

  // ---- approaches, each to half the distance ----

  /// The error of the last extrapolation has fallen as its order says: from nearer it will be less. It does not fall
  /// where the motion only seems to come to a singular configuration, nor where rounding is all that is left.
  bool pays_to_approach() const { return memory_.pays_to_approach; }
  /// Asks for a shorter step; false where that was asked for often enough.
  bool approach() {
    memory_.is_in_the_way = false;  // until that step was taken
    return ++memory_.approaches <= singular::most_approaches;
  }
  /// Why the motion ends at t, after the last approach.
  Outcome explain_stop(double t) const;
  double half_way(double t) const { return 0.5 * (memory_.forecast.time() - t); }

  // ---- extrapolations ----

  /// Length of a step that extrapolates: half as far beyond the singular configuration as that lies ahead.
  double extrapolation_length(double t_before, double t) const;
  /// A step that comes back to the constraints had a smaller error when it was twice as long.
  double longer(double h) const { return is_extrapolating() && memory_.approaches > 0 ? 2.0 * h : h; }
  bool lies_near_end(double t, double t_end) const { return memory_.forecast.lies_near(t_end, t_end - t); }
  /// Goes on from `from` along `before` and it, to `to`, whose time is given. An error above 1 asks for a shorter step.
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
  RankMonitor* const monitor_;  // null: K keeps its rank
  bool follows_;
  MotionReport& report_;
  /// Of the steps before.
  struct Past {
    SingularForecast forecast;
    bool is_extrapolating = false;
    bool is_at_one = false;      // the last step ended at a singular configuration
    bool is_in_the_way = false;  // a zero ahead stopped a step, or was approached
    bool pays_to_approach = false;
    bool is_foreseen = false;                                              // the time of the last passage is a forecast
    int approaches = 0;                                                    // to the configuration that is foreseen …
    double extrapolation_error = std::numeric_limits<double>::infinity();  // … and the error from the last of them
    double last_passage = std::numeric_limits<double>::quiet_NaN();
    double remembered = std::numeric_limits<double>::quiet_NaN();  // the time of the K to compare with
  } memory_;
  double regular_ = 0.0;  // reciprocal condition of S that masses alone may bring about, or the largest one so far
  PassageFinder finder_;
  Extrapolation extrapolation_;
};

}  // namespace tanor
