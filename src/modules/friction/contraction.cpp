#include "friction/contraction.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tanor::detail {

/// For R >= 0, rho(R) < 1 exactly if I - R is a nonsingular M-matrix, that is, if elimination without exchanges has
/// positive pivots (Berman and Plemmons 1994, ch. 6). Then x = (I - R)^-1 1 >= 1, and |e| <= (I - R)^-1 |F(s) - s|.
double ContractionBound::amplification(const SlidingContacts& contacts) {
  constexpr double unproven = std::numeric_limits<double>::quiet_NaN();
  const std::size_t m = contacts.size();
  R_.resize(m * m);
  A_.resize(m * m);
  x_.assign(m, 1.0);
  for (std::size_t c = 0; c < m; ++c) {
    for (std::size_t j = 0; j < m; ++j) {
      R_[c * m + j] = contacts.mu[c] * contacts.W[j].col(static_cast<Eigen::Index>(c)).norm();
      A_[c * m + j] = (c == j ? 1.0 : 0.0) - R_[c * m + j];
    }
  }
  // A = L U and L y = 1, …
  for (std::size_t k = 0; k < m; ++k) {
    const double pivot = A_[k * m + k];
    if (!(pivot > 0.0)) return unproven;
    for (std::size_t c = k + 1; c < m; ++c) {
      const double factor = A_[c * m + k] / pivot;
      for (std::size_t j = k; j < m; ++j) A_[c * m + j] -= factor * A_[k * m + j];
      x_[c] -= factor * x_[k];
    }
  }
  // … U x = y.
  for (std::size_t c = m; c-- > 0;) {
    for (std::size_t j = c + 1; j < m; ++j) x_[c] -= A_[c * m + j] * x_[j];
    x_[c] /= A_[c * m + c];
  }
  // If I - R is nearly singular, x has no correct digits and proves nothing.
  double largest = 1.0;
  for (std::size_t c = 0; c < m; ++c) {
    double rest = x_[c] - 1.0;
    for (std::size_t j = 0; j < m; ++j) rest -= R_[c * m + j] * x_[j];
    if (!(std::abs(rest) < 1e-3 && x_[c] >= 1.0 - 1e-9)) return unproven;
    largest = std::max(largest, x_[c]);
  }
  return std::isfinite(largest) ? largest : unproven;
}

}  // namespace tanor::detail
