#pragma once

#include <cmath>
#include <compare>
#include <type_traits>

#include <tanor/kinds/kind.hpp>

/// \file The arithmetic of the certificate. Kernels take derivatives by hand, or on Jet and Forward. Here the
/// definitions run once more on a separate implementation of the chain rule, so that an error in Jet or Forward shows.
namespace tanor::detail {

/// A number with its derivative along one direction. A dual number over dual numbers also has the second derivative
/// (hyper-dual numbers; J. Fike and J. Alonso, AIAA 2011-886).
template <class S>
struct Dual {
  S v{}, d{};

  Dual() = default;
  Dual(double constant) : v(constant) {}  // NOLINT(google-explicit-constructor): constants fit everywhere
  Dual(const S& value, const S& derivative) requires(!std::is_same_v<S, double>) : v(value), d(derivative) {}
  Dual(double value, double derivative) requires std::is_same_v<S, double> : v(value), d(derivative) {}

  double value() const {
    if constexpr (std::is_same_v<S, double>)
      return v;
    else
      return v.value();
  }
  bool is_zero() const { return is_zero(v) && is_zero(d); }

  friend Dual operator-(const Dual& a) { return {-a.v, -a.d}; }
  friend Dual operator+(const Dual& a, const Dual& b) { return {a.v + b.v, a.d + b.d}; }
  friend Dual operator-(const Dual& a, const Dual& b) { return {a.v - b.v, a.d - b.d}; }
  friend Dual operator*(const Dual& a, const Dual& b) { return {a.v * b.v, a.d * b.v + a.v * b.d}; }
  friend Dual operator/(const Dual& a, const Dual& b) { return {a.v / b.v, (a.d * b.v - a.v * b.d) / (b.v * b.v)}; }
  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }
  Dual& operator/=(const Dual& b) { return *this = *this / b; }

  friend bool operator==(const Dual& a, const Dual& b) { return a.value() == b.value(); }
  friend std::partial_ordering operator<=>(const Dual& a, const Dual& b) { return a.value() <=> b.value(); }

  /// Returns f(a) from f(a.v) and f'(a.v). A number that does not move has no derivative, however steep f is there.
  static Dual chain(const Dual& a, const S& value, const S& slope) {
    return {value, is_zero(a.d) ? S(0.0) : slope * a.d};
  }

 private:
  static bool is_zero(double x) { return x == 0.0; }
  static bool is_zero(const S& x) requires(!std::is_same_v<S, double>) { return x.is_zero(); }
};

// The functions that Jet and Forward know.

template <class S>
Dual<S> sqrt(const Dual<S>& a) {
  using std::sqrt;
  const S root = sqrt(a.v);
  return Dual<S>::chain(a, root, 1.0 / (root + root));
}
template <class S>
Dual<S> exp(const Dual<S>& a) {
  using std::exp;
  return Dual<S>::chain(a, exp(a.v), exp(a.v));
}
template <class S>
Dual<S> log(const Dual<S>& a) {
  using std::log;
  return Dual<S>::chain(a, log(a.v), 1.0 / a.v);
}
template <class S>
Dual<S> sin(const Dual<S>& a) {
  using std::cos, std::sin;
  return Dual<S>::chain(a, sin(a.v), cos(a.v));
}
template <class S>
Dual<S> cos(const Dual<S>& a) {
  using std::cos, std::sin;
  return Dual<S>::chain(a, cos(a.v), -sin(a.v));
}
template <class S>
Dual<S> tan(const Dual<S>& a) {
  using std::cos, std::tan;
  return Dual<S>::chain(a, tan(a.v), 1.0 / (cos(a.v) * cos(a.v)));
}
template <class S>
Dual<S> asin(const Dual<S>& a) {
  using std::asin, std::sqrt;
  return Dual<S>::chain(a, asin(a.v), 1.0 / sqrt(1.0 - a.v * a.v));
}
template <class S>
Dual<S> acos(const Dual<S>& a) {
  using std::acos, std::sqrt;
  return Dual<S>::chain(a, acos(a.v), -1.0 / sqrt(1.0 - a.v * a.v));
}
template <class S>
Dual<S> atan(const Dual<S>& a) {
  using std::atan;
  return Dual<S>::chain(a, atan(a.v), 1.0 / (1.0 + a.v * a.v));
}
/// Returns the angle of (x, y) against the x axis, in [-pi, pi].
template <class S>
Dual<S> atan2(const Dual<S>& y, const Dual<S>& x) {
  using std::atan2;
  return {atan2(y.v, x.v), (x.v * y.d - y.v * x.d) / (x.v * x.v + y.v * y.v)};
}
template <class S>
Dual<S> sinh(const Dual<S>& a) {
  using std::cosh, std::sinh;
  return Dual<S>::chain(a, sinh(a.v), cosh(a.v));
}
template <class S>
Dual<S> cosh(const Dual<S>& a) {
  using std::cosh, std::sinh;
  return Dual<S>::chain(a, cosh(a.v), sinh(a.v));
}
template <class S>
Dual<S> tanh(const Dual<S>& a) {
  using std::cosh, std::tanh;
  return Dual<S>::chain(a, tanh(a.v), 1.0 / (cosh(a.v) * cosh(a.v)));
}
template <class S>
Dual<S> abs(const Dual<S>& a) {
  return a < 0.0 ? -a : a;
}
template <class S>
Dual<S> min(const Dual<S>& a, const Dual<S>& b) {
  return b < a ? b : a;
}
template <class S>
Dual<S> min(const Dual<S>& a, double b) {
  return min(a, Dual<S>(b));
}
template <class S>
Dual<S> max(const Dual<S>& a, const Dual<S>& b) {
  return a < b ? b : a;
}
template <class S>
Dual<S> max(const Dual<S>& a, double b) {
  return max(a, Dual<S>(b));
}
/// Returns a^p, by products if p is a small whole number, which allows any sign of a.
template <class S>
Dual<S> pow(const Dual<S>& a, double p) {
  using std::pow;
  constexpr double largest = 64.0;
  if (p == std::floor(p) && std::abs(p) <= largest) {
    Dual<S> power(1.0);
    for (double k = 0.0; k < std::abs(p); k += 1.0) power *= a;
    return p < 0.0 ? 1.0 / power : power;
  }
  return Dual<S>::chain(a, pow(a.v, p), p * pow(a.v, p - 1.0));
}
/// Returns a^b. a must be positive unless b is a constant.
template <class S>
Dual<S> pow(const Dual<S>& a, const Dual<S>& b) {
  return (b - b.value()).is_zero() ? pow(a, b.value()) : exp(b * log(a));
}

/// A number along a curve: value and derivative in .v, first and second derivative in .d.
using SecondDual = Dual<Dual<double>>;

inline SecondDual second_dual(double value, double first, double second) {
  return {{value, first}, {first, second}};
}

}  // namespace tanor::detail

namespace tanor {

/// The clock of numbers that run along with time, as jets do.
template <>
struct ClockOf<detail::SecondDual> {
  double t;

  detail::SecondDual operator()(const ScalarFunction& function) const {
    const Jet<2> now = function(t);
    return detail::second_dual(now.value(), now.derivative(1), now.derivative(2));
  }
  TripleOf<detail::SecondDual> operator()(const VectorFunction& function) const {
    return {(*this)(function.components[0]), (*this)(function.components[1]), (*this)(function.components[2])};
  }
};

}  // namespace tanor
