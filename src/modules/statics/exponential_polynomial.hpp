#pragma once

#include <algorithm>
#include <complex>
#include <vector>

namespace tanor::detail {

/// A function of the time tau that is a sum of terms tau^k (a cos(w tau) + b sin(w tau)), an exponential polynomial.
/// Polynomials and steady rotations are of this kind, and so are sums and products of them. Its terms are unique, so
/// that it is constant at all times where it has none but the constant, and nothing has to be sampled. Other functions
/// of what changes are not known. Of what is constant they are some number, whatever it is, so that a branch which is
/// not taken here, or an exponential that is next to 0, hides nothing.
class ExponentialPolynomial {
 public:
  ExponentialPolynomial(double constant = 0.0)  // NOLINT(google-explicit-constructor): constants are functions
      : ExponentialPolynomial(constant, std::abs(constant)) {}
  /// Makes a constant that is a sum of terms whose absolute values have the sum `size`.
  ExponentialPolynomial(double constant, double size) : terms_{{0, 0.0, constant, size}} {}
  static ExponentialPolynomial time();
  static ExponentialPolynomial unknown();

  bool is_known() const { return is_known_; }
  bool is_constant() const { return is_known_ && terms_.size() == 1; }

  ExponentialPolynomial& operator+=(const ExponentialPolynomial& b) { return *this = *this + b; }
  friend ExponentialPolynomial operator-(const ExponentialPolynomial& a) { return ExponentialPolynomial(-1.0) * a; }
  friend ExponentialPolynomial operator+(const ExponentialPolynomial& a, const ExponentialPolynomial& b);
  friend ExponentialPolynomial operator-(const ExponentialPolynomial& a, const ExponentialPolynomial& b) {
    return a + -b;
  }
  friend ExponentialPolynomial operator*(const ExponentialPolynomial& a, const ExponentialPolynomial& b);
  friend ExponentialPolynomial operator/(const ExponentialPolynomial& a, const ExponentialPolynomial& b);

  friend ExponentialPolynomial sqrt(const ExponentialPolynomial& a);
  friend ExponentialPolynomial sin(const ExponentialPolynomial& a) { return a.turn({0.0, -1.0}); }
  friend ExponentialPolynomial cos(const ExponentialPolynomial& a) { return a.turn({1.0, 0.0}); }
  friend ExponentialPolynomial exp(const ExponentialPolynomial& a) { return a.some_number(1); }
  friend ExponentialPolynomial log(const ExponentialPolynomial& a) { return a.some_number(2); }
  friend ExponentialPolynomial sinh(const ExponentialPolynomial& a) { return a.some_number(3); }
  friend ExponentialPolynomial cosh(const ExponentialPolynomial& a) { return a.some_number(4); }
  friend ExponentialPolynomial asin(const ExponentialPolynomial& a) { return a.some_number(5); }
  friend ExponentialPolynomial atan(const ExponentialPolynomial& a) { return a.some_number(6); }
  friend ExponentialPolynomial abs(const ExponentialPolynomial& a) { return a.some_number(7); }
  friend ExponentialPolynomial atan2(const ExponentialPolynomial& a, const ExponentialPolynomial& b) {
    return a.some_number(8, b);
  }
  friend ExponentialPolynomial min(const ExponentialPolynomial& a, const ExponentialPolynomial& b) {
    return a.some_number(9, b);
  }
  friend ExponentialPolynomial max(const ExponentialPolynomial& a, const ExponentialPolynomial& b) {
    return a.some_number(10, b);
  }

 private:
  /// The real part of amplitude tau^power e^(i frequency tau). The sum of the sizes of all terms that were added up to
  /// it says how large its rounding may be.
  struct Term {
    int power;
    double frequency;  // rad/s, >= 0
    std::complex<double> amplitude;
    double size;
  };

  double constant() const { return terms_[0].amplitude.real(); }
  void add(Term term);
  ExponentialPolynomial turn(std::complex<double> factor) const;
  ExponentialPolynomial some_number(int function, const ExponentialPolynomial& b = {}) const;

  std::vector<Term> terms_;  // the constant first
  double fastest_ = 0.0;     // rad/s, of all terms that led here
  bool is_known_ = true;
};

}  // namespace tanor::detail
