#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace tanor {

/// All numbers from `low` to `high`. An operation yields an interval that holds its value for every choice of numbers
/// from its operands, up to rounding, which is not directed: intervals decide where to look closer and prove nothing
/// near a rounding.
struct Interval {
  double low = 0.0, high = 0.0;

  Interval() = default;
  Interval(double number) : low(number), high(number) {}  // NOLINT(google-explicit-constructor): numbers are intervals
  Interval(double a, double b) : low(a), high(b) {}

  static Interval everything() {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    return {-infinity, infinity};
  }

  double width() const { return high - low; }
  double magnitude() const { return std::max(std::abs(low), std::abs(high)); }
  bool contains(double x) const { return low <= x && x <= high; }
  /// A bound that is no number says nothing.
  bool is_known() const { return low <= high; }

  friend Interval operator+(Interval a, Interval b) { return {a.low + b.low, a.high + b.high}; }
  friend Interval operator-(Interval a, Interval b) { return {a.low - b.high, a.high - b.low}; }
  friend Interval operator-(Interval a) { return {-a.high, -a.low}; }
  friend Interval operator*(double s, Interval a) {
    return s >= 0.0 ? Interval(s * a.low, s * a.high) : Interval(s * a.high, s * a.low);
  }
  friend Interval operator*(Interval a, Interval b) {
    const double p = a.low * b.low, q = a.low * b.high, r = a.high * b.low, s = a.high * b.high;
    return {std::min(std::min(p, q), std::min(r, s)), std::max(std::max(p, q), std::max(r, s))};
  }
  friend Interval operator/(Interval a, Interval b) {
    if (b.contains(0.0)) return everything();
    return a * Interval(1.0 / b.high, 1.0 / b.low);
  }
};

inline Interval square(Interval a) {
  const double p = a.low * a.low, q = a.high * a.high;
  return {a.contains(0.0) ? 0.0 : std::min(p, q), std::max(p, q)};
}
inline Interval abs(Interval a) {
  const double p = std::abs(a.low), q = std::abs(a.high);
  return {a.contains(0.0) ? 0.0 : std::min(p, q), std::max(p, q)};
}
inline Interval min(Interval a, Interval b) {
  return {std::min(a.low, b.low), std::min(a.high, b.high)};
}
inline Interval max(Interval a, Interval b) {
  return {std::max(a.low, b.low), std::max(a.high, b.high)};
}
/// Of numbers below 0: 0.
inline Interval sqrt(Interval a) {
  return {std::sqrt(std::max(a.low, 0.0)), std::sqrt(std::max(a.high, 0.0))};
}
inline Interval exp(Interval a) {
  return {std::exp(a.low), std::exp(a.high)};
}
/// Of numbers below 0: minus infinity.
inline Interval log(Interval a) {
  return {std::log(std::max(a.low, 0.0)), std::log(std::max(a.high, 0.0))};
}
inline Interval sinh(Interval a) {
  return {std::sinh(a.low), std::sinh(a.high)};
}
inline Interval cosh(Interval a) {
  const double p = std::cosh(a.low), q = std::cosh(a.high);
  return {a.contains(0.0) ? 1.0 : std::min(p, q), std::max(p, q)};
}
inline Interval tanh(Interval a) {
  return {std::tanh(a.low), std::tanh(a.high)};
}
inline Interval asin(Interval a) {
  return {std::asin(std::clamp(a.low, -1.0, 1.0)), std::asin(std::clamp(a.high, -1.0, 1.0))};
}
inline Interval atan(Interval a) {
  return {std::atan(a.low), std::atan(a.high)};
}
inline Interval cos(Interval a) {
  constexpr double pi = 3.14159265358979323846;
  if (!(a.width() < 2.0 * pi)) return {-1.0, 1.0};
  const double p = std::cos(a.low), q = std::cos(a.high);
  // Whole turns, where cos is 1, and half ones, where it is -1.
  const bool has_top = std::floor(a.high / (2.0 * pi)) >= std::ceil(a.low / (2.0 * pi));
  const bool has_bottom = std::floor(a.high / (2.0 * pi) - 0.5) >= std::ceil(a.low / (2.0 * pi) - 0.5);
  return {has_bottom ? -1.0 : std::min(p, q), has_top ? 1.0 : std::max(p, q)};
}
inline Interval sin(Interval a) {
  return cos(a - Interval(1.57079632679489661923));
}

}  // namespace tanor
