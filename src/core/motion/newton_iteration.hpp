#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/memory.hpp"

namespace tanor::detail {

/// Decides from its increments whether a simplified Newton iteration inside a step goes on. Increments are measured
/// over the tolerance of the step (Hairer & Wanner II, IV.8). The iteration goes on until the sum of the increments to
/// come is a small part of the tolerance.
class NewtonIteration {
 public:
  enum class Verdict { GoOn, Converged, Stalls };

  explicit NewtonIteration(double rtol)
      : wanted_(std::min(0.03, std::sqrt(std::max(rtol, std::numeric_limits<double>::epsilon())))) {}

  /// Begins the iteration of a step. `same_matrix` tells that the matrix is that of the last step, whose rate then
  /// tells what to expect. `rounding` is that of the state, over the tolerance, which need not come from rtol.
  void begin(bool same_matrix, double rounding) {
    constexpr double most = 0.2;  // what the iteration leaves must not spoil the step
    target_ = std::clamp(10.0 * rounding, wanted_, most);
    if (!same_matrix) to_come_ = 1.0;
    count_ = 0;
    rate_ = 0.0;
  }

  Verdict check(double increment) {
    ++count_;
    if (!std::isfinite(increment)) return Verdict::Stalls;
    if (increment == 0.0) return Verdict::Converged;
    if (count_ == 1) {
      to_come_ = std::pow(std::max(to_come_, std::numeric_limits<double>::epsilon()), 0.8);
    } else {
      const double ratio = increment / last_;
      rate_ = count_ == 2 ? ratio : std::sqrt(ratio * last_ratio_);
      last_ratio_ = ratio;
      // Increments that are rounding do not shrink.
      if (rate_ >= 0.99) return increment <= rounding_part ? Verdict::Converged : Verdict::Stalls;
      to_come_ = rate_ / (1.0 - rate_);
      const double at_the_end = std::pow(rate_, most_iterations - count_) * to_come_ * increment;
      if (at_the_end > target_ && increment > rounding_part) return Verdict::Stalls;
    }
    last_ = increment;
    if (to_come_ * increment <= target_) return Verdict::Converged;
    return count_ == most_iterations ? Verdict::Stalls : Verdict::GoOn;
  }

  /// Returns true if the increments shrank, though too slowly.
  bool shrinks() const { return count_ > 1 && rate_ < 0.9; }
  /// Returns the factor by which each iteration of the last step shortened the increment; 0 if one iteration was
  /// enough.
  double rate() const { return rate_; }

  void exchange_memory(Memory& memory) { memory.exchange(to_come_, rate_, last_, last_ratio_, count_); }

 private:
  static constexpr int most_iterations = 12;
  static constexpr double rounding_part = 0.1;  // part of the tolerance

  double wanted_, target_ = 0.0;
  double to_come_ = 1.0;  // sum of the increments to come, over the last one
  double rate_ = 0.0, last_ = 0.0, last_ratio_ = 0.0;
  int count_ = 0;
};

}  // namespace tanor::detail
