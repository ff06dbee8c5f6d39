#pragma once

/// \file
/// Truncated Taylor series in one variable. A function written once over a scalar type yields all its derivatives.
///
/// xi(r + e v, t + e) on jets in e gives xi, its rate and phi at once; order P gives the coefficients of a Taylor
/// integrator. The recurrences compare coefficients in the differential equation that the function solves (Griewank &
/// Walther, Evaluating Derivatives, table 13.2). Where a function has no derivative, the coefficients are infinite or
/// NaN and the value stays right. A jet without higher coefficients is a constant, and so is every function of it.

#include <array>
#include <cmath>
#include <compare>
#include <limits>

namespace tanor {

/// A series a(e) = sum over k = 0 … P of c[k] e^k. Comparisons look at the value c[0] alone.
template <int P>
struct Jet {
  static_assert(P >= 0, "a jet has at least its value");

  std::array<double, P + 1> c{};  ///< c[k] = (k-th derivative)/k!

  constexpr Jet() = default;
  constexpr Jet(double constant) { c[0] = constant; }  // NOLINT(google-explicit-constructor): constants are jets

  /// Returns value + rate e.
  static constexpr Jet variable(double value, double rate = 1.0) {
    Jet a(value);
    if constexpr (P > 0) a.c[1] = rate;
    return a;
  }

  constexpr double value() const { return c[0]; }

  /// Returns the k-th derivative at e = 0, k! c[k]; 0 <= k <= P.
  constexpr double derivative(int k) const {
    double factorial = 1.0;
    for (int j = 2; j <= k; ++j) factorial *= j;
    return factorial * c[k];
  }

  constexpr bool is_constant() const {
    for (int k = 1; k <= P; ++k) {
      if (c[k] != 0.0) return false;
    }
    return true;
  }

  constexpr Jet& operator+=(const Jet& b) {
    for (int k = 0; k <= P; ++k) c[k] += b.c[k];
    return *this;
  }
  constexpr Jet& operator-=(const Jet& b) {
    for (int k = 0; k <= P; ++k) c[k] -= b.c[k];
    return *this;
  }
  constexpr Jet& operator*=(double b) {
    for (double& coefficient : c) coefficient *= b;
    return *this;
  }
  constexpr Jet& operator/=(double b) {
    for (double& coefficient : c) coefficient /= b;
    return *this;
  }
  constexpr Jet& operator*=(const Jet& b) { return *this = *this * b; }
  constexpr Jet& operator/=(const Jet& b) { return *this = *this / b; }

  friend constexpr Jet operator+(const Jet& a) { return a; }
  friend constexpr Jet operator-(Jet a) {
    for (double& coefficient : a.c) coefficient = -coefficient;
    return a;
  }
  friend constexpr Jet operator+(Jet a, const Jet& b) { return a += b; }
  friend constexpr Jet operator-(Jet a, const Jet& b) { return a -= b; }
  friend constexpr Jet operator*(Jet a, double b) { return a *= b; }
  friend constexpr Jet operator*(double a, Jet b) { return b *= a; }
  friend constexpr Jet operator/(Jet a, double b) { return a /= b; }

  friend constexpr Jet operator*(const Jet& a, const Jet& b) {
    Jet r;
    for (int k = 0; k <= P; ++k) {
      // r_k = sum over j = 0 … k of a_j b_{k-j}; summed in a register, which is four times as fast
      double sum = a.c[0] * b.c[k];
      for (int j = 1; j <= k; ++j) sum += a.c[j] * b.c[k - j];
      r.c[k] = sum;
    }
    return r;
  }

  friend constexpr Jet operator/(const Jet& a, const Jet& b) {
    Jet r;
    for (int k = 0; k <= P; ++k) {
      // r b = a:  r_k = (a_k - sum over j = 1 … k of b_j r_{k-j}) / b_0
      double sum = a.c[k];
      for (int j = 1; j <= k; ++j) sum -= b.c[j] * r.c[k - j];
      r.c[k] = sum / b.c[0];
    }
    return r;
  }

