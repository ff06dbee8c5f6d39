#include "statics/stability.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "statics/rigid_modes.hpp"

namespace tanor {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t most_dense = 300;

double mass_of(const Model& model, std::size_t coordinate) {
  return model.mass[coordinate / 3];
}

/// Bound of the largest omega^2 of W, by rows of M^-1/2 W M^-1/2.
double largest_frequency2(const EquilibriumEquations& equations) {
  const StiffnessMatrix& W = equations.stiffness();
  const Model& model = equations.model();
  double result = 0.0;
  for (std::size_t i = 0; i < W.num_points(); ++i) {
    std::array<double, 3> sums{};
    for (int k = W.start()[i]; k < W.start()[i + 1]; ++k) {
      const auto block = static_cast<std::size_t>(k);
      const double scale = std::sqrt(model.mass[i] * model.mass[static_cast<std::size_t>(W.columns()[block])]);
      for (std::size_t entry = 0; entry < 9; ++entry)
        sums[entry / 3] += std::abs(W.blocks()[block].entries[entry]) / scale;
    }
    for (const double sum : sums) result = std::max(result, sum);
  }
  return result;
}

double zero_tolerance(const EquilibriumEquations& equations, double largest) {
  constexpr double usual = 1e-9, least = 1e-13, short_chain = 100.0;
  const double points = std::max(1.0, static_cast<double>(equations.size()) / 3.0);
  return largest * std::max(least, usual * std::min(1.0, std::pow(short_chain / points, 2)));
}

// ---- dense ----

ReducedInertia find_dense(const EquilibriumEquations& equations) {
  const Model& model = equations.model();
  const auto n = static_cast<Index>(equations.size()), d = static_cast<Index>(equations.num_rows());
  MatrixXd W = MatrixXd::Zero(n, n), K = MatrixXd::Zero(n, d);
  const StiffnessMatrix& blocks = equations.stiffness();
  VectorXd root(n);
  for (Index i = 0; i < n; ++i) root[i] = 1.0 / std::sqrt(mass_of(model, static_cast<std::size_t>(i)));
  for (std::size_t i = 0; i < blocks.num_points(); ++i) {
    for (int k = blocks.start()[i]; k < blocks.start()[i + 1]; ++k) {
      const auto j = static_cast<std::size_t>(blocks.columns()[static_cast<std::size_t>(k)]);
      for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
          W(static_cast<Index>(3 * i) + row, static_cast<Index>(3 * j) + column) =
              blocks.blocks()[static_cast<std::size_t>(k)](row, column);
      }
    }
  }
  for (const Incidence& incidence : model.incidences) {
    if (incidence.row >= d || 3 * incidence.point >= n) continue;
    const Vec3 g = incidence.sign * load(equations.gradients().data(), incidence.block);
    K.block<3, 1>(3 * incidence.point, incidence.row) += Eigen::Vector3d(g.x, g.y, g.z);
  }
  // Unit columns of M^-1/2 K: their rank and what is orthogonal to them.
  MatrixXd scaled = root.asDiagonal() * K;
  for (Index a = 0; a < d; ++a) scaled.col(a) /= std::max(scaled.col(a).norm(), 1e-300);
  Eigen::ColPivHouseholderQR<MatrixXd> qr(scaled);
  qr.setThreshold(1e-10);
  const Index free = n - (d > 0 ? qr.rank() : 0);
  ReducedInertia result;
  if (free == 0) return result;
  MatrixXd Z = MatrixXd::Identity(n, n);
  if (d > 0) Z.applyOnTheLeft(qr.householderQ());
  const MatrixXd basis = root.asDiagonal() * Z.rightCols(free);
  const MatrixXd reduced = 0.5 * basis.transpose() * (W + W.transpose()) * basis;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(reduced);
  const VectorXd& omega2 = eigen.eigenvalues();
  const double zero =
      zero_tolerance(equations, std::max(omega2.cwiseAbs().maxCoeff(), 1e-3 * largest_frequency2(equations)));
  for (Index k = 0; k < free; ++k) {
    if (std::abs(omega2[k]) <= zero) {
      ++result.zero;
      continue;
    }
    if (omega2[k] < 0.0) ++result.negative;
    if (!result.shape.empty()) continue;
    result.lowest = omega2[k];
    const VectorXd shape = basis * eigen.eigenvectors().col(k);
    result.shape.assign(shape.data(), shape.data() + n);
  }
  return result;
}

// ---- sparse ----

double mass_product(const Model& model, const VectorXd& a, const VectorXd& b) {
  double sum = 0.0;
  for (Index i = 0; i < a.size(); ++i) sum += mass_of(model, static_cast<std::size_t>(i)) * a[i] * b[i];
  return sum;
}

