#pragma once

/// \file
/// Forward derivatives: a value with its partial derivatives in N variables.
///
/// A function written once over a scalar type yields its gradient: K from xi(r, t), A from r(q, t). Forward has the
/// functions of Jet, with the same conventions. Where a function has no derivative, the partials are infinite or NaN
/// and the value stays right. A variable that does not take part has the partial 0, whatever the slope of the function
/// is.

#include <array>
#include <cmath>
#include <compare>

#include <tanor/jet.hpp>

namespace tanor {

/// A value with N partial derivatives. Comparisons look at the value alone.
template <int N>
struct Forward {
  static_assert(N >= 0);

  double v = 0.0;             ///< value
  std::array<double, N> d{};  ///< d[i] = partial derivative in variable i

  constexpr Forward() = default;
  constexpr Forward(double constant) : v(constant) {}  // NOLINT(google-explicit-constructor): constants fit everywhere

  /// Returns the variable number i, 0 <= i < N.
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

template <int N>
inline constexpr bool has_derivatives<Forward<N>> = true;

namespace detail {

/// Returns slope * partial. A variable that does not take part gives 0 also if the slope is infinite or undefined.
inline double chain(double slope, double partial) {
  return partial == 0.0 ? 0.0 : slope * partial;
}

/// Returns f(a) from the given value and slope f'(a).
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

/// The first function returns the value of a as a jet along itself; the second returns f(a) from f of that jet.
template <int N>
Jet<1> jet_of(const Forward<N>& a) {
  return Jet<1>::variable(a.v);
}
template <int N>
Forward<N> chain(const Jet<1>& f, const Forward<N>& a) {
  return chain(f.c[0], f.c[1], a);
}

/// Returns f(a, b) from the given value and slopes.
template <int N>
Forward<N> chain(double value, double slope_a, const Forward<N>& a, double slope_b, const Forward<N>& b) {
  Forward<N> r(value);
  for (std::size_t i = 0; i < N; ++i) r.d[i] = chain(slope_a, a.d[i]) + chain(slope_b, b.d[i]);
  return r;
}

}  // namespace detail

// The slopes of these functions are those of the jet.
// clang-format off
template <int N> Forward<N> sqrt(const Forward<N>& a) { return detail::chain(sqrt(detail::jet_of(a)), a); }
template <int N> Forward<N> exp(const Forward<N>& a) { return detail::chain(exp(detail::jet_of(a)), a); }
template <int N> Forward<N> log(const Forward<N>& a) { return detail::chain(log(detail::jet_of(a)), a); }
template <int N> Forward<N> sin(const Forward<N>& a) { return detail::chain(sin(detail::jet_of(a)), a); }
template <int N> Forward<N> cos(const Forward<N>& a) { return detail::chain(cos(detail::jet_of(a)), a); }
template <int N> Forward<N> tan(const Forward<N>& a) { return detail::chain(tan(detail::jet_of(a)), a); }
template <int N> Forward<N> asin(const Forward<N>& a) { return detail::chain(asin(detail::jet_of(a)), a); }
template <int N> Forward<N> acos(const Forward<N>& a) { return detail::chain(acos(detail::jet_of(a)), a); }
template <int N> Forward<N> atan(const Forward<N>& a) { return detail::chain(atan(detail::jet_of(a)), a); }
template <int N> Forward<N> sinh(const Forward<N>& a) { return detail::chain(sinh(detail::jet_of(a)), a); }
template <int N> Forward<N> cosh(const Forward<N>& a) { return detail::chain(cosh(detail::jet_of(a)), a); }
template <int N> Forward<N> tanh(const Forward<N>& a) { return detail::chain(tanh(detail::jet_of(a)), a); }
// clang-format on

/// Returns the angle of (x, y) from the x axis, in [-pi, pi].
template <int N>
Forward<N> atan2(const Forward<N>& y, const Forward<N>& x) {
  // (x y' - y x')/(x^2 + y^2); hypot does not overflow where the squares do.
  const double length = std::hypot(x.v, y.v);
  return detail::chain(std::atan2(y.v, x.v), x.v / length / length, y, -y.v / length / length, x);
}

/// Returns a^p. Integer powers are multiplied out, so that the base may then be 0 or negative.
template <int N>
Forward<N> pow(const Forward<N>& a, double p) {
  if (detail::is_small_integer(p)) return detail::signed_integer_power(a, static_cast<int>(p));
  return detail::chain(std::pow(a.v, p), p * std::pow(a.v, p - 1.0), a);
}

/// Returns a^b, a > 0; a constant exponent is treated as above.
template <int N>
Forward<N> pow(const Forward<N>& a, const Forward<N>& b) {
  if (b.is_constant()) return pow(a, b.v);
  const double value = std::pow(a.v, b.v);
  return detail::chain(value, b.v * std::pow(a.v, b.v - 1.0), a, value * std::log(a.v), b);
}

}  // namespace tanor