  friend constexpr bool operator==(const Jet& a, const Jet& b) { return a.c[0] == b.c[0]; }
  friend constexpr std::partial_ordering operator<=>(const Jet& a, const Jet& b) { return a.c[0] <=> b.c[0]; }
};

namespace detail {

/// Returns base^n by squaring, n >= 0. The result is exact if the products are, for any base; n = 0 gives 1.
template <class T>
constexpr T integer_power(T base, int n) {
  T result(1.0);
  for (; n > 0; n /= 2) {
    if (n % 2 == 1) result = result * base;
    if (n > 1) base = base * base;
  }
  return result;
}

/// Largest exponent that is multiplied out; above it pow has a smaller rounding error than the products.
inline constexpr int largest_multiplied_power = 64;

/// Returns true if base^exponent is multiplied out.
constexpr bool is_small_integer(double exponent) {
  return -largest_multiplied_power <= exponent && exponent <= largest_multiplied_power &&
         exponent == static_cast<int>(exponent);
}

/// Returns base^n for an integer n of either sign.
template <class T>
constexpr T signed_integer_power(const T& base, int n) {
  return n < 0 ? T(1.0) / integer_power(base, -n) : integer_power(base, n);
}

/// Returns r with r' = a'/g and the given value; it serves the logarithm and inverse functions.
template <int P>
constexpr Jet<P> integrate_ratio(double value, const Jet<P>& a, const Jet<P>& g) {
  Jet<P> r(value);
  for (int k = 1; k <= P; ++k) {
    // r' g = a':  k g_0 r_k = k a_k - sum over j = 1 … k-1 of j r_j g_{k-j}
    double sum = k * a.c[k];
    for (int j = 1; j < k; ++j) sum -= j * r.c[j] * g.c[k - j];
    r.c[k] = sum / (k * g.c[0]);
  }
  return r;
}

/// Returns coefficient k > 0 of the integral of a' f:  1/k sum over j = 1 … k of j a_j f_{k-j}.
template <int P>
constexpr double integral_coefficient(const Jet<P>& a, const Jet<P>& f, int k) {
  double sum = 0.0;
  for (int j = 1; j <= k; ++j) sum += j * a.c[j] * f.c[k - j];
  return sum / k;
}

/// Sine and cosine (sign = -1) or their hyperbolic forms (sign = +1) of a, from their values.
template <int P>
struct SineCosine {
  Jet<P> sine, cosine;

