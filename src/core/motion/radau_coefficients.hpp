#pragma once

#include <array>
#include <complex>

namespace tanor::detail {

/// Radau IIA with three stages (Hairer & Wanner II, table IV.5.6) and what its Newton iteration needs (IV.8):
///
///   A^-1 = T diag(gamma, [alpha -beta; beta alpha]) T^-1
///
/// With W = T^-1 Z the system of three stages splits into one real and one complex system, the latter for W_2 + i W_3
/// with alpha + i beta.
struct RadauCoefficients {
  using Row = std::array<double, 3>;
  using Matrix = std::array<Row, 3>;

  Row c;  ///< nodes; the last one is 1, and its row of A holds the weights
  Matrix a, a_inverse;
  Matrix t, t_inverse;
  double gamma;
  std::complex<double> alpha_beta;
  Row e;  ///< weights of the error estimate (gamma/h M - J)^-1 (M y' + M sum e_i Z_i/h), of order 3
};

RadauCoefficients radau_coefficients();

}  // namespace tanor::detail
