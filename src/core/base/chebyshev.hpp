#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <vector>

namespace tanor::detail {

/// The polynomial as which a scheme follows what acts along its step, on the fractions [0, 1] of the step: that of
/// degree N through the values at Chebyshev's extreme points (1 - cos(pi j/N))/2, where polynomials interpolate best.
class ChebyshevPolynomial {
 public:
  ChebyshevPolynomial() {
    for (std::vector<double>* array : {&points_, &cosines_, &coefficients_}) array->reserve(usual_size);
  }

  /// Takes so many points, N + 1.
  void place(std::size_t count) {
    if (points_.size() == count) return;
    cosines_.resize(2 * (count - 1));
    points_.resize(count);
    for (std::size_t j = 0; j < cosines_.size(); ++j)
      cosines_[j] = std::cos(std::numbers::pi * static_cast<double>(j) / static_cast<double>(count - 1));
    for (std::size_t j = 0; j < count; ++j) points_[j] = 0.5 * (1.0 - cosines_[j]);
  }
  const std::vector<double>& points() const { return points_; }

  /// Subtracts the polynomial through f [points] from the values at the places s, in blocks side by side by Clenshaw's
  /// scheme:
  ///
  ///   p(x) = sum c_k T_k(x),   b_k = c_k + 2 x b_{k+1} - b_{k+2},   p = c_0 + x b_1 - b_2,   x = 1 - 2 s
  void subtract(const double* f, std::span<const double> s, double* values) {
    constexpr std::size_t block = 64;
    find_coefficients(f);
    for (std::size_t first = 0; first < s.size(); first += block) {
      const std::size_t count = std::min(block, s.size() - first);
      std::array<double, block> x, next{}, after_next{};  // NOLINT: x is filled before use
      for (std::size_t i = 0; i < count; ++i) x[i] = 1.0 - 2.0 * s[first + i];
      for (std::size_t k = points_.size() - 1; k >= 1; --k) {
        for (std::size_t i = 0; i < count; ++i) {
          const double b = coefficients_[k] + 2.0 * x[i] * next[i] - after_next[i];
          after_next[i] = next[i];
          next[i] = b;
        }
      }
      for (std::size_t i = 0; i < count; ++i) values[first + i] -= coefficients_[0] + x[i] * next[i] - after_next[i];
    }
  }

 private:
  static constexpr std::size_t usual_size = 64;

  /// c_k = 2/N sum'' f_j cos(pi j k/N), with half the first and the last term; c_0 and c_N are half of that
  void find_coefficients(const double* f) {
    const std::size_t degree = points_.size() - 1;
    coefficients_.assign(points_.size(), 0.0);
    for (std::size_t k = 0; k <= degree; ++k) {
      double sum = 0.0;
      for (std::size_t j = 0, m = 0; j <= degree; ++j, m += k) {
        if (m >= 2 * degree) m -= 2 * degree;  // j k modulo 2 N
        sum += (j == 0 || j == degree ? 0.5 : 1.0) * f[j] * cosines_[m];
      }
      coefficients_[k] = (k == 0 || k == degree ? 1.0 : 2.0) / static_cast<double>(degree) * sum;
    }
  }

  std::vector<double> points_, cosines_, coefficients_;
};

}  // namespace tanor::detail
