#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>

#include <tanor/forward.hpp>
#include <tanor/jet.hpp>

// Says that the iterations of the loop that follows do not depend on each other.
#ifdef __clang__
#define TANOR_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define TANOR_INDEPENDENT _Pragma("GCC ivdep")
#endif

namespace tanor::detail {

/// Several numbers, jets or forward derivatives side by side, coefficient by coefficient. An interpreter reads an
/// instruction once for all of them, and the compiler vectorizes the loops below.
///
/// Each lane has the bits that T alone would have. The arithmetic and the square root are written out; every other
/// function goes lane by lane through that of T.
template <class T>
struct Lanes {
  static constexpr std::size_t width = 32;
  static constexpr std::size_t num_coefficients = sizeof(T) / sizeof(double);
  using Coefficients = std::array<double, num_coefficients>;  // coefficients of T; the value first

  double c[num_coefficients][width];

  Lanes() {}  // NOLINT(modernize-use-equals-default): leaves the numbers alone
  explicit Lanes(double constant) { fill(constant); }

  void fill(double constant) {
    for (std::size_t lane = 0; lane < width; ++lane) c[0][lane] = constant;
    for (std::size_t k = 1; k < num_coefficients; ++k) {
      for (std::size_t lane = 0; lane < width; ++lane) c[k][lane] = 0.0;
    }
  }

  T operator[](std::size_t lane) const {
    Coefficients coefficients;
    for (std::size_t k = 0; k < num_coefficients; ++k) coefficients[k] = c[k][lane];
    return std::bit_cast<T>(coefficients);
  }
  void set(std::size_t lane, const T& x) {
    const auto coefficients = std::bit_cast<Coefficients>(x);
    for (std::size_t k = 0; k < num_coefficients; ++k) c[k][lane] = coefficients[k];
  }

  Lanes& operator+=(const Lanes& b) {
    for (std::size_t k = 0; k < num_coefficients; ++k) {
      TANOR_INDEPENDENT
      for (std::size_t lane = 0; lane < width; ++lane) c[k][lane] += b.c[k][lane];
    }
    return *this;
  }
  Lanes& operator-=(const Lanes& b) {
    for (std::size_t k = 0; k < num_coefficients; ++k) {
      TANOR_INDEPENDENT
      for (std::size_t lane = 0; lane < width; ++lane) c[k][lane] -= b.c[k][lane];
    }
    return *this;
  }
  Lanes& operator*=(const Lanes& b);
  Lanes& operator/=(const Lanes& b);

