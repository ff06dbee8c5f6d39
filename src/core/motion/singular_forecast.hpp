#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/memory.hpp"
#include "motion/singular_thresholds.hpp"

namespace tanor::detail {

/// Foresees from the previous steps when the motion meets a configuration where K loses rank. The smallest singular
/// value of K goes through 0 there linearly, and the reciprocal condition of S is its square.
class SingularForecast {
 public:
  /// Takes note of a step that ended at t on the constraints. S has this reciprocal condition there, and `regular` far
  /// from singular configurations.
  void add(double t, double reciprocal_condition, double regular) {
    const double size = std::sqrt(std::max(0.0, reciprocal_condition));
    const bool falls = t > time_ && size < size_ && reciprocal_condition < singular::near * regular;
    zero_ = falls ? t + (t - time_) * size / (size_ - size) : never;
    time_ = t;
    size_ = size;
  }
  void forget() { *this = {}; }

  /// Returns true if stages of the step from t to t + h, or its end, come so near that K is unreliable.
  bool disturbs(double t, double h) const {
    return zero_ >= t - singular::margin * h && zero_ <= t + (1.0 + singular::margin) * h;
  }
  bool lies_near(double t, double h) const { return std::abs(t - zero_) < singular::margin * h; }
  /// Returns the foreseen time, s; infinite if none is foreseen.
  double time() const { return zero_; }
  bool lies_ahead_of(double t) const { return zero_ > t && std::isfinite(zero_); }
  /// Returns the reciprocal condition of S at the end of the last step.
  double reciprocal_condition() const { return size_ * size_; }

  void exchange_memory(Memory& memory) { memory.exchange(time_, size_, zero_); }

 private:
  static constexpr double never = std::numeric_limits<double>::infinity();
  double time_ = never, size_ = 0.0;  // end of the last step
  double zero_ = never;
};

}  // namespace tanor::detail