/// Lanczos' method on (W + s M)^-1 M within K'q = 0, with the factor that stands: the lowest omega^2 beyond `zero`.
void find_lowest(const EquilibriumEquations& equations, double shift, double zero, KktSolver* solver,
                 ReducedInertia* result) {
  constexpr int most_steps = 100;
  constexpr double enough = 1e-10, at_least = 1e-3;  // residuals over the eigenvalue
  const Model& model = equations.model();
  const auto n = static_cast<Index>(equations.size());
  std::vector<VectorXd> basis;
  std::vector<double> alpha, beta;
  std::vector<double> rows(model.num_rows(), 0.0);
  const auto apply = [&](const VectorXd& q) {
    VectorXd x(n);
    for (Index i = 0; i < n; ++i) x[i] = mass_of(model, static_cast<std::size_t>(i)) * q[i];
    std::fill(rows.begin(), rows.end(), 0.0);
    (void)solver->solve(x.data(), rows.data(), 2);
    return x;
  };
  VectorXd start(n);
  for (Index i = 0; i < n; ++i)
    start[i] = std::sin(1.0 + 0.7 * static_cast<double>(i) + 1e-3 * static_cast<double>(i * i % 997));
  start = apply(start);
  basis.push_back(start / std::sqrt(mass_product(model, start, start)));
  for (int step = 0; step < most_steps; ++step) {
    VectorXd next = apply(basis.back());
    alpha.push_back(mass_product(model, next, basis.back()));
    for (int round = 0; round < 2; ++round) {
      for (const VectorXd& q : basis) next -= mass_product(model, next, q) * q;
    }
    const double length = std::sqrt(std::max(0.0, mass_product(model, next, next)));
    const auto size = static_cast<Index>(alpha.size());
    MatrixXd T = MatrixXd::Zero(size, size);
    for (Index k = 0; k < size; ++k) {
      T(k, k) = alpha[static_cast<std::size_t>(k)];
      if (k > 0) T(k, k - 1) = T(k - 1, k) = beta[static_cast<std::size_t>(k) - 1];
    }
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(T);
    Index chosen = size - 1;
    while (chosen > 0 && std::abs(1.0 / eigen.eigenvalues()[chosen] - shift) <= zero) --chosen;
    const double theta = eigen.eigenvalues()[chosen];
    const double residual = length * std::abs(eigen.eigenvectors()(size - 1, chosen));
    const bool is_found = residual < enough * theta || length < 1e-14 * eigen.eigenvalues()[size - 1] ||
                          (step + 1 == most_steps && residual < at_least * theta);
    if (is_found) {
      VectorXd shape = VectorXd::Zero(n);
      for (Index k = 0; k < size; ++k) shape += eigen.eigenvectors()(k, chosen) * basis[static_cast<std::size_t>(k)];
      shape /= std::sqrt(mass_product(model, shape, shape));
      result->lowest = 1.0 / theta - shift;
      result->shape.assign(shape.data(), shape.data() + n);
      return;
    }
    beta.push_back(length);
    basis.push_back(next / length);
  }
}

/// Where a pivot vanishes a bound nearby is asked for.
std::optional<std::size_t> count_near(double omega2, KktSolver* solver) {
  for (const double factor : {1.0, 1.3, 0.7, 2.0}) {
    if (const auto count = solver->count_below(factor * omega2)) return count;
  }
  return std::nullopt;
}

ReducedInertia find_sparse(const EquilibriumEquations& equations, bool can_move, KktSolver* solver) {
  ReducedInertia result;
  if (!can_move) return result;
  const double largest = largest_frequency2(equations), zero = zero_tolerance(equations, largest);
  if (!solver->factorize(-zero)) {
    const auto below = count_near(-zero, solver), up_to = count_near(zero, solver);
    result.is_known = below && up_to && *up_to >= *below;
    if (!result.is_known) return result;
    result.negative = *below;
    result.zero = *up_to - *below;
    for (double shift = zero; shift < 1e4 * largest; shift *= 10.0) {
      if (!solver->factorize(shift)) continue;
      find_lowest(equations, shift, zero, solver, &result);
      break;
    }
  } else {
    find_lowest(equations, -zero, zero, solver, &result);
  }
  return result;
}

}  // namespace

ReducedInertia find_inertia(const EquilibriumEquations& equations, const std::vector<double>& r, bool can_move,
                            KktSolver* solver) {
  if (equations.size() == 0) return {};
  ReducedInertia result =
      equations.size() <= most_dense ? find_dense(equations) : find_sparse(equations, can_move, solver);
  if (result.zero > 0) result.rigid_zero = std::min(result.zero, count_rigid_modes(equations, r));
  return result;
}

}  // namespace tanor
