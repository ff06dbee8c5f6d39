#pragma once

/// \file
/// Forward derivatives: a value with its partial derivatives in N variables.
///
/// A function written once over a scalar type yields its gradient: K from xi(r, t), A from r(q, t). It knows the same
/// functions as the jet, with the same choices: where a function has no derivative the partials are infinite or NaN,
/// the value stays right; a variable that does not take part has the partial 0, whatever the slope of the function is.

#include <array>
#include <cmath>
#include <compare>
#include <limits>

#include <tanor/jet.hpp>

namespace tanor {

/// Comparisons look at the value alone.
template <int N>
struct Forward {
  static_assert(N >= 0);

  double v = 0.0;             ///< value
  std::array<double, N> d{};  ///< d[i] = partial derivative in variable i

  constexpr Forward() = default;
  constexpr Forward(double constant) : v(constant) {}  // NOLINT(google-explicit-constructor): constants fit everywhere

  /// Variable number i, 0 <= i < N.
  static constexpr Forward variable(double value, int i) {
    Forward a(value);
    a.d[static_cast<std::size_t>(i)] = 1.0;
    return a;
  }

  constexpr double value() const { return v; }

  constexpr bool is_constant() const {
    for (const double partial : d) {
      if (partial != 0.0) return false;
    }
    return true;
  }

  constexpr Forward& operator+=(const Forward& b) {
    v += b.v;
    for (std::size_t i = 0; i < N; ++i) d[i] += b.d[i];
    return *this;
  }
  constexpr Forward& operator-=(const Forward& b) {
    v -= b.v;
    for (std::size_t i = 0; i < N; ++i) d[i] -= b.d[i];
    return *this;
  }
  constexpr Forward& operator*=(double b) {
    v *= b;
    for (double& partial : d) partial *= b;
    return *this;
  }
  constexpr Forward& operator/=(double b) {
    v /= b;
    for (double& partial : d) partial /= b;
    return *this;
  }
  constexpr Forward& operator*=(const Forward& b) {
    // (a b)' = a' b + a b'
    for (std::size_t i = 0; i < N; ++i) d[i] = d[i] * b.v + v * b.d[i];
    v *= b.v;
    return *this;
  }
  constexpr Forward& operator/=(const Forward& b) {
    // r b = a:  r' = (a' - r b')/b
    v /= b.v;
    for (std::size_t i = 0; i < N; ++i) d[i] = (d[i] - v * b.d[i]) / b.v;
    return *this;
  }

  friend constexpr Forward operator+(const Forward& a) { return a; }
  friend constexpr Forward operator-(Forward a) {
    a.v = -a.v;
    for (double& partial : a.d) partial = -partial;
    return a;
  }
  friend constexpr Forward operator+(Forward a, const Forward& b) { return a += b; }
  friend constexpr Forward operator-(Forward a, const Forward& b) { return a -= b; }
  friend constexpr Forward operator*(Forward a, double b) { return a *= b; }
  friend constexpr Forward operator*(double a, Forward b) { return b *= a; }
  friend constexpr Forward operator*(Forward a, const Forward& b) { return a *= b; }
  friend constexpr Forward operator/(Forward a, double b) { return a /= b; }
  friend constexpr Forward operator/(Forward a, const Forward& b) { return a /= b; }

