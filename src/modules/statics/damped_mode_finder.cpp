#include "statics/damped_mode_finder.hpp"

#include <Spectra/GenEigsSolver.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/dense.hpp"
#include "base/numbers.hpp"
#include "base/text.hpp"

namespace tanor::detail {

using Eigen::MatrixXd, Eigen::VectorXcd;
using Columns = Eigen::Index;

namespace {

constexpr double not_found = std::numeric_limits<double>::infinity();
/// Imaginary parts that rounding gives to equal real roots, relative to |lambda|.
constexpr double real_to = 1e-9;

}  // namespace

/// The operator (1 - V V') A (1 - V V'), whose eigenvalues are those of A except the ones of V.
class DampedModeFinder::Deflated {
 public:
  using Scalar = double;

  explicit Deflated(DampedModeFinder& finder) : finder_(finder) {}
  Columns rows() const { return 2 * finder_.root_mass_.size(); }
  Columns cols() const { return rows(); }
  void perform_op(const double* from, double* to) const {
    const MatrixXd& V = finder_.basis_;
    Eigen::Map<Vector> result(to, rows());
    Vector x = Eigen::Map<const Vector>(from, rows());
    x -= V * (V.transpose() * x);
    finder_.apply(x.data(), to);
    for (int twice = 0; twice < 2; ++twice) result -= V * (V.transpose() * result);
  }

