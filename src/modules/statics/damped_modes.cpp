#include "statics/damped_modes.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "base/dense.hpp"
#include "base/numbers.hpp"

namespace tanor::detail {

using Rows = Eigen::Index;
using Eigen::MatrixXcd, Eigen::MatrixXd, Eigen::VectorXcd;

namespace {

/// Imaginary parts that rounding gives to equal real roots, relative to the fastest rate.
constexpr double real_roots_to = 1e-10;

/// Chooses one lambda of each conjugate pair, the smallest |lambda| first; rates are in units of the fastest one. Both
/// values of a pair within `zero` are kept, because rounding makes such a pair of the double root 0.
std::vector<Rows> choose(const VectorXcd& lambda, double zero) {
  std::vector<Rows> chosen;
  for (Rows k = 0; k < lambda.size(); ++k) {
    if (lambda[k].imag() >= -real_roots_to || std::abs(lambda[k]) <= zero) chosen.push_back(k);
  }
  std::ranges::stable_sort(chosen, {}, [&](Rows k) { return std::abs(lambda[k]); });
  return chosen;
}

/// Returns y^H A y from the symmetric and the skew part of a real matrix A. The first is real and the second imaginary,
/// so that neither part rounds the other.
std::complex<double> work_of(const MatrixXd& symmetric, const MatrixXd& skew, const VectorXcd& y) {
  return {y.dot(symmetric * y).real(), y.dot(skew * y).imag()};
}

/// Returns the root next to lambda of lambda^2 + lambda y^H D y + y^H W y = 0, which each mode y obeys. It frees the
/// decay of slow modes from the rounding errors of fast ones.
std::complex<double> refine(std::complex<double> lambda, std::complex<double> damping, std::complex<double> stiffness) {
  const std::complex<double> middle = -0.5 * damping, half_width = std::sqrt(middle * middle - stiffness);
  // The larger root is accurate to all its digits, and the product of both roots is the stiffness.
  const std::complex<double> sum = middle + half_width, difference = middle - half_width;
  const std::complex<double> one = std::abs(sum) >= std::abs(difference) ? sum : difference;
  const std::complex<double> other = one != 0.0 ? stiffness / one : one;
  return std::abs(one - lambda) < std::abs(other - lambda) ? one : other;
}

/// Returns the symmetric and the skew part of A. A skew part that is only rounding is set to zero.
std::pair<MatrixXd, MatrixXd> split(const MatrixXd& A) {
  MatrixXd skew = 0.5 * (A - A.transpose());
  if (skew.norm() <= 4.0 * eps * static_cast<double>(A.rows()) * A.norm()) skew.setZero();
  return {0.5 * (A + A.transpose()), std::move(skew)};
}

}  // namespace

void choose_phase(VectorXcd* shape) {
  const std::complex<double> square = shape->cwiseProduct(*shape).sum();
  if (std::abs(square) > 0.0) *shape *= std::sqrt(std::conj(square) / std::abs(square));
}

DampedModeSet find_damped_modes(const EquilibriumEquations& equations,
                                const Eigen::SparseMatrix<double>& damping_matrix, const MatrixXd& Z, double zero) {
  const Rows s = Z.cols();
  const MatrixXd stiffness = Z.transpose() * equations.stiffness().multiply(Z);
  const MatrixXd damping = Z.transpose() * (damping_matrix * Z);
  // With times in units of the fastest vibration both lower blocks of the companion matrix have similar size. If
  // nothing is stiff, the damping sets the unit.
  constexpr double little = 1e-8;
  const double rate =
      std::max({std::sqrt(stiffness.norm()), little * damping.norm(), std::numeric_limits<double>::min()});
  MatrixXd companion = MatrixXd::Zero(2 * s, 2 * s);
  companion.topRightCorner(s, s).setIdentity();
  companion.bottomLeftCorner(s, s) = -stiffness / (rate * rate);
  companion.bottomRightCorner(s, s) = -damping / rate;
  const dense::GeneralEigen eigen = dense::find_general_eigen(companion);
  const std::vector<Rows> chosen = choose(eigen.values, zero / rate);
  const auto [W, W_skew] = split(stiffness);
  const auto [D, D_skew] = split(damping);

  const auto count = static_cast<Rows>(chosen.size());
  DampedModeSet result{VectorXcd(count), MatrixXcd(Z.rows(), count)};
  for (Rows k = 0; k < count; ++k) {
    std::complex<double> lambda = rate * eigen.values[chosen[static_cast<std::size_t>(k)]];
    VectorXcd y = eigen.vectors.col(chosen[static_cast<std::size_t>(k)]).head(s);
    y /= y.norm();
    lambda = refine(lambda, work_of(D, D_skew, y), work_of(W, W_skew, y));
    if (std::abs(lambda.imag()) <= real_roots_to * rate) lambda = lambda.real();
    choose_phase(&y);
    const VectorXcd rest = lambda * lambda * y + lambda * (damping * y) + stiffness * y;
    result.residual = std::max(result.residual, rest.norm());
    result.lambda[k] = lambda;
    result.shapes.col(k) = Z * y;
  }
  const double largest = count > 0 ? result.lambda.cwiseAbs2().maxCoeff() : 0.0;
  result.residual /= std::max(largest, std::numeric_limits<double>::min());
  return result;
}

}  // namespace tanor::detail
