#pragma once

#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "motion/coasting.hpp"
#include "motion/dense_output.hpp"
#include "motion/scheme.hpp"

namespace tanor {

/// The places where K loses rank on the way of one motion: foresees them, passes them by coasting, and says in the
/// report which ones it met.
class SingularPlaces {
 public:
  /// `follows`: K is compared from step to step, where their lengths are nobody's choice; else past places that are
  /// foreseen.
  SingularPlaces(const IntegrationOptions& options, Mechanics& mechanics, bool follows, MotionReport* report)
      : options_(options),
        mechanics_(mechanics),
        monitor_(mechanics.rank_monitor()),
        follows_(follows),
        report_(*report) {}

  /// The motion begins at t, where the mechanics has solved.
  void begin(double t);
  /// It goes on from what was restored; the mechanics has solved where it was on the constraints last.
  void resume();
  /// What the next steps depend on, plain numbers, to and from a snapshot; empty: K keeps its rank. Throws InputError.
  void write(std::vector<double>* numbers) const;
  void restore(std::span<const double> numbers);
  /// It is foreseen that the next step may coast: it then depends on the state before, too.
  bool may_coast() const { return is_coasting() || std::isfinite(memory_.forecast.time()); }
  /// The equations have changed: nothing of the steps before says what comes.
  void forget() { memory_ = {}; }
  /// A step was taken; the mechanics is where it ended, and stays there.
  void note(Scheme& scheme, const State& from, const State& to, const StepResult& step);

  /// The state has not come back to the constraints yet.
  bool is_coasting() const { return memory_.is_coasting; }
  /// A step of length h from t has to coast.
  bool disturb(double t, double h) const {
    const bool stays_away = memory_.is_in_the_way && memory_.approaches > 0 && memory_.forecast.time() > t;
    return is_coasting() || (stays_away && std::isfinite(memory_.forecast.time())) ||
           memory_.forecast.disturbs(t, memory_.is_in_the_way ? reach * h : h);
  }
  /// A step from here was rejected: where such a place lies ahead, steps that shrink on the way would never reach it.
  /// Longer ones lead beyond.
  void note_rejection() { memory_.is_in_the_way = true; }
  /// The last step came upon such a place out of nowhere: a shorter one first, to foresee it.
  bool have_surprised() const;

  /// The error of the last step that coasted has fallen as its order says: from nearer it will be less. It does not
  /// where the motion only seems to come to such a place, nor where rounding is all that is left.
  bool pays_to_approach() const { return memory_.pays_to_approach; }
  /// The next step is to be shorter; false: it was often enough.
  bool approach() {
    memory_.is_in_the_way = false;  // until that step was taken
    return ++memory_.approaches <= most_approaches;
  }
  /// Why the motion ends at t, after the last approach.
  Outcome explain_stop(double t) const;
  double half_way(double t) const { return 0.5 * (memory_.forecast.time() - t); }
  /// Of a step that coasts: half as far beyond the place as it lies ahead.
  double coasting_length(double t_before, double t) const;
  /// A step that comes back to the constraints had a smaller error when it was twice as long.
  double longer(double h) const { return is_coasting() && memory_.approaches > 0 ? 2.0 * h : h; }
  bool lies_near_end(double t, double t_end) const { return memory_.forecast.lies_near(t_end, t_end - t); }
  /// From `from` on along `before` and it, to `to`, whose time is given; an error above 1: try a shorter step.
  StepResult coast(Scheme& scheme, const State& before, const State& from, bool takes_least_error, State* to);

 private:
  static constexpr int most_approaches = 12;
  static constexpr double reach = 4.0;  // in steps, of what is in the way

  template <class M, class Visit>
  static void for_each_number(M& memory, const Visit& visit);
  bool is_at_one() const;
  void note_place(double t);
  void remember(double t);
  void find_passages(Scheme& scheme, const State& from, const State& to, bool is_interpolated);
  Outcome go_inside(DenseOutput* dense, double fraction);
  double narrow(DenseOutput* dense, double low, double high, double value_high);
  void note_found(double t, double h);
  void note_passage(double t, double reciprocal_condition);
  void withdraw_passage();
  void forget_approaches();
  void note_rank(double t);

  IntegrationOptions options_;
  Mechanics& mechanics_;
  RankMonitor* const monitor_;  // null: K keeps its rank
  bool follows_;
  MotionReport& report_;
  /// Of the steps before.
  struct Memory {
    SingularForecast forecast;
    bool is_coasting = false, is_at_one = false, is_in_the_way = false;
    bool pays_to_approach = false;
    bool is_foreseen = false;  // the last passage: its time is not more than that
    int approaches = 0;        // to the place that is foreseen, each halves the way …
    double coasting_error = std::numeric_limits<double>::infinity();  // … and this of the last of them
    double last_passage = std::numeric_limits<double>::quiet_NaN();
    double remembered = std::numeric_limits<double>::quiet_NaN();  // the time of the K to compare with
  } memory_;
  double regular_ = 0.0;  // reciprocal condition of S that masses alone may bring about, or the largest one so far
  std::vector<double> x_, v_, a_;  // inside a step
  Coasting coasting_;
};

}  // namespace tanor