  constexpr SineCosine(const Jet<P>& a, double sine_value, double cosine_value, double sign)
      : sine(sine_value), cosine(cosine_value) {
    for (int k = 1; k <= P; ++k) {
      // s' = a' c,  c' = sign a' s
      sine.c[k] = integral_coefficient(a, cosine, k);
      cosine.c[k] = sign * integral_coefficient(a, sine, k);
    }
  }
};

template <int P>
Jet<P> tangent(const Jet<P>& a, double value, double slope, double sign) {
  Jet<P> r(value), g(slope);
  for (int k = 1; k <= P; ++k) {
    // r' = a' g,  g = 1 + sign r^2
    r.c[k] = integral_coefficient(a, g, k);
    for (int j = 0; j <= k; ++j) g.c[k] += sign * r.c[j] * r.c[k - j];
  }
  return r;
}

}  // namespace detail

template <int P>
Jet<P> sqrt(const Jet<P>& a) {
  Jet<P> r(std::sqrt(a.c[0]));
  if (a.c[0] == 0.0 && a.is_constant()) return r;
  for (int k = 1; k <= P; ++k) {
    // r^2 = a:  2 r_0 r_k = a_k - sum over j = 1 … k-1 of r_j r_{k-j}
    double sum = a.c[k];
    for (int j = 1; j < k; ++j) sum -= r.c[j] * r.c[k - j];
    r.c[k] = sum / (2.0 * r.c[0]);
  }
  return r;
}

template <int P>
Jet<P> exp(const Jet<P>& a) {
  Jet<P> r(std::exp(a.c[0]));
  // r' = a' r
  for (int k = 1; k <= P; ++k) r.c[k] = detail::integral_coefficient(a, r, k);
  return r;
}

template <int P>
Jet<P> log(const Jet<P>& a) {
  if (a.is_constant()) return std::log(a.c[0]);
  return detail::integrate_ratio(std::log(a.c[0]), a, a);
}

template <int P>
Jet<P> sin(const Jet<P>& a) {
  return detail::SineCosine<P>(a, std::sin(a.c[0]), std::cos(a.c[0]), -1.0).sine;
}

template <int P>
Jet<P> cos(const Jet<P>& a) {
  return detail::SineCosine<P>(a, std::sin(a.c[0]), std::cos(a.c[0]), -1.0).cosine;
}

template <int P>
Jet<P> tan(const Jet<P>& a) {
  const double value = std::tan(a.c[0]);
  return detail::tangent(a, value, 1.0 + value * value, 1.0);
}

template <int P>
Jet<P> asin(const Jet<P>& a) {
  if (a.is_constant()) return std::asin(a.c[0]);
  return detail::integrate_ratio(std::asin(a.c[0]), a, sqrt((1.0 - a) * (1.0 + a)));
}

template <int P>
Jet<P> acos(const Jet<P>& a) {
  if (a.is_constant()) return std::acos(a.c[0]);
  return detail::integrate_ratio(std::acos(a.c[0]), -a, sqrt((1.0 - a) * (1.0 + a)));
}

template <int P>
Jet<P> atan(const Jet<P>& a) {
  return detail::integrate_ratio(std::atan(a.c[0]), a, 1.0 + a * a);
}

/// Returns the angle of (x, y) from the x axis, in [-pi, pi].
template <int P>
Jet<P> atan2(const Jet<P>& y, const Jet<P>& x) {
  const double angle = std::atan2(y.c[0], x.c[0]);
  if (y.is_constant() && x.is_constant()) return angle;
  // Turned by its own angle, (x, y) lies on the positive x axis, where atan2 is atan(y/x).
  const double length = std::hypot(x.c[0], y.c[0]), cosine = x.c[0] / length, sine = y.c[0] / length;
  Jet<P> r = atan((cosine * y - sine * x) / (cosine * x + sine * y));
  r.c[0] = angle;
  return r;
}

template <int P>
Jet<P> sinh(const Jet<P>& a) {
  return detail::SineCosine<P>(a, std::sinh(a.c[0]), std::cosh(a.c[0]), 1.0).sine;
}

template <int P>
Jet<P> cosh(const Jet<P>& a) {
  return detail::SineCosine<P>(a, std::sinh(a.c[0]), std::cosh(a.c[0]), 1.0).cosine;
}

template <int P>
Jet<P> tanh(const Jet<P>& a) {
  // 1/cosh^2 does not cancel for large arguments, as 1 - tanh^2 would.
  const double secant = 1.0 / std::cosh(a.c[0]);
  return detail::tangent(a, std::tanh(a.c[0]), secant * secant, -1.0);
}

/// Returns a^p. Integer powers are multiplied out, so that the base may then be 0 or negative.
template <int P>
Jet<P> pow(const Jet<P>& a, double p) {
  if (detail::is_small_integer(p)) return detail::signed_integer_power(a, static_cast<int>(p));
  Jet<P> r(std::pow(a.c[0], p));
  if (a.is_constant()) return r;
  for (int k = 1; k <= P; ++k) {
    if (a.c[0] == 0.0) {
      // a = O(e), a^p = O(e^p): coefficients below p vanish, the others do not exist.
      r.c[k] = k < p ? 0.0 : std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    // a r' = p a' r:  k a_0 r_k = sum over j = 1 … k of (p j - (k - j)) a_j r_{k-j}
    double sum = 0.0;
    for (int j = 1; j <= k; ++j) sum += (p * j - (k - j)) * a.c[j] * r.c[k - j];
    r.c[k] = sum / (k * a.c[0]);
  }
  return r;
}

/// Returns a^b = exp(b log a), a > 0; a constant exponent is treated as above.
template <int P>
Jet<P> pow(const Jet<P>& a, const Jet<P>& b) {
  if (b.is_constant()) return pow(a, b.c[0]);
  Jet<P> r = exp(b * log(a));
  r.c[0] = std::pow(a.c[0], b.c[0]);
  return r;
}

// ---- functions of every number with derivatives ----

/// True for a number with derivatives, whose comparisons look at the value alone; see also Forward.
template <class T>
inline constexpr bool has_derivatives = false;
template <int P>
inline constexpr bool has_derivatives<Jet<P>> = true;
template <class T>
concept Differentiable = has_derivatives<T>;

/// True for a number made of simpler ones: lift(f, a) finds its function f from those of a jet or of its parts.
template <class T>
inline constexpr bool is_composed = false;
template <class T>
concept Composed = is_composed<T>;

// A jet states each function once, by its value and its differential equation; composed numbers follow it.
// clang-format off
template <Composed T> T sqrt(const T& a) { return lift([](const auto& x) { using std::sqrt; return sqrt(x); }, a); }
template <Composed T> T exp(const T& a) { return lift([](const auto& x) { using std::exp; return exp(x); }, a); }
template <Composed T> T log(const T& a) { return lift([](const auto& x) { using std::log; return log(x); }, a); }
template <Composed T> T sin(const T& a) { return lift([](const auto& x) { using std::sin; return sin(x); }, a); }
template <Composed T> T cos(const T& a) { return lift([](const auto& x) { using std::cos; return cos(x); }, a); }
template <Composed T> T tan(const T& a) { return lift([](const auto& x) { using std::tan; return tan(x); }, a); }
template <Composed T> T asin(const T& a) { return lift([](const auto& x) { using std::asin; return asin(x); }, a); }
template <Composed T> T acos(const T& a) { return lift([](const auto& x) { using std::acos; return acos(x); }, a); }
template <Composed T> T atan(const T& a) { return lift([](const auto& x) { using std::atan; return atan(x); }, a); }
template <Composed T> T sinh(const T& a) { return lift([](const auto& x) { using std::sinh; return sinh(x); }, a); }
template <Composed T> T cosh(const T& a) { return lift([](const auto& x) { using std::cosh; return cosh(x); }, a); }
template <Composed T> T tanh(const T& a) { return lift([](const auto& x) { using std::tanh; return tanh(x); }, a); }
// clang-format on

// At 0, abs takes the branch of positive numbers; min and max of equal numbers take the first one.
// clang-format off
template <Differentiable T> constexpr T abs(const T& a) { return a < T(0.0) ? -a : a; }
template <Differentiable T> constexpr T min(const T& a, const T& b) { return b < a ? b : a; }
template <Differentiable T> constexpr T max(const T& a, const T& b) { return a < b ? b : a; }
template <Differentiable T> constexpr T min(const T& a, double b) { return min(a, T(b)); }
template <Differentiable T> constexpr T min(double a, const T& b) { return min(T(a), b); }
template <Differentiable T> constexpr T max(const T& a, double b) { return max(a, T(b)); }
template <Differentiable T> constexpr T max(double a, const T& b) { return max(T(a), b); }
template <Differentiable T> T pow(double a, const T& b) { return pow(T(a), b); }
template <Differentiable T> T atan2(const T& y, double x) { return atan2(y, T(x)); }
template <Differentiable T> T atan2(double y, const T& x) { return atan2(T(y), x); }
// clang-format on

}  // namespace tanor
