#pragma once

#include "base/parallel.hpp"
#include "motion/scheme.hpp"

namespace tanor {

/// Measures how far fixed steps turn a motion.
class TurnMeter {
 public:
  /// The largest numbers of a step: of x and v at its end, and of what the trapezoidal rule misses in it.
  struct Step {
    double place = 0.0, speed = 0.0, missed = 0.0;
  };

  /// A fixed step was taken.
  void note(Mechanics& mechanics, const State& from, const State& to);

  /// The largest number of v so far.
  double fastest() const { return fastest_; }
  /// How far the step that was noted last turned the motion, rad, from what the trapezoidal rule misses in it; 0: it
  /// moved too little to tell. `knows_acceleration`: both states have theirs.
  double angle(Mechanics& mechanics, const State& from, const State& to, bool knows_acceleration) const;

  void exchange_memory(Memory& memory) { memory.exchange(fastest_, before_); }

 private:
  Step step_;             // the last one
  double fastest_ = 0.0;  // of all numbers of v so far …
  double before_ = 0.0;   // … and without the last step
};

}  // namespace tanor
