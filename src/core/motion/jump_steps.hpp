#pragma once

#include <limits>

#include "base/point_path.hpp"
#include "motion/scheme.hpp"

namespace tanor::detail {

/// Chooses steps up to jumps of forces and over them.
class JumpSteps {
 public:
  /// A shorter step to try next from the present state, which leads up to a jump of a force or over it.
  struct Cut {
    double length = std::numeric_limits<double>::infinity();  // s
    bool is_over = false;
    int tries = 0;  // how many before it have failed

    bool exists() const { return length < std::numeric_limits<double>::infinity(); }
  };

  /// Returns the step to make instead of one of length h in which a force jumps: up to the jump, or, from there, over
  /// it. Stages inside a step may lie beyond its end by a part of it that falls with its length, so that schemes with
  /// stages come nearer in a few steps, each of which leaves the square of the part that the last one left.
  Cut cut_at(const PointPath::Jump& jump, bool has_stages, double h, double resolution) const;
  /// Returns a step to try after one of the above has failed: stages beyond its end, or at the jump itself, where the
  /// force does not exist, are avoided by another length. There is none if that does not help any more, since the plan
  /// itself was too long.
  Cut cut_again(const Cut& cut, double resolution) const;
  /// Takes note that the next step, from t, leads over a jump. Forces that drive points back to it from both sides end
  /// the motion.
  Outcome note_jump(const PointPath::Jump& jump, double t, double resolution);

  /// True if fixed steps end at jumps no more, since those came one upon the other.
  bool are_passed = false;

  /// Says that no motion goes on from a jump at t; ok if there is none.
  static Outcome explain(const PointPath::Jump& jump, double t);

 private:
  int count_ = 0;           // of jumps that were passed one soon after the other, …
  double last_time_ = 0.0;  // … when the last one was, s, …
  double longest_ = 0.0;    // … and the longest time between two of them, s
};

}  // namespace tanor::detail
