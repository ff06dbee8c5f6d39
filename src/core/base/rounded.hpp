#pragma once

#include <cmath>
#include <limits>

namespace tanor::detail {

/// A number with a bound of the rounding errors in it (running error analysis; Higham, Accuracy and Stability of
/// Numerical Algorithms, 2002, section 3.3). A difference keeps the errors of its terms when these cancel.
///
/// Numbers that are given have no error.
struct Rounded {
  double v = 0.0, error = 0.0;

  Rounded() = default;
  Rounded(double exact) : v(exact) {}  // NOLINT(google-explicit-constructor): constants fit everywhere
  /// Makes the result of an operation whose operands bring the error `carried`.
  Rounded(double result, double carried) : v(result), error(carried + unit * std::abs(result)) {}

  /// Makes the result of a library function. Such functions are accurate to one ulp, basic operations to half of one.
  static Rounded of_library(double result, double carried) { return {result, carried + unit * std::abs(result)}; }

  double value() const { return v; }
  bool is_zero() const { return v == 0.0 && error == 0.0; }

  friend Rounded operator-(const Rounded& a) {
    Rounded result(-a.v);
    result.error = a.error;
    return result;
  }
  friend Rounded operator+(const Rounded& a, const Rounded& b) { return {a.v + b.v, a.error + b.error}; }
  friend Rounded operator-(const Rounded& a, const Rounded& b) { return {a.v - b.v, a.error + b.error}; }
  friend Rounded operator*(const Rounded& a, const Rounded& b) {
    return {a.v * b.v, std::abs(a.v) * b.error + a.error * std::abs(b.v) + a.error * b.error};
  }
  friend Rounded operator/(const Rounded& a, const Rounded& b) {
    // a/b moves by (da + |a/b| db)/(|b| - db). Nothing is known if b is no larger than its error.
    const double quotient = a.v / b.v;
    return {quotient, (a.error + std::abs(quotient) * b.error) / positive(std::abs(b.v) - b.error)};
  }

  /// Returns x, or NaN if x is not positive although a bound needs it to be.
  static double positive(double x) { return x > 0.0 ? x : std::numeric_limits<double>::quiet_NaN(); }

 private:
  static constexpr double unit = 0.5 * std::numeric_limits<double>::epsilon();
};

inline Rounded sqrt(const Rounded& a) {
  // |sqrt(a + e) - sqrt(a)| <= min(e/sqrt(a), sqrt(e))
  const double root = std::sqrt(a.v);
  return {root, a.error > 0.0 ? std::fmin(a.error / root, std::sqrt(a.error)) : 0.0};
}
inline Rounded exp(const Rounded& a) {
  return Rounded::of_library(std::exp(a.v), std::exp(a.v + a.error) * a.error);
}
inline Rounded log(const Rounded& a) {
  return Rounded::of_library(std::log(a.v), a.error / Rounded::positive(a.v - a.error));
}
inline Rounded sin(const Rounded& a) {
  return Rounded::of_library(std::sin(a.v), a.error);
}
inline Rounded cos(const Rounded& a) {
  return Rounded::of_library(std::cos(a.v), a.error);
}
inline Rounded atan2(const Rounded& y, const Rounded& x) {
  // The angle turns by the error of the position over the distance.
  const double place = std::hypot(y.error, x.error);
  const double carried = place > 0.0 ? place / Rounded::positive(std::hypot(y.v, x.v) - place) : 0.0;
  return Rounded::of_library(std::atan2(y.v, x.v), carried);
}

}  // namespace tanor::detail
