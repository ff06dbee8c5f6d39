#pragma once

/// \file Sizes and differences of arrays. A NaN is never small, for it counts as infinite.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

namespace tanor {

inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();

inline double size_of(double x) {
  return std::isnan(x) ? INFINITY : std::abs(x);
}

inline double largest(std::span<const double> array) {
  double result = 0.0;
  for (const double x : array) result = std::max(result, size_of(x));
  return result;
}

inline double largest_difference(std::span<const double> a, std::span<const double> b) {
  double result = a.size() == b.size() ? 0.0 : INFINITY;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) result = std::max(result, size_of(a[i] - b[i]));
  return result;
}

/// Returns the largest difference over the largest number of `b`.
inline double relative_difference(std::span<const double> a, std::span<const double> b) {
  return largest_difference(a, b) / std::max(largest(b), 1e-300);
}

inline bool all_finite(std::span<const double> array) {
  return std::all_of(array.begin(), array.end(), [](double x) { return std::isfinite(x); });
}

}  // namespace tanor