 private:
  DampedModeFinder& finder_;
};

DampedModeFinder::DampedModeFinder(EquilibriumEquations& equations, Eigen::SparseMatrix<double> damping, double rate,
                                   double zero)
    : equations_(equations),
      damping_(std::move(damping)),
      kkt_(equations),
      root_mass_(static_cast<Columns>(equations.size())),
      rate_(rate),
      zero_(zero) {
  for (Columns i = 0; i < root_mass_.size(); ++i)
    root_mass_[i] = std::sqrt(equations.model().mass[static_cast<std::size_t>(i) / 3]);
}

bool DampedModeFinder::shift_to(double shift) {
  shift_ = shift;
  basis_.resize(2 * root_mass_.size(), 0);
  return kkt_.factorize(shift * shift, {&damping_, shift});
}

void DampedModeFinder::apply(const double* from, double* to) {
  const Columns n = root_mass_.size();
  const Vector q = Eigen::Map<const Vector>(from, n).cwiseQuotient(root_mass_),
               p = shift_ * Eigen::Map<const Vector>(from + n, n).cwiseQuotient(root_mass_);
  const Vector load = -(root_mass_.cwiseAbs2().cwiseProduct(p + shift_ * q) + damping_ * q);
  x_.assign(load.begin(), load.end());
  mu_.assign(equations_.num_rows(), 0.0);
  kkt_.solve(&x_, &mu_);
  const auto y = Eigen::Map<const Vector>(x_.data(), n);
  Eigen::Map<Vector>(to, n) = root_mass_.cwiseProduct(y);
  Eigen::Map<Vector>(to + n, n) = root_mass_.cwiseProduct(q + shift_ * y) / shift_;
}

void DampedModeFinder::add_to_basis(Vector v) {
  constexpr double dependent = 1e-8;
  v.normalize();
  for (int twice = 0; twice < 2; ++twice) v -= basis_ * (basis_.transpose() * v);
  if (v.norm() < dependent) return;
  basis_.conservativeResize(Eigen::NoChange, basis_.cols() + 1);
  basis_.rightCols(1) = v.normalized();
}

double DampedModeFinder::extend_basis(Columns wanted, double tolerance) {
  constexpr int most_restarts = 100;
  Deflated operation(*this);
  Vector start(operation.rows()), other(operation.rows());
  for (Columns i = 0; i < start.size(); ++i)
    start[i] =
        irregular(static_cast<std::size_t>(i + 7 * basis_.cols()), 2.3) / std::sqrt(1.0 + static_cast<double>(i));
  // After two applications the start vector breaks no constraint.
  operation.perform_op(start.data(), other.data());
  operation.perform_op(other.data(), start.data());
  if (!(start.norm() > 0.0)) return 0.0;
  start.normalize();
  Spectra::GenEigsSolver<Deflated> arnoldi(operation, wanted, std::min(operation.rows(), 3 * wanted + 10));
  arnoldi.init(start.data());
  arnoldi.compute(Spectra::SortRule::LargestMagn, most_restarts, tolerance);
  const VectorXcd theta = arnoldi.eigenvalues();
  if (theta.size() == 0) return not_found;
  const Eigen::MatrixXcd vectors = arnoldi.eigenvectors();
  double largest = 0.0;
  for (Columns k = 0; k < theta.size(); ++k) {
    largest = std::max(largest, std::abs(theta[k]));
    if (theta[k].imag() < 0.0) continue;
    add_to_basis(vectors.col(k).real());
    if (theta[k].imag() > 0.0) add_to_basis(vectors.col(k).imag());
  }
  return largest;
}

DampedModeSet DampedModeFinder::solve_on_basis() {
  MatrixXd image(basis_.rows(), basis_.cols());
  for (Columns k = 0; k < basis_.cols(); ++k) apply(basis_.col(k).data(), image.col(k).data());
  const dense::GeneralEigen eigen = dense::find_general_eigen(basis_.transpose() * image);
  std::vector<std::pair<std::complex<double>, Columns>> chosen;
  for (Columns k = 0; k < basis_.cols(); ++k) {
    std::complex<double> lambda = shift_ + 1.0 / eigen.values[k];
    if (std::abs(lambda.imag()) <= real_to * std::abs(lambda)) lambda = lambda.real();
    if (lambda.imag() >= 0.0 || std::abs(lambda) <= zero_) chosen.push_back({lambda, k});
  }
  std::ranges::stable_sort(chosen, {}, [](const auto& each) { return std::abs(each.first); });
  const Columns n = root_mass_.size(), count = static_cast<Columns>(chosen.size());
  DampedModeSet result{VectorXcd(count), Eigen::MatrixXcd(n, count)};
  for (Columns j = 0; j < count; ++j) {
    const auto& [lambda, k] = chosen[static_cast<std::size_t>(j)];
    VectorXcd q = basis_.topRows(n) * eigen.vectors.col(k);
    q /= q.norm();
    choose_phase(&q);
    result.lambda[j] = lambda;
    result.shapes.col(j) = q.cwiseQuotient(root_mass_);
  }
  return result;
}

/// Returns |M^-1/2 (lambda^2 M + lambda D + W) q + M^-1/2 K mu|. The multipliers mu come from one more solve, whose
/// solution is (q, lambda q)/(lambda - s).
double DampedModeFinder::find_residual(const std::complex<double>& lambda, const VectorXcd& q) {
  const Columns n = q.size();
  const VectorXcd mass_q = root_mass_.cwiseAbs2().cwiseProduct(q),
                  load = -(lambda * mass_q + (damping_ * q + shift_ * mass_q));
  VectorXcd rest = lambda * lambda * mass_q + lambda * (damping_ * q);
  const auto add = [&](const Vector& own, const Vector& own_load, const std::complex<double>& unit) {
    x_.assign(own_load.begin(), own_load.end());
    mu_.assign(equations_.num_rows(), 0.0);
    kkt_.solve(&x_, &mu_);
    std::vector<double> reactions(equations_.model().num_rows(), 0.0);
    std::copy(mu_.begin(), mu_.end(), reactions.begin());
    Vector sum(n), of_rows = Vector::Zero(n);
    equations_.stiffness().multiply(own.data(), sum.data());
    equations_.add_reactions(reactions.data(), of_rows.data());
    rest += unit * (sum.cast<std::complex<double>>() + (lambda - shift_) * of_rows.cast<std::complex<double>>());
  };
  add(q.real(), load.real(), 1.0);
  add(q.imag(), load.imag(), {0.0, 1.0});
  return rest.cwiseQuotient(root_mass_).norm();
}

DampedModeFinder::Found DampedModeFinder::find_lowest(std::size_t count, std::size_t freedoms) {
  constexpr int most_searches = 20;
  constexpr double beside = 0.1;  // shift, relative to the fastest wanted mode
  const auto wanted = static_cast<Columns>(count);
  Found found;
  const auto fail = [&](const std::string& what) {
    found.outcome = {Status::NotConverged, what};
    return found;
  };
  constexpr double rough = 1e-4, tolerance = 1e-11;
  const Columns first = std::min<Columns>(2 * wanted + 8, static_cast<Columns>(freedoms));
  constexpr const char* singular = "the matrix of damped modes has no factor near 0";
  double shift = 1e-3 * rate_;
  if (!shift_to(shift)) return fail(singular);
  (void)extend_basis(first, rough);
  if (const DampedModeSet near = solve_on_basis(); near.lambda.size() >= wanted)
    shift = std::max(beside * std::abs(near.lambda[wanted - 1]), 10.0 * zero_);
  if (!shift_to(shift)) return fail(singular);
  for (int search = 0; search < most_searches; ++search) {
    const Columns before = basis_.cols();
    const double largest = extend_basis(before == 0 ? first : std::max<Columns>(8, wanted / 2), tolerance);
    if (basis_.cols() == before && largest == not_found) return fail("Arnoldi's method finds no more damped modes");
    found.modes = solve_on_basis();
    if (found.modes.lambda.size() < wanted || before == 0) continue;
    // All modes within |lambda - s| <= farthest + s are among those of the basis.
    const double farthest = std::abs(found.modes.lambda[wanted - 1]),
                 outside = largest > 0.0 ? 1.0 / largest : std::numeric_limits<double>::infinity();
    if (!(outside > (1.0 + real_to) * (farthest + shift_))) continue;
    found.modes.lambda.conservativeResize(wanted);
    found.modes.shapes.conservativeResize(Eigen::NoChange, wanted);
    for (Columns k = 0; k < wanted; ++k)
      found.modes.residual =
          std::max(found.modes.residual, find_residual(found.modes.lambda[k], found.modes.shapes.col(k)));
    found.modes.residual /= std::max(farthest * farthest, zero_ * zero_);
    return found;
  }
  return fail("damped modes: after " + std::to_string(most_searches) +
              " searches there are still more in the circle of " + text(shift_) + " 1/s around those that are wanted");
}

DampedModeFinder::Found find_lowest_damped_modes(EquilibriumEquations& equations, Eigen::SparseMatrix<double> damping,
                                                 std::size_t count, std::size_t freedoms, double rate, double zero) {
  return DampedModeFinder(equations, std::move(damping), rate, zero).find_lowest(count, freedoms);
}

}  // namespace tanor::detail
