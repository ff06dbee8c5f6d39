#pragma once

#include <algorithm>
#include <string>

#include "motion/rounding.hpp"
#include "motion/scheme.hpp"

namespace tanor::detail {

/// Detects, if `auto` chose an explicit method, that stability keeps steps far below what accuracy asks for. A step of
/// radau5, many times as long, then meets the tolerance from the present state. Such a step is tried, whatever makes
/// the system stiff, each time that four times as many steps were taken. If few steps are left, or were taken, the
/// trial is not worth its factors.
class StiffSteps {
 public:
  StiffSteps(const IntegrationOptions& options, Mechanics& mechanics, Method explicit_method);

  void note_step() { ++num_steps_; }
  /// Takes note of a step whose length tells nothing, so that no trial is due after it.
  void note_cut_step() { next_look_ = std::max(next_look_, num_steps_ + 1.0); }
  /// Returns true if a trial is due after a step of length h, with the time `left` to come.
  bool is_due(double h, double left) const;
  /// Tries an implicit step and returns true if implicit steps are to be taken from here on. Call this aside (see
  /// aside.hpp), with a copy of what is known of rounding.
  bool look(const State& from, double h, Rounding rounding);
  /// Returns true if implicit steps fall below the explicit ones, which are then taken for good. Call this with the
  /// next step.
  bool gives_up(double next_step);

  bool is_stiff() const { return is_stiff_; }
  /// Returns the length of the step that `look` found, s.
  double implicit_step() const { return factor * explicit_step_; }
  std::string explain() const;

  void exchange_memory(Memory& memory) {
    memory.exchange(may_look_, is_stiff_, num_steps_, next_look_, since_, explicit_step_);
  }

 private:
  static constexpr double factor = 20.0;  // so many explicit steps cost more than an implicit one

  IntegrationOptions options_;
  Mechanics& mechanics_;
  Method explicit_method_;
  bool may_look_, is_stiff_ = false;
  double num_steps_ = 0.0, next_look_ = 30.0;
  double since_ = 0.0, explicit_step_ = 0.0;  // s
  State to_;                                  // end of a trial
};

}  // namespace tanor::detail
