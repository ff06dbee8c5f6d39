#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "motion/dense_output.hpp"
#include "motion/scheme.hpp"

namespace tanor::detail {

/// Ends steps where the equations of a mechanics change, and switches the equations there.
///
/// A function that is positive at the start of a step and not at its end is always met. A function that vanishes twice
/// inside a step is met only if something hints at it: the step is the first one after a switch, or a parabola with the
/// slope of the previous step falls, inside, below half of both end values. The functions are then evaluated at three
/// places inside the step and where parabolas through them fall below 0. A dip without such a hint, or one that is
/// narrower than a quarter of the step and far from a parabola, is missed; only a smaller step or tolerance finds it.
/// The inside of a step that extrapolates past a singular configuration is not sampled: an event in it is met at its
/// end.
///
/// Allocates nothing unless the number of functions or of variables grows.
class Events {
 public:
  Events(const IntegrationOptions& options, Mechanics& mechanics)
      : options_(options), mechanics_(mechanics), functions_(mechanics.events()) {
    count_functions();
  }

  struct Meeting {
    Outcome outcome;
    bool asks_for_switch = false;
  };

  /// Evaluates the functions at `state` before a step from there, unless they are known from the last step.
  Outcome start(const State& state);
  /// Forgets the last step; call this if the next step does not start where the last one ended.
  void forget();

  /// Takes note that the motion crossed a corner at t, and forgets the last step.
  void note_crossing(double t) {
    forget();
    ++switches_.count;
    switches_.last_time = t;
    switches_.last_change = "the equations have a corner";
  }

  /// Examines an accepted step from `from` to `to`. If a function vanishes on the way, the step is repeated so that it
  /// ends at the first such instant, and the result asks for a switch there. `to` and `step` are then those of the
  /// shorter step, whose length is 0 if a function falls from 0 at once. On a failed outcome `to` is meaningless. The
  /// functions are evaluated at the ends of `pieces` equal parts of the step; if `pieces` is 1, the inside is sampled
  /// only on a hint at a dip.
  Meeting meet(Scheme& scheme, const State& from, int pieces, State* to, StepResult* step);
  /// Switches the equations where `meet` asked for it. The next step has to start from `to`. If the switch fails, no
  /// other step helps.
  Outcome switch_equations(Scheme& scheme, const State& from, State* to);

  std::size_t count() const { return switches_.count; }
  double last_time() const { return switches_.last_time; }  ///< s, of the last event
  const std::string& last_change() const { return switches_.last_change; }
  /// Moves the changes of one-sided constraints since the last call behind `list`.
  void take_changes(std::vector<ContactEvent>* list);
  /// Takes note of those at the beginning of a motion.
  void note_changes();

  /// Slopes of the functions over the last step, 1/s, on which the next step depends besides the state; empty if
  /// unknown.
  const std::vector<double>& slopes() const { return slopes_; }
  void restore(std::size_t count, double last_time, std::span<const double> slopes);
  /// Returns the discrete state of the mechanics, which is empty if its equations never change.
  std::vector<int> discrete_state() const;
  void restore_discrete_state(std::span<const int> state);
  /// Exchanges the functions' values at the present state, as they were found there, and the count of switches without
  /// progress.
  void exchange_memory(Memory& memory);

 private:
  struct Sample {
    double fraction = 0.0;
    std::vector<double> values, shapes;
    std::vector<double> slopes;  // of the shapes, 1/s, or `unknown_slope`
  };
  enum class Root { None, AtStart, Inside, AtEnd };

  void count_functions();
  void resize();
  Outcome return_to(State* state);
  AccelerationOutput output_inside() { return {inside_.a.data(), nullptr, nullptr, &inside_.reactions}; }
  Outcome evaluate(const Kinematics& at, const Reactions& found, double* values);
  Outcome evaluate_inside(DenseOutput* dense, double fraction, double* values);
  Outcome add_sample(DenseOutput* dense, double fraction);
  std::size_t first_not_positive() const;
  bool may_dip(double h) const;
  double find_dip(double margin, double h) const;
  Outcome take_samples(DenseOutput* dense, int pieces, double h);
  void measure_scales();
  Outcome bracket(DenseOutput* dense, Root* root);
  bool is_at_zero(std::size_t k) const;
  bool falls_from_zero(std::span<const double> values) const;
  bool reaches_zero(double part);
  double least(std::span<const double> values) const;
  Outcome remake(Scheme& scheme, DenseOutput* dense, const State& from, State* to, StepResult* step);
  void choose_vanishing(std::span<const double> values);
  Outcome switch_own(State* to);

  IntegrationOptions options_;
  Mechanics& mechanics_;
  EventFunctions* const functions_;  // null if the equations never change
  std::size_t num_ = 0;              // number of functions of all processes
  struct {
    std::size_t first = 0, num = 0;
    std::vector<std::size_t> which;  // functions that vanish, numbered from `first`
  } own_;                            // functions of this process
  bool knows_start_ = false;
  Sample start_;                      // sample at the start of the step
  std::vector<double> slopes_;        // slopes of the shapes over the previous step
  std::vector<double> shapes_;        // shapes where the functions were evaluated last, …
  std::vector<double> shape_slopes_;  // … and their slopes
  std::vector<Sample> samples_;       // samples of this step, in order
  std::size_t num_samples_ = 0;
  std::vector<double> scales_;    // largest magnitude of each function over the samples
  std::vector<char> is_watched_;  // 0 for a function that has just left 0 upwards
  struct {
    double low = 0.0, high = 0.0;              // fractions between which the first root lies, …
    double least_low = 0.0, least_high = 0.0;  // … and the least values there, over their scales
  } bracket_;
  std::vector<double> values_;      // scratch
  std::vector<std::size_t> which_;  // functions that vanish
  struct {
    std::vector<double> x, v, a;
    Reactions reactions;
  } inside_;  // a state inside the step
  struct {
    std::size_t count = 0;
    double last_time = 0.0;  // s
    std::string last_change{};
    std::vector<ContactEvent> changes{};
  } switches_;
  struct {
    double begin = 0.0;  // s
    std::size_t num = 0;
  } without_progress_;  // the latest switches that brought the motion no further
};

}  // namespace tanor::detail
