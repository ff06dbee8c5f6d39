#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <vector>

/// \file Polynomials as which a scheme follows what acts along its step, on the fractions [0, 1] of the step.
namespace tanor::detail {

/// Writes Chebyshev's extreme points (1 - cos(pi j/N))/2, j = 0 … N, where polynomials of degree N interpolate best.
inline void place_chebyshev_points(std::size_t count, std::vector<double>* points) {
  if (points->size() == count) return;
  points->resize(count);
  for (std::size_t j = 0; j < count; ++j)
    (*points)[j] = 0.5 - 0.5 * std::cos(std::numbers::pi * static_cast<double>(j) / static_cast<double>(count - 1));
}

/// Subtracts from the values at the places s the polynomial through f [points] at the Chebyshev points, by the
/// barycentric formula (Berrut & Trefethen, SIAM Rev. 46, 2004):
///
///   p(s) = sum w_j f_j/(s - s_j) / sum w_j/(s - s_j),   w_j = (-1)^j, half of it at both ends
inline void subtract_polynomial(std::span<const double> points, const double* f, std::span<const double> s,
                                double* values) {
  constexpr std::size_t block = 64;
  constexpr double at_point = 1e-300;
  for (std::size_t first = 0; first < s.size(); first += block) {
    const std::size_t count = std::min(block, s.size() - first);
    std::array<double, block> over{}, below{};
    for (std::size_t j = 0; j < points.size(); ++j) {
      const double size = j == 0 || j + 1 == points.size() ? 0.5 : 1.0, weight = j % 2 == 0 ? size : -size;
      for (std::size_t i = 0; i < count; ++i) {
        const double distance = s[first + i] - points[j], part = weight / (distance == 0.0 ? at_point : distance);
        over[i] += part * f[j];
        below[i] += part;
      }
    }
    for (std::size_t i = 0; i < count; ++i) values[first + i] -= over[i] / below[i];
  }
}

}  // namespace tanor::detail
