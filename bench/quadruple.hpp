#pragma once

/// \file Numbers of 113 bits, and what the definitions of kinds and Eigen need of them.

#include <array>
#include <cfloat>
#include <cmath>

#include <Eigen/Core>

/// A class of its own, so that Eigen finds its root.
struct Quad {
#if LDBL_MANT_DIG == 113
  using Number = long double;
#else
  __extension__ typedef __float128 Number;
#endif
  Number x = 0;

  Quad() = default;
  Quad(double value) : x(value) {}  // NOLINT(google-explicit-constructor): doubles are such numbers
  explicit operator double() const {
    return static_cast<double>(x);
  }

  Quad& operator+=(Quad b) {
    return x += b.x, *this;
  }
  Quad& operator-=(Quad b) {
    return x -= b.x, *this;
  }
  Quad& operator*=(Quad b) {
    return x *= b.x, *this;
  }
  Quad& operator/=(Quad b) {
    return x /= b.x, *this;
  }
  friend Quad operator-(Quad a) {
    return a.x = -a.x, a;
  }
  friend Quad operator+(Quad a, Quad b) {
    return a += b;
  }
  friend Quad operator-(Quad a, Quad b) {
    return a -= b;
  }
  friend Quad operator*(Quad a, Quad b) {
    return a *= b;
  }
  friend Quad operator/(Quad a, Quad b) {
    return a /= b;
  }
  friend bool operator==(Quad a, Quad b) {
    return a.x == b.x;
  }
  friend bool operator<(Quad a, Quad b) {
    return a.x < b.x;
  }
  friend bool operator>(Quad a, Quad b) {
    return b < a;
  }
  friend bool operator<=(Quad a, Quad b) {
    return a.x <= b.x;
  }
  friend Quad abs(Quad a) {
    return a.x < 0 ? -a : a;
  }
  /// Newton's method from the root of the nearest double: 16, 32, 64 digits.
  friend Quad sqrt(Quad a) {
    Quad root = std::sqrt(static_cast<double>(a));
    for (int k = 0; k < 2 && root > 0.0; ++k) root = 0.5 * (root + a / root);
    return root;
  }
};

/// A series a(e) = c[0] + c[1] e + c[2] e^2, as Jet<2> of doubles.
struct QuadJet {
  std::array<Quad, 3> c{};

  QuadJet(double constant = 0.0) : c{constant, 0.0, 0.0} {}  // NOLINT(google-explicit-constructor): constants are jets
  QuadJet(Quad value, Quad rate) : c{value, rate, 0.0} {}

  friend QuadJet operator+(QuadJet a, const QuadJet& b) {
    for (std::size_t k = 0; k < 3; ++k) a.c[k] += b.c[k];
    return a;
  }
  friend QuadJet operator-(QuadJet a, const QuadJet& b) {
    for (std::size_t k = 0; k < 3; ++k) a.c[k] -= b.c[k];
    return a;
  }
  friend QuadJet operator*(const QuadJet& a, const QuadJet& b) {
    QuadJet result;
    result.c = {a.c[0] * b.c[0], a.c[0] * b.c[1] + a.c[1] * b.c[0],
                a.c[0] * b.c[2] + a.c[1] * b.c[1] + a.c[2] * b.c[0]};
    return result;
  }
  friend QuadJet operator/(const QuadJet& a, const QuadJet& b) {
    QuadJet q;
    q.c[0] = a.c[0] / b.c[0];
    q.c[1] = (a.c[1] - q.c[0] * b.c[1]) / b.c[0];
    q.c[2] = (a.c[2] - q.c[0] * b.c[2] - q.c[1] * b.c[1]) / b.c[0];
    return q;
  }
  friend QuadJet sqrt(const QuadJet& a) {
    QuadJet s;
    s.c[0] = sqrt(a.c[0]);
    s.c[1] = a.c[1] / (2.0 * s.c[0]);
    s.c[2] = (a.c[2] - s.c[1] * s.c[1]) / (2.0 * s.c[0]);
    return s;
  }
};

namespace Eigen {
template <>
struct NumTraits<Quad> : GenericNumTraits<Quad> {
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 0,
    ReadCost = 2,
    AddCost = 40,
    MulCost = 60
  };
};
}  // namespace Eigen