  friend Lanes operator-(const Lanes& a) {
    Lanes r;
    for (std::size_t k = 0; k < num_coefficients; ++k) {
      for (std::size_t lane = 0; lane < width; ++lane) r.c[k][lane] = -a.c[k][lane];
    }
    return r;
  }
  friend Lanes operator*(Lanes a, const Lanes& b) { return a *= b; }
  friend Lanes operator/(Lanes a, const Lanes& b) { return a /= b; }
};

template <class T>
inline constexpr bool is_jet = false;
template <>
inline constexpr bool is_jet<Jet<2>> = true;

template <class T>
Lanes<T>& Lanes<T>::operator*=(const Lanes& b) {
  TANOR_INDEPENDENT
  for (std::size_t lane = 0; lane < width; ++lane) {
    const double a0 = c[0][lane], b0 = b.c[0][lane];
    if constexpr (detail::is_jet<T>) {
      const double a1 = c[1][lane], b1 = b.c[1][lane];
      c[2][lane] = a0 * b.c[2][lane] + a1 * b1 + c[2][lane] * b0;
      c[1][lane] = a0 * b1 + a1 * b0;
    } else {
      for (std::size_t k = 1; k < num_coefficients; ++k) c[k][lane] = c[k][lane] * b0 + a0 * b.c[k][lane];
    }
    c[0][lane] = a0 * b0;
  }
  return *this;
}

template <class T>
Lanes<T>& Lanes<T>::operator/=(const Lanes& b) {
  TANOR_INDEPENDENT
  for (std::size_t lane = 0; lane < width; ++lane) {
    // r b = a.
    const double b0 = b.c[0][lane], r0 = c[0][lane] / b0;
    if constexpr (detail::is_jet<T>) {
      const double b1 = b.c[1][lane], b2 = b.c[2][lane], r1 = (c[1][lane] - b1 * r0) / b0;
      c[2][lane] = (c[2][lane] - b1 * r1 - b2 * r0) / b0;
      c[1][lane] = r1;
    } else {
      for (std::size_t k = 1; k < num_coefficients; ++k) c[k][lane] = (c[k][lane] - r0 * b.c[k][lane]) / b0;
    }
    c[0][lane] = r0;
  }
  return *this;
}

/// Returns the function of each lane.
template <class Function, class T>
Lanes<T> lift(const Function& function, const Lanes<T>& a) {
  Lanes<T> r;
  for (std::size_t lane = 0; lane < Lanes<T>::width; ++lane) r.set(lane, function(a[lane]));
  return r;
}
template <class Function, class T>
Lanes<T> lift(const Function& function, const Lanes<T>& a, const Lanes<T>& b) {
  Lanes<T> r;
  for (std::size_t lane = 0; lane < Lanes<T>::width; ++lane) r.set(lane, function(a[lane], b[lane]));
  return r;
}

template <class T>
Lanes<T> sqrt(const Lanes<T>& a) {
  using std::sqrt;
  bool has_zero = false;
  for (std::size_t lane = 0; lane < Lanes<T>::width; ++lane) has_zero |= a.c[0][lane] == 0.0;
  if (has_zero) return lift([](const T& x) { return sqrt(x); }, a);
  Lanes<T> r;
  for (std::size_t lane = 0; lane < Lanes<T>::width; ++lane) {
    const double root = std::sqrt(a.c[0][lane]);
    r.c[0][lane] = root;
    if constexpr (detail::is_jet<T>) {
      // r^2 = a.
      const double r1 = a.c[1][lane] / (2.0 * root);
      r.c[1][lane] = r1;
      r.c[2][lane] = (a.c[2][lane] - r1 * r1) / (2.0 * root);
    } else if constexpr (Lanes<T>::num_coefficients > 1) {
      const double slope = 0.5 / root;
      for (std::size_t k = 1; k < Lanes<T>::num_coefficients; ++k) r.c[k][lane] = slope * a.c[k][lane];
    }
  }
  return r;
}

template <class T>
Lanes<T> signed_integer_power(const Lanes<T>& a, int n) {
  if (n == 2) return a * a;
  return lift([n](const T& x) { return detail::signed_integer_power(x, n); }, a);
}

using tanor::exp, tanor::log, tanor::sin, tanor::cos, tanor::tan, tanor::asin, tanor::acos, tanor::atan, tanor::sinh,
    tanor::cosh, tanor::tanh;

// clang-format off
template <class T> Lanes<T> abs(const Lanes<T>& a) { return lift([](const T& x) { using std::abs; return abs(x); }, a); }
template <class T> Lanes<T> pow(const Lanes<T>& a, const Lanes<T>& b) {
  return lift([](const T& x, const T& y) { using std::pow; return pow(x, y); }, a, b);
}
template <class T> Lanes<T> atan2(const Lanes<T>& a, const Lanes<T>& b) {
  return lift([](const T& x, const T& y) { using std::atan2; return atan2(x, y); }, a, b);
}
template <class T> Lanes<T> min(const Lanes<T>& a, const Lanes<T>& b) {
  return lift([](const T& x, const T& y) { using std::min; return min(x, y); }, a, b);
}
template <class T> Lanes<T> max(const Lanes<T>& a, const Lanes<T>& b) {
  return lift([](const T& x, const T& y) { using std::max; return max(x, y); }, a, b);
}
// clang-format on

}  // namespace tanor::detail

namespace tanor {

template <class T>
inline constexpr bool is_composed<detail::Lanes<T>> = true;

}  // namespace tanor
