#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace tanor::detail {

/// The length of a step that nothing limits, s. It is finite, so that snapshots hold it.
inline constexpr double any_length = std::numeric_limits<double>::max();

/// A step for which a power series is wanted, and the errors atol + rtol |.| that positions and velocities may have in
/// it.
struct SeriesDemand {
  double h = any_length;          ///< length, s; all terms are wanted if it is any_length
  double atol = 0.0, rtol = 0.0;  ///< see Mechanics::error_ratios
};

/// Returns the logarithm of the longest step h, s, for which the terms of order k stay within the allowed errors, where
/// the largest |r_k| of positions and of velocities over these are given. The terms are |r_k| h^k of positions and
/// k |r_k| h^(k-1) of velocities.
inline double log_of_longest_step(int k, double position_ratio, double velocity_ratio) {
  return std::min(-std::log(position_ratio) / k, -std::log(k * velocity_ratio) / (k - 1));
}

}  // namespace tanor::detail
