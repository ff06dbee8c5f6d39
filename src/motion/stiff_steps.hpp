#pragma once

#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "motion/rounding.hpp"
#include "motion/scheme.hpp"

namespace tanor {

/// Looks, where `auto` chose an explicit method, for steps that stability holds far below what accuracy asks: then one
/// of radau5, many times as long, meets the tolerance from where the motion is. That is asked for itself, whatever
/// makes the system stiff, each time four times as many steps were taken; while few are left to come, or were taken, it
/// is not worth its factors.
class StiffSteps {
 public:
  StiffSteps(const IntegrationOptions& options, Mechanics& mechanics, Method explicit_method);

  void note_step() { ++num_steps_; }
  /// After a step of length h, with the time `left` to come.
  bool is_due(double h, double left) const;
  /// Implicit steps are to be taken from here on. The mechanics is then linearised elsewhere.
  bool look(const State& from, double h, Rounding* rounding);
  /// Implicit steps fall below those that were given up: back to them, for good. To be asked with the next one.
  bool gives_up(double next_step);

  bool is_stiff() const { return is_stiff_; }
  /// Of a step that `look` found.
  double implicit_step() const { return factor * explicit_step_; }
  std::string explain() const;

  /// Plain numbers for a snapshot, and back. Throws InputError where they do not fit.
  std::vector<double> memory() const;
  void restore(std::span<const double> memory);

 private:
  static constexpr double factor = 20.0;  // so many explicit steps cost more than an implicit one

  IntegrationOptions options_;
  Mechanics& mechanics_;
  Method explicit_method_;
  bool may_look_, is_stiff_ = false;
  double num_steps_ = 0.0, next_look_ = 30.0;
  double since_ = 0.0, explicit_step_ = 0.0;  // s
  State to_;                                  // of a trial
};

}  // namespace tanor
