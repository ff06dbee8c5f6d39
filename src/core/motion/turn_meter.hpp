#pragma once

#include "base/parallel.hpp"
#include "motion/scheme.hpp"

namespace tanor::detail {

/// Measures how far fixed steps turn a motion.
class TurnMeter {
 public:
  /// Takes note of the state where a fixed step ends.
  void note(Mechanics& mechanics, const State& to);

  /// Returns the largest number of v so far.
  double fastest() const { return fastest_; }
  /// Returns how far the step noted last, between these states, turned the motion, rad, from the error of the
  /// trapezoidal rule in it; 0 if the motion gains speed or the step moved too little. `knows_acceleration` is true if
  /// both states have their acceleration.
  double angle(Mechanics& mechanics, const State& from, const State& to, bool knows_acceleration) const;

  void exchange_memory(Memory& memory) { memory.exchange(fastest_, before_); }

 private:
  double fastest_ = 0.0;  // largest number of v so far …
  double before_ = 0.0;   // … and without the last step
};

}  // namespace tanor::detail
