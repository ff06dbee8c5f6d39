#pragma once

#include <limits>
#include <string>

#include "motion/scheme.hpp"

namespace tanor {

/// Keeps steps from passing over what functions of time do inside them, and tells what fixed steps passed over.
///
/// Functions are looked at with a spacing of 1/4096 of the advance, or of the time since the motion began where that is
/// longer: many short advances cost little more than a long one.
class DriveControl {
 public:
  DriveControl(const MotionOptions& options, const Scheme& scheme, Mechanics& mechanics);

  /// A motion begins at t; or one goes on that began there.
  void begin(double t) { begin_ = t; }
  double begin_time() const { return begin_; }
  /// An advance begins at t.
  void advance(double t, double t_end);

  /// The longest step from this state, at most h, whose scheme sees all that functions of time do, within its
  /// tolerance. One that is shorter than `shortest` is not asked for.
  double shorten(const State& from, double h, double shortest);
  /// A fixed step is as long as it was told to be.
  void look(const State& from, double h);
  /// Of the step that was looked at last: pieces in each of which forces go nearly straight.
  int pieces() const { return report_.pieces; }

  /// A fixed step of length h that was looked at was accepted.
  void note(const State& from, double h);
  /// What fixed steps passed over so far, m/s, and where most of it was; empty: nothing to speak of.
  double missed() const { return missed_; }
  std::string describe() const;

 private:
  MotionOptions options_;
  Mechanics& mechanics_;
  int degree_;
  double begin_ = 0.0, spacing_ = std::numeric_limits<double>::infinity();
  DriveReport report_;  // of the last look
  double missed_ = 0.0, most_ = 0.0, worst_begin_ = 0.0, worst_length_ = 0.0;
  std::size_t worst_drive_ = 0;
};

}  // namespace tanor
