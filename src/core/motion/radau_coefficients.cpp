#include "motion/radau_coefficients.hpp"

#include <cmath>
#include <cstddef>

namespace tanor::detail {

namespace {

using Matrix = RadauCoefficients::Matrix;

template <class T>
std::array<T, 3> cross(const std::array<T, 3>& a, const std::array<T, 3>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Inverts m. The columns of the inverse are the cross products of rows over the determinant.
Matrix invert(const Matrix& m) {
  Matrix result;
  for (std::size_t j = 0; j < 3; ++j) {
    const auto column = cross(m[(j + 1) % 3], m[(j + 2) % 3]);
    const double determinant = m[j][0] * column[0] + m[j][1] * column[1] + m[j][2] * column[2];
    for (std::size_t i = 0; i < 3; ++i) result[i][j] = column[i] / determinant;
  }
  return result;
}

/// Returns the eigenvector whose last number is 1; it is orthogonal to the first two rows of m - mu I.
template <class T>
std::array<T, 3> find_eigenvector(const Matrix& m, T mu) {
  const std::array<T, 3> first{m[0][0] - mu, m[0][1], m[0][2]}, second{m[1][0], m[1][1] - mu, m[1][2]};
  const std::array<T, 3> x = cross(first, second);
  return {x[0] / x[2], x[1] / x[2], T(1.0)};
}

}  // namespace

RadauCoefficients radau_coefficients() {
  const double q = std::sqrt(6.0);
  RadauCoefficients r;
  r.c = {(4 - q) / 10, (4 + q) / 10, 1.0};
  r.a = {{{(88 - 7 * q) / 360, (296 - 169 * q) / 1800, (-2 + 3 * q) / 225},
          {(296 + 169 * q) / 1800, (88 + 7 * q) / 360, (-2 - 3 * q) / 225},
          {(16 - q) / 36, (16 + q) / 36, 1.0 / 9}}};
  r.e = {-(13 + 7 * q) / 3, (-13 + 7 * q) / 3, -1.0 / 3};
  r.a_inverse = invert(r.a);

  // Eigenvalues of A: (6 + d(d - 1))/30 and (12 - d(d - 1))/60 -+ i sqrt(3) d (d + 1)/60 with d = 9^(1/3)
  const double d = std::cbrt(9.0);
  r.gamma = 30.0 / (6.0 + d * (d - 1.0));
  r.alpha_beta = 60.0 / std::complex<double>(12.0 - d * (d - 1.0), -std::sqrt(3.0) * d * (d + 1.0));
  const auto real = find_eigenvector(r.a_inverse, r.gamma);
  const auto pair = find_eigenvector(r.a_inverse, r.alpha_beta);
  for (std::size_t i = 0; i < 3; ++i) r.t[i] = {real[i], pair[i].real(), -pair[i].imag()};
  r.t_inverse = invert(r.t);
  return r;
}

}  // namespace tanor::detail
