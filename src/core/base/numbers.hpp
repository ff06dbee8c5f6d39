#pragma once

#include <cmath>
#include <cstddef>
#include <limits>

namespace tanor::detail {

constexpr double eps = std::numeric_limits<double>::epsilon();

/// Returns number k of a fixed vector that looks random, so that no identity holds by accident and every run has the
/// same numbers. The numbers are sines at equal steps, by default at steps of the golden angle; another step gives
/// another vector.
inline double irregular(std::size_t k, double step = 2.399963) {
  return std::sin(1.0 + step * static_cast<double>(k));
}

}  // namespace tanor::detail
