#pragma once

/// \file
/// Second derivatives: a value with its gradient and its Hessian in N variables.
///
/// An energy written once over a scalar type yields its stiffness d2U/dr dr'. Slopes and curvatures of elementary
/// functions are those of the jet.

#include <array>
#include <cmath>
#include <compare>

#include <tanor/jet.hpp>

namespace tanor {

/// A value with gradient and Hessian in N variables. Comparisons look at the value alone.
template <int N>
struct Curved {
  static_assert(N >= 0);
  static constexpr std::size_t size = static_cast<std::size_t>(N);

  double v = 0.0;                               ///< value
  std::array<double, size> d{};                 ///< d[i] = partial derivative in variable i
  std::array<double, size*(size + 1) / 2> h{};  ///< second derivatives, row by row of the lower triangle

  constexpr Curved() = default;
  constexpr Curved(double constant) : v(constant) {}  // NOLINT(google-explicit-constructor): constants fit everywhere

  /// Returns the variable number i, 0 <= i < N.
  static constexpr Curved variable(double value, int i) {
    Curved a(value);
    a.d[static_cast<std::size_t>(i)] = 1.0;
    return a;
  }

  constexpr double value() const { return v; }
  /// Returns the second derivative in variables i and j.
  constexpr double second(std::size_t i, std::size_t j) const {
    return i < j ? h[j * (j + 1) / 2 + i] : h[i * (i + 1) / 2 + j];
  }
  constexpr bool is_constant() const {
    for (const double partial : d) {
      if (partial != 0.0) return false;
    }
    for (const double partial : h) {
      if (partial != 0.0) return false;
    }
    return true;
  }

  constexpr Curved& operator+=(const Curved& b) {
    v += b.v;
    for (std::size_t i = 0; i < d.size(); ++i) d[i] += b.d[i];
    for (std::size_t i = 0; i < h.size(); ++i) h[i] += b.h[i];
    return *this;
  }
  constexpr Curved& operator*=(double b) {
    v *= b;
    for (double& partial : d) partial *= b;
    for (double& partial : h) partial *= b;
    return *this;
  }
  constexpr Curved& operator-=(const Curved& b) { return *this += -b; }
  constexpr Curved& operator/=(double b) { return *this *= 1.0 / b; }
  constexpr Curved& operator*=(const Curved& b) { return *this = *this * b; }
  constexpr Curved& operator/=(const Curved& b) { return *this = *this / b; }

  friend constexpr Curved operator+(const Curved& a) { return a; }
  friend constexpr Curved operator-(Curved a) { return a *= -1.0; }
  friend constexpr Curved operator+(Curved a, const Curved& b) { return a += b; }
  friend constexpr Curved operator-(Curved a, const Curved& b) { return a -= b; }
  friend constexpr Curved operator*(Curved a, double b) { return a *= b; }
  friend constexpr Curved operator*(double a, Curved b) { return b *= a; }
  friend constexpr Curved operator/(Curved a, double b) { return a /= b; }
  friend constexpr Curved operator*(const Curved& a, const Curved& b) {
    // (a b)'' = a'' b + a' b' + b' a' + a b''
    Curved r(a.v * b.v);
    for (std::size_t i = 0, k = 0; i < size; ++i) {
      r.d[i] = a.d[i] * b.v + a.v * b.d[i];
      for (std::size_t j = 0; j <= i; ++j, ++k)
        r.h[k] = a.h[k] * b.v + a.d[i] * b.d[j] + b.d[i] * a.d[j] + a.v * b.h[k];
    }
    return r;
  }
  friend constexpr Curved operator/(const Curved& a, const Curved& b) {
    // r b = a
    Curved r(a.v / b.v);
    for (std::size_t i = 0; i < size; ++i) r.d[i] = (a.d[i] - r.v * b.d[i]) / b.v;
    for (std::size_t i = 0, k = 0; i < size; ++i) {
      for (std::size_t j = 0; j <= i; ++j, ++k)
        r.h[k] = (a.h[k] - r.d[i] * b.d[j] - b.d[i] * r.d[j] - r.v * b.h[k]) / b.v;
    }
    return r;
  }