  friend constexpr bool operator==(const Forward& a, const Forward& b) { return a.v == b.v; }
  friend constexpr std::partial_ordering operator<=>(const Forward& a, const Forward& b) { return a.v <=> b.v; }
};

namespace detail {

/// slope * partial; a variable that does not take part stays out also where the slope is infinite or undefined.
inline double chain(double slope, double partial) {
  return partial == 0.0 ? 0.0 : slope * partial;
}

/// f(a) with the given value and slope f'(a).
template <int N>
Forward<N> chain(double value, double slope, const Forward<N>& a) {
  Forward<N> r(value);
  if (std::isfinite(slope)) {
    for (std::size_t i = 0; i < N; ++i) r.d[i] = slope * a.d[i];
  } else {
    for (std::size_t i = 0; i < N; ++i) r.d[i] = chain(slope, a.d[i]);
  }
  return r;
}

/// f(a, b) with the given value and slopes.
template <int N>
Forward<N> chain(double value, double slope_a, const Forward<N>& a, double slope_b, const Forward<N>& b) {
  Forward<N> r(value);
  for (std::size_t i = 0; i < N; ++i) r.d[i] = chain(slope_a, a.d[i]) + chain(slope_b, b.d[i]);
  return r;
}

}  // namespace detail

template <int N>
Forward<N> sqrt(const Forward<N>& a) {
  const double root = std::sqrt(a.v);
  return detail::chain(root, 0.5 / root, a);
}

template <int N>
Forward<N> exp(const Forward<N>& a) {
  const double value = std::exp(a.v);
  return detail::chain(value, value, a);
}

template <int N>
Forward<N> log(const Forward<N>& a) {
  return detail::chain(std::log(a.v), 1.0 / a.v, a);
}

template <int N>
Forward<N> sin(const Forward<N>& a) {
  return detail::chain(std::sin(a.v), std::cos(a.v), a);
}

template <int N>
Forward<N> cos(const Forward<N>& a) {
  return detail::chain(std::cos(a.v), -std::sin(a.v), a);
}

template <int N>
Forward<N> tan(const Forward<N>& a) {
  const double value = std::tan(a.v);
  return detail::chain(value, 1.0 + value * value, a);
}

template <int N>
Forward<N> asin(const Forward<N>& a) {
  return detail::chain(std::asin(a.v), 1.0 / std::sqrt((1.0 - a.v) * (1.0 + a.v)), a);
}

template <int N>
Forward<N> acos(const Forward<N>& a) {
  return detail::chain(std::acos(a.v), -1.0 / std::sqrt((1.0 - a.v) * (1.0 + a.v)), a);
}

template <int N>
Forward<N> atan(const Forward<N>& a) {
  return detail::chain(std::atan(a.v), 1.0 / (1.0 + a.v * a.v), a);
}

/// Angle of (x, y) against the x axis, in [-pi, pi].
template <int N>
Forward<N> atan2(const Forward<N>& y, const Forward<N>& x) {
  // (x y' - y x')/(x^2 + y^2); hypot does not overflow where the squares do.
  const double length = std::hypot(x.v, y.v);
  return detail::chain(std::atan2(y.v, x.v), x.v / length / length, y, -y.v / length / length, x);
}

template <int N>
Forward<N> sinh(const Forward<N>& a) {
  return detail::chain(std::sinh(a.v), std::cosh(a.v), a);
}

template <int N>
Forward<N> cosh(const Forward<N>& a) {
  return detail::chain(std::cosh(a.v), std::sinh(a.v), a);
}

template <int N>
Forward<N> tanh(const Forward<N>& a) {
  // 1/cosh^2 instead of 1 - tanh^2: no cancellation for large arguments.
  const double secant = 1.0 / std::cosh(a.v);
  return detail::chain(std::tanh(a.v), secant * secant, a);
}

/// At 0 the branch of positive numbers.
template <int N>
constexpr Forward<N> abs(const Forward<N>& a) {
  return a.v < 0.0 ? -a : a;
}

/// The first one where both are equal.
template <int N>
constexpr Forward<N> min(const Forward<N>& a, const Forward<N>& b) {
  return b < a ? b : a;
}

/// The first one where both are equal.
template <int N>
constexpr Forward<N> max(const Forward<N>& a, const Forward<N>& b) {
  return a < b ? b : a;
}

/// a^p; integers are multiplied out, so the base may be 0 or negative there.
template <int N>
Forward<N> pow(const Forward<N>& a, double p) {
  if (detail::is_small_integer(p)) return detail::signed_integer_power(a, static_cast<int>(p));
  return detail::chain(std::pow(a.v, p), p * std::pow(a.v, p - 1.0), a);
}

/// a^b, a > 0; a constant exponent as above.
template <int N>
Forward<N> pow(const Forward<N>& a, const Forward<N>& b) {
  if (b.is_constant()) return pow(a, b.v);
  const double value = std::pow(a.v, b.v);
  return detail::chain(value, b.v * std::pow(a.v, b.v - 1.0), a, value * std::log(a.v), b);
}

// The same with a number on one side.
// clang-format off
template <int N> Forward<N> pow(double a, const Forward<N>& b) { return pow(Forward<N>(a), b); }
template <int N> Forward<N> atan2(const Forward<N>& y, double x) { return atan2(y, Forward<N>(x)); }
template <int N> Forward<N> atan2(double y, const Forward<N>& x) { return atan2(Forward<N>(y), x); }
template <int N> constexpr Forward<N> min(const Forward<N>& a, double b) { return min(a, Forward<N>(b)); }
template <int N> constexpr Forward<N> min(double a, const Forward<N>& b) { return min(Forward<N>(a), b); }
template <int N> constexpr Forward<N> max(const Forward<N>& a, double b) { return max(a, Forward<N>(b)); }
template <int N> constexpr Forward<N> max(double a, const Forward<N>& b) { return max(Forward<N>(a), b); }
// clang-format on

}  // namespace tanor
