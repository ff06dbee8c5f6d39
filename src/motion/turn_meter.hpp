#pragma once

#include "base/parallel.hpp"
#include "motion/scheme.hpp"

namespace tanor {

/// Measures how far fixed steps turn a motion.
class TurnMeter {
 public:
  /// A fixed step was taken, and ended with these velocities.
  void note(const Parallel& parallel, const std::vector<double>& v);

  /// The largest number of v so far.
  double fastest() const { return fastest_; }
  /// How far the step turned the motion, rad, from what the trapezoidal rule misses in it; 0: it moved too little to
  /// tell. `knows_acceleration`: both states have theirs.
  double angle(const Parallel& parallel, const State& from, const State& to, bool knows_acceleration) const;

  void exchange_memory(Memory& memory) { memory.exchange(fastest_, before_); }

 private:
  double fastest_ = 0.0;  // of all numbers of v so far …
  double before_ = 0.0;   // … and without the last step
};

}  // namespace tanor
