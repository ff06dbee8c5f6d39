#pragma once

/// \file
/// Forward derivatives: a value with its partial derivatives in N variables.
///
/// A function written once over a scalar type yields its gradient: K from xi(r, t), A from r(q, t), and on Curved its
/// second derivatives: d2U/dr dr' from U(r). Forward has the functions of Jet, with the same conventions. Where a
/// function has no derivative, the partials are infinite or NaN and the value stays right. A variable that does not
/// take part has the partial 0, whatever the slope of the function is.

#include <array>
#include <cmath>
#include <compare>

#include <tanor/jet.hpp>

namespace tanor {

template <int N, class S = double>
struct Forward;

namespace detail {

/// The order of the derivatives that a number has.
template <class S>
inline constexpr int order_of = 0;
template <int N, class S>
inline constexpr int order_of<Forward<N, S>> = 1 + order_of<S>;

constexpr bool is_zero(double x) {
  return x == 0.0;
}
template <class T>
constexpr bool is_zero(const T& x) {
  return x.value() == 0.0 && x.is_constant();
}

}  // namespace detail

/// A value with N partial derivatives. Comparisons look at the value alone. If S is a Forward, value and partials have
/// derivatives themselves.
template <int N, class S>
struct Forward {
  static_assert(N >= 0);

  S v = 0.0;             ///< value
  std::array<S, N> d{};  ///< d[i] = partial derivative in variable i

  constexpr Forward() = default;
  constexpr Forward(double constant) : v(constant) {}  // NOLINT(google-explicit-constructor): constants fit everywhere

  /// Returns the variable number i, 0 <= i < N.
  static constexpr Forward variable(double value, int i) {
    Forward a(value);
    if constexpr (detail::order_of < S >> 0) a.v = S::variable(value, i);
    a.d[static_cast<std::size_t>(i)] = 1.0;
    return a;
  }

  constexpr double value() const {
    if constexpr (detail::order_of < S >> 0)
      return v.value();
    else
      return v;
  }
  /// Returns the second derivative in variables i and j.
  constexpr auto second(std::size_t i, std::size_t j) const requires(detail::order_of < S >> 0) {
    return i < j ? d[j].d[i] : d[i].d[j];
  }

  constexpr bool is_constant() const {
    for (const S& partial : d) {
      if (!detail::is_zero(partial)) return false;
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
    for (S& partial : d) partial *= b;
    return *this;
  }
  constexpr Forward& operator/=(double b) {
    v /= b;
    for (S& partial : d) partial /= b;
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
    for (S& partial : a.d) partial = -partial;
    return a;
  }
  friend constexpr Forward operator+(Forward a, const Forward& b) { return a += b; }
  friend constexpr Forward operator-(Forward a, const Forward& b) { return a -= b; }
  friend constexpr Forward operator*(Forward a, double b) { return a *= b; }
  friend constexpr Forward operator*(double a, Forward b) { return b *= a; }
  friend constexpr Forward operator*(Forward a, const Forward& b) { return a *= b; }
  friend constexpr Forward operator/(Forward a, double b) { return a /= b; }
  friend constexpr Forward operator/(Forward a, const Forward& b) { return a /= b; }

  friend constexpr bool operator==(const Forward& a, const Forward& b) { return a.value() == b.value(); }
  friend constexpr std::partial_ordering operator<=>(const Forward& a, const Forward& b) {
    return a.value() <=> b.value();
  }
};

/// A value with its gradient and its Hessian in N variables, for the stiffness of an energy.
template <int N>
using Curved = Forward<N, Forward<N>>;

template <int N, class S>
inline constexpr bool has_derivatives<Forward<N, S>> = true;
template <int N, class S>
inline constexpr bool is_composed<Forward<N, S>> = true;

namespace detail {

/// Returns slope * partial. A variable that does not take part gives 0 also if the slope is infinite or undefined.
template <class S>
S chain(const S& slope, const S& partial) {
  return is_zero(partial) ? S(0.0) : slope * partial;
}

/// Returns f(a) from the given value and slope f'(a).
template <int N, class S>
Forward<N, S> chain(const S& value, const S& slope, const Forward<N, S>& a) {
  Forward<N, S> r;
  r.v = value;
  if constexpr (order_of<S> == 0) {
    if (std::isfinite(slope)) {
      for (std::size_t i = 0; i < N; ++i) r.d[i] = slope * a.d[i];
      return r;
    }
  }
  for (std::size_t i = 0; i < N; ++i) r.d[i] = chain(slope, a.d[i]);
  return r;
}

/// Returns f(a, b) from the given value and slopes.
template <int N, class S>
Forward<N, S> chain(const S& value, const S& slope_a, const Forward<N, S>& a, const S& slope_b,
                    const Forward<N, S>& b) {
  Forward<N, S> r;
  r.v = value;
  for (std::size_t i = 0; i < N; ++i) r.d[i] = chain(slope_a, a.d[i]) + chain(slope_b, b.d[i]);
  return r;
}

/// Returns f(a) from the series of f at the value of a.
inline double compose(const Jet<0>& f, double) {
  return f.c[0];
}
template <int P, int N, class S>
Forward<N, S> compose(const Jet<P>& f, const Forward<N, S>& a) {
  Jet<P - 1> value, slope;
  for (int k = 0; k < P; ++k) {
    value.c[k] = f.c[k];
    slope.c[k] = (k + 1) * f.c[k + 1];
  }
  return chain(compose(value, a.v), compose(slope, a.v), a);
}

}  // namespace detail

template <class Function, int N, class S>
Forward<N, S> lift(const Function& f, const Forward<N, S>& a) {
  return detail::compose(f(Jet<detail::order_of<Forward<N, S>>>::variable(a.value())), a);
}

/// Returns the angle of (x, y) from the x axis, in [-pi, pi].
template <int N, class S>
Forward<N, S> atan2(const Forward<N, S>& y, const Forward<N, S>& x) {
  using std::atan2, std::sqrt;
  // (x y' - y x')/(x^2 + y^2); hypot does not overflow where the squares do.
  const double size = std::hypot(x.value(), y.value());
  S length = size;
  if constexpr (detail::order_of < S >> 0) length *= sqrt(x.v / size * (x.v / size) + y.v / size * (y.v / size));
  return detail::chain(atan2(y.v, x.v), x.v / length / length, y, -y.v / length / length, x);
}

/// Returns a^p. Integer powers are multiplied out, so that the base may then be 0 or negative.
template <int N, class S>
Forward<N, S> pow(const Forward<N, S>& a, double p) {
  using std::pow;
  if (detail::is_small_integer(p)) return detail::signed_integer_power(a, static_cast<int>(p));
  return detail::chain(S(pow(a.v, p)), S(p * pow(a.v, p - 1.0)), a);
}

/// Returns a^b, a > 0; a constant exponent is treated as above.
template <int N, class S>
Forward<N, S> pow(const Forward<N, S>& a, const Forward<N, S>& b) {
  using std::pow, std::log;
  if (b.is_constant()) return pow(a, b.value());
  const S value = pow(a.v, b.v);
  return detail::chain(value, S(b.v * pow(a.v, b.v - 1.0)), a, S(value * log(a.v)), b);
}

}  // namespace tanor
