#pragma once

#include <cmath>
#include <cstddef>
#include <limits>

namespace tanor {

constexpr double eps = std::numeric_limits<double>::epsilon();

/// Returns number k of a fixed vector that looks random, so that no identity holds by accident and every run has the
/// same numbers. The numbers are sines at steps of the golden angle.
inline double irregular(std::size_t k) {
  return std::sin(1.0 + 2.399963 * static_cast<double>(k));
}

}  // namespace tanor
