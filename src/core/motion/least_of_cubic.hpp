#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

namespace tanor::detail {

/// The least value of a cubic inside an interval of length 1, and its place.
struct LeastOfCubic {
  double at, value;
};
/// Returns that of the cubic with values f and slopes m at both ends, if it falls at first and rises at last.
inline std::optional<LeastOfCubic> least_of_cubic(double f0, double m0, double f1, double m1) {
  if (!(m0 < 0.0 && m1 > 0.0)) return std::nullopt;
  // f = f0 + m0 s + a s^2 + b s^3, with the root of f' = m0 + 2 a s + 3 b s^2 that has f'' > 0
  const double a = 3.0 * (f1 - f0) - 2.0 * m0 - m1, b = m0 + m1 - 2.0 * (f1 - f0);
  const double root = std::sqrt(std::max(0.0, a * a - 3.0 * b * m0));
  const double s = -m0 / (a + root);
  if (!(s > 0.0 && s < 1.0)) return std::nullopt;
  return LeastOfCubic{s, f0 + s * (m0 + s * (a + s * b))};
}

}  // namespace tanor::detail
