#include "statics/damped_modes.hpp"

#include <Spectra/GenEigsSolver.h>

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
#include "base/text.hpp"
#include "statics/deflated.hpp"
#include "statics/unsymmetric_kkt.hpp"

namespace tanor::detail {

using Rows = Eigen::Index;
using Eigen::MatrixXcd, Eigen::MatrixXd, Eigen::VectorXcd, Eigen::VectorXd;

namespace {

/// Imaginary parts that rounding gives to equal real roots, relative to the fastest rate, and of the sparse problem to
/// |lambda|.
constexpr double real_roots_to = 1e-10, real_to = 1e-9;

/// Chooses one lambda of each conjugate pair, the smallest |lambda| first; real ones have imaginary parts down to
/// -real. Both values of a pair within `zero` are kept, because rounding makes such a pair of the double root 0.
std::vector<Rows> choose(const VectorXcd& lambda, double zero, double real) {
  std::vector<Rows> chosen;
  for (Rows k = 0; k < lambda.size(); ++k) {
    if (lambda[k].imag() >= -real || std::abs(lambda[k]) <= zero) chosen.push_back(k);
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

/// Chooses the phase in which the real part is largest.
void choose_phase(VectorXcd* shape) {
  const std::complex<double> square = shape->cwiseProduct(*shape).sum();
  if (std::abs(square) > 0.0) *shape *= std::sqrt(std::conj(square) / std::abs(square));
}

}  // namespace

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
  const std::vector<Rows> chosen = choose(eigen.values, zero / rate, real_roots_to);
  const auto [W, W_skew] = split(stiffness);
  const auto [D, D_skew] = split(damping);

  const auto count = static_cast<Rows>(chosen.size());
  DampedModeSet result{{}, VectorXcd(count), MatrixXcd(Z.rows(), count)};
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

namespace {

/// Finds the lowest damped modes of many freedoms without a basis of all moves. With p = lambda q and a small shift s >
/// 0,
///
///   Q(s) y + K mu = -(M p + (D + s M) q),   K'y = 0,   Q(s) = W + s D + s^2 M,        y' = q + s y
///
/// maps (q, p) to (y, y') = (q, p)/(lambda - s), so that the largest eigenvalues of this operator belong to the lambda
/// nearest to s. Arnoldi's method with implicit restarts (Spectra) finds some. These are deflated, as Schur vectors,
/// until nothing more lies in the circle of the wanted ones, so that multiple eigenvalues are found with their
/// multiplicity.
class DampedModeFinder {
 public:
  DampedModeFinder(const EquilibriumEquations& equations, const Eigen::SparseMatrix<double>& D, double rate,
                   double zero)
      : equations_(equations),
        damping_(D),
        kkt_(equations),
        mass_(equations.masses()),
        root_mass_(mass_.cwiseSqrt()),
        rate_(rate),
        zero_(zero) {}

  DampedModeSet find_lowest(Rows wanted, Rows freedoms) {
    constexpr int most_searches = 20;
    constexpr double beside = 0.1;  // shift, relative to the fastest wanted mode
    constexpr double rough = 1e-4, tolerance = 1e-11;
    const Rows first = std::min(2 * wanted + 8, freedoms);
    const auto fail = [](std::string what) { return DampedModeSet{{Status::NotConverged, std::move(what)}, {}, {}}; };
    constexpr const char* singular = "the matrix of damped modes has no factor near 0";
    double shift = 1e-3 * rate_;
    if (!shift_to(shift)) return fail(singular);
    (void)extend_basis(first, rough);
    if (const DampedModeSet near = solve_on_basis(); near.lambda.size() >= wanted)
      shift = std::max(beside * std::abs(near.lambda[wanted - 1]), 10.0 * zero_);
    if (!shift_to(shift)) return fail(singular);
    for (int search = 0; search < most_searches; ++search) {
      const Rows before = basis_.cols();
      const double largest = extend_basis(before == 0 ? first : std::max<Rows>(8, wanted / 2), tolerance);
      if (basis_.cols() == before && largest == not_found) return fail("Arnoldi's method finds no more damped modes");
      DampedModeSet found = solve_on_basis();
      if (found.lambda.size() < wanted || before == 0) continue;
      // All modes within |lambda - s| <= farthest + s are among those of the basis.
      const double farthest = std::abs(found.lambda[wanted - 1]), outside = largest > 0.0 ? 1.0 / largest : not_found;
      if (!(outside > (1.0 + real_to) * (farthest + shift_))) continue;
      found.lambda.conservativeResize(wanted);
      found.shapes.conservativeResize(Eigen::NoChange, wanted);
      for (Rows k = 0; k < wanted; ++k)
        found.residual = std::max(found.residual, find_residual(found.lambda[k], found.shapes.col(k)));
      found.residual /= std::max(farthest * farthest, zero_ * zero_);
      return found;
    }
    return fail("damped modes: after " + std::to_string(most_searches) +
                " searches there are still more in the circle of " + text(shift_) + " around those that are wanted");
  }

 private:
  static constexpr double not_found = std::numeric_limits<double>::infinity();

  [[nodiscard]] bool shift_to(double shift) {
    shift_ = shift;
    basis_.resize(2 * mass_.size(), 0);
    return kkt_.factorize(shift * shift, {&damping_, shift});
  }

  /// Applies the operator to [q; p], with q and p in units of M^-1/2 and p divided by the shift.
  void apply(const double* from, double* to) {
    const Rows n = mass_.size();
    const VectorXd q = Eigen::Map<const VectorXd>(from, n).cwiseQuotient(root_mass_),
                   p = shift_ * Eigen::Map<const VectorXd>(from + n, n).cwiseQuotient(root_mass_);
    const VectorXd load = -(mass_.cwiseProduct(p + shift_ * q) + damping_ * q);
    solve(load);
    const auto y = Eigen::Map<const VectorXd>(x_.data(), n);
    Eigen::Map<VectorXd>(to, n) = root_mass_.cwiseProduct(y);
    Eigen::Map<VectorXd>(to + n, n) = root_mass_.cwiseProduct(q + shift_ * y) / shift_;
  }
  void solve(const VectorXd& load) {
    x_.assign(load.begin(), load.end());
    mu_.assign(equations_.num_rows(), 0.0);
    kkt_.solve(&x_, &mu_);
  }

  /// Adds Schur vectors of more eigenvalues to `basis_`. Returns the largest |theta| of them, or infinity if none
  /// converged.
  double extend_basis(Rows wanted, double tolerance) {
    constexpr int most_restarts = 100;
    Deflated operation(basis_, [this](const double* from, double* to) { apply(from, to); });
    VectorXd start(operation.rows()), other(operation.rows());
    for (Rows i = 0; i < start.size(); ++i)
      start[i] =
          irregular(static_cast<std::size_t>(i + 7 * basis_.cols()), 2.3) / std::sqrt(1.0 + static_cast<double>(i));
    // After two applications the start vector breaks no constraint.
    operation.perform_op(start.data(), other.data());
    operation.perform_op(other.data(), start.data());
    if (!(start.norm() > 0.0)) return 0.0;
    start.normalize();
    Spectra::GenEigsSolver arnoldi(operation, wanted, std::min(operation.rows(), 3 * wanted + 10));
    arnoldi.init(start.data());
    arnoldi.compute(Spectra::SortRule::LargestMagn, most_restarts, tolerance);
    const VectorXcd theta = arnoldi.eigenvalues();
    if (theta.size() == 0) return not_found;
    const MatrixXcd vectors = arnoldi.eigenvectors();
    double largest = 0.0;
    for (Rows k = 0; k < theta.size(); ++k) {
      largest = std::max(largest, std::abs(theta[k]));
      if (theta[k].imag() < 0.0) continue;
      add_to_basis(vectors.col(k).real());
      if (theta[k].imag() > 0.0) add_to_basis(vectors.col(k).imag());
    }
    return largest;
  }

  void add_to_basis(VectorXd v) {
    constexpr double dependent = 1e-8;
    v.normalize();
    for (int twice = 0; twice < 2; ++twice) v -= basis_ * (basis_.transpose() * v);
    if (v.norm() < dependent) return;
    basis_.conservativeResize(Eigen::NoChange, basis_.cols() + 1);
    basis_.rightCols(1) = v.normalized();
  }

  /// Returns the damped modes within the span of the basis, the smallest |lambda| first, one of each pair.
  DampedModeSet solve_on_basis() {
    MatrixXd image(basis_.rows(), basis_.cols());
    for (Rows k = 0; k < basis_.cols(); ++k) apply(basis_.col(k).data(), image.col(k).data());
    const dense::GeneralEigen eigen = dense::find_general_eigen(basis_.transpose() * image);
    VectorXcd lambda = eigen.values.cwiseInverse().array() + std::complex<double>(shift_);
    for (std::complex<double>& each : lambda)
      if (std::abs(each.imag()) <= real_to * std::abs(each)) each = each.real();
    const std::vector<Rows> chosen = choose(lambda, zero_, 0.0);
    const Rows n = mass_.size(), count = static_cast<Rows>(chosen.size());
    DampedModeSet result{{}, lambda(chosen), MatrixXcd(n, count)};
    for (Rows j = 0; j < count; ++j) {
      VectorXcd q = basis_.topRows(n) * eigen.vectors.col(chosen[static_cast<std::size_t>(j)]);
      q /= q.norm();
      choose_phase(&q);
      result.shapes.col(j) = q.cwiseQuotient(root_mass_);
    }
    return result;
  }

  /// Returns |M^-1/2 (lambda^2 M + lambda D + W) q + M^-1/2 K mu|. The multipliers mu come from one more solve, whose
  /// solution is (q, lambda q)/(lambda - s).
  double find_residual(const std::complex<double>& lambda, const VectorXcd& q) {
    const VectorXcd mass_q = mass_.cwiseProduct(q), load = -(lambda * mass_q + (damping_ * q + shift_ * mass_q));
    VectorXcd rest = lambda * lambda * mass_q + lambda * (damping_ * q);
    const auto add = [&](const VectorXd& own, const VectorXd& own_load, const std::complex<double>& unit) {
      solve(own_load);
      std::vector<double> reactions(equations_.model().num_rows(), 0.0);
      std::copy(mu_.begin(), mu_.end(), reactions.begin());
      VectorXd sum(q.size()), of_rows = VectorXd::Zero(q.size());
      equations_.stiffness().multiply(own.data(), sum.data());
      equations_.add_reactions(reactions.data(), of_rows.data());
      rest += unit * (sum.cast<std::complex<double>>() + (lambda - shift_) * of_rows.cast<std::complex<double>>());
    };
    add(q.real(), load.real(), 1.0);
    add(q.imag(), load.imag(), {0.0, 1.0});
    return rest.cwiseQuotient(root_mass_).norm();
  }

  const EquilibriumEquations& equations_;
  const Eigen::SparseMatrix<double>& damping_;
  UnsymmetricKkt kkt_;
  VectorXd mass_, root_mass_;  // [3n]
  const double rate_, zero_;
  double shift_ = 0.0;
  MatrixXd basis_;  // orthonormal
  std::vector<double> x_, mu_;
};

}  // namespace

DampedModeSet find_lowest_damped_modes(const EquilibriumEquations& equations, const Eigen::SparseMatrix<double>& D,
                                       std::size_t count, std::size_t freedoms, double rate, double zero) {
  return DampedModeFinder(equations, D, rate, zero).find_lowest(static_cast<Rows>(count), static_cast<Rows>(freedoms));
}

}  // namespace tanor::detail