  friend constexpr bool operator==(const Curved& a, const Curved& b) { return a.v == b.v; }
  friend constexpr std::partial_ordering operator<=>(const Curved& a, const Curved& b) { return a.v <=> b.v; }
};

namespace detail {

/// Returns f(a) from f of the jet a.v + e, where f'' = 2 c_2.
template <int N>
Curved<N> chain(const Jet<2>& f, const Curved<N>& a) {
  if (a.is_constant()) return f.c[0];
  Curved<N> r(f.c[0]);
  for (std::size_t i = 0, k = 0; i < r.size; ++i) {
    r.d[i] = f.c[1] * a.d[i];
    for (std::size_t j = 0; j <= i; ++j, ++k) r.h[k] = f.c[1] * a.h[k] + 2.0 * f.c[2] * a.d[i] * a.d[j];
  }
  return r;
}
template <int N>
Jet<2> jet_of(const Curved<N>& a) {
  return Jet<2>::variable(a.v);
}

}  // namespace detail

// clang-format off
template <int N> Curved<N> sqrt(const Curved<N>& a) { return detail::chain(sqrt(detail::jet_of(a)), a); }
template <int N> Curved<N> exp(const Curved<N>& a) { return detail::chain(exp(detail::jet_of(a)), a); }
template <int N> Curved<N> log(const Curved<N>& a) { return detail::chain(log(detail::jet_of(a)), a); }
template <int N> Curved<N> sin(const Curved<N>& a) { return detail::chain(sin(detail::jet_of(a)), a); }
template <int N> Curved<N> cos(const Curved<N>& a) { return detail::chain(cos(detail::jet_of(a)), a); }
template <int N> Curved<N> tan(const Curved<N>& a) { return detail::chain(tan(detail::jet_of(a)), a); }
template <int N> Curved<N> asin(const Curved<N>& a) { return detail::chain(asin(detail::jet_of(a)), a); }
template <int N> Curved<N> acos(const Curved<N>& a) { return detail::chain(acos(detail::jet_of(a)), a); }
template <int N> Curved<N> atan(const Curved<N>& a) { return detail::chain(atan(detail::jet_of(a)), a); }
template <int N> Curved<N> sinh(const Curved<N>& a) { return detail::chain(sinh(detail::jet_of(a)), a); }
template <int N> Curved<N> cosh(const Curved<N>& a) { return detail::chain(cosh(detail::jet_of(a)), a); }
template <int N> Curved<N> tanh(const Curved<N>& a) { return detail::chain(tanh(detail::jet_of(a)), a); }
template <int N> Curved<N> abs(const Curved<N>& a) { return a.v < 0.0 ? -a : a; }
template <int N> Curved<N> min(const Curved<N>& a, const Curved<N>& b) { return b.v < a.v ? b : a; }
template <int N> Curved<N> max(const Curved<N>& a, const Curved<N>& b) { return a.v < b.v ? b : a; }
// clang-format on

/// Returns the angle of (x, y) from the x axis, in [-pi, pi].
template <int N>
Curved<N> atan2(const Curved<N>& y, const Curved<N>& x) {
  // The quotient is that of the smaller over the larger number, so that it does not overflow; the rest is a constant.
  Curved<N> r = std::abs(y.v) <= std::abs(x.v) ? atan(y / x) : -atan(x / y);
  r.v = std::atan2(y.v, x.v);
  return r;
}

/// Returns a^p. Integer powers are multiplied out, so that the base may then be 0 or negative.
template <int N>
Curved<N> pow(const Curved<N>& a, double p) {
  if (detail::is_small_integer(p)) return detail::signed_integer_power(a, static_cast<int>(p));
  return detail::chain(pow(detail::jet_of(a), p), a);
}

/// Returns a^b, a > 0; a constant exponent is treated as above.
template <int N>
Curved<N> pow(const Curved<N>& a, const Curved<N>& b) {
  if (b.is_constant()) return pow(a, b.v);
  return exp(b * log(a));
}

}  // namespace tanor
