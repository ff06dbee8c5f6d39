#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "dense.hpp"
#include "random_systems.hpp"
#include "statics/kkt_solver.hpp"

namespace tanor {
using namespace detail;
namespace {

/// A random system at rest with its inner arrays, and numbers that stand for multipliers.
struct StiffnessAtRest {
  explicit StiffnessAtRest(const RandomSystem& random)
      : work(random.system, {.threads = 1}, random.t),
        equations(work, random.t),
        r(random.positions.size()),
        lambda(work.model().num_rows()),
        g(equations.size()),
        xi(lambda.size()) {
    work.model().numbering.gather_points(random.positions, r);
    for (std::size_t a = 0; a < lambda.size(); ++a) lambda[a] = std::sin(1.0 + 3.0 * static_cast<double>(a));
  }

  Workspace work;
  EquilibriumEquations equations;
  std::vector<double> r, lambda, g, xi;
};

RandomSystem any_at_rest() {
  RandomSystem random = any_system();
  random.system.friction.clear();
  return random;
}

Eigen::VectorXd multiply(const StiffnessMatrix& W, const Eigen::VectorXd& x) {
  Eigen::VectorXd y(x.size());
  W.multiply(x.data(), y.data());
  return y;
}

RC_GTEST_PROP(Stiffness, IsTheDerivativeOfForcesAndReactions, ()) {
  StiffnessAtRest rest(any_at_rest());
  RC_PRE(rest.equations.size() > 0);
  rest.equations.linearise(rest.r.data(), rest.lambda.data());
  Eigen::VectorXd x(static_cast<Eigen::Index>(rest.equations.size()));
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = std::cos(2.0 * static_cast<double>(i));

  // The derivatives of g are differences of fourth order.
  constexpr double h = 1e-3;
  Eigen::VectorXd difference = Eigen::VectorXd::Zero(x.size());
  double scale = 0.0;
  for (const auto& [step, weight] : {std::pair{1.0, 8.0}, {-1.0, -8.0}, {2.0, -1.0}, {-2.0, 1.0}}) {
    std::vector<double> r = rest.r;
    for (Eigen::Index i = 0; i < x.size(); ++i) r[static_cast<std::size_t>(i)] += step * h * x[i];
    scale = std::max(scale, rest.equations.evaluate(r.data(), rest.lambda.data(), rest.g.data(), rest.xi.data()));
    difference += weight / (12.0 * h) * Eigen::Map<const Eigen::VectorXd>(rest.g.data(), x.size());
  }

  const Eigen::VectorXd expected = multiply(rest.equations.stiffness(), x);
  const double size = std::max(1.0, expected.cwiseAbs().maxCoeff());
  RC_ASSERT((difference + expected).cwiseAbs().maxCoeff() < 1e-6 * size + 1e-9 * scale);
}

RC_GTEST_PROP(Kkt, SolvesWhatTheDenseMatrixSolves, ()) {
  StiffnessAtRest rest(any_at_rest());
  RC_PRE(rest.equations.size() > 0);
  rest.equations.linearise(rest.r.data(), rest.lambda.data());
  const auto n = static_cast<Eigen::Index>(rest.equations.size());
  const auto d = static_cast<Eigen::Index>(rest.equations.num_rows());
  Eigen::MatrixXd W(n, n), K = Eigen::MatrixXd::Zero(n, d), M = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    W.col(i) = multiply(rest.equations.stiffness(), Eigen::VectorXd::Unit(n, i));
    M(i, i) = rest.equations.model().mass[static_cast<std::size_t>(i) / 3];
  }
  RC_PRE((W - W.transpose()).cwiseAbs().maxCoeff() < 1e-12 * std::max(1e-300, W.cwiseAbs().maxCoeff()));
  for (Eigen::Index a = 0; a < d; ++a) {
    std::vector<double> unit(rest.lambda.size()), column(rest.equations.size());
    unit[static_cast<std::size_t>(a)] = 1.0;
    rest.equations.add_reactions(unit.data(), column.data());
    K.col(a) = Eigen::Map<const Eigen::VectorXd>(column.data(), n);
  }
  const double shift = 2.0 * W.cwiseAbs().rowwise().sum().maxCoeff() / M.diagonal().minCoeff() + 1.0;
  Eigen::MatrixXd kkt = Eigen::MatrixXd::Zero(n + d, n + d);
  kkt << W + shift * M, K, K.transpose(), Eigen::MatrixXd::Zero(d, d);
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(n + d, -1.0, 2.0);
  const Eigen::VectorXd expected = reference::solve_full(kkt, b);

  KktSolver solver(rest.equations);
  RC_ASSERT(solver.factorize(shift));
  std::vector<double> x(b.data(), b.data() + n), y(rest.lambda.size());
  std::copy(b.data() + n, b.data() + n + d, y.begin());
  (void)solver.solve(x.data(), y.data());

  const Eigen::VectorXd sigma = reference::singular_values(kkt);
  const double cond = sigma(0) / sigma(n + d - 1);
  const double allowed = 1e-14 * cond * expected.cwiseAbs().maxCoeff();
  RC_ASSERT((Eigen::Map<Eigen::VectorXd>(x.data(), n) - expected.head(n)).cwiseAbs().maxCoeff() < allowed);
  RC_ASSERT((Eigen::Map<Eigen::VectorXd>(y.data(), d) - expected.tail(d)).cwiseAbs().maxCoeff() < allowed);
}

RC_GTEST_PROP(Kkt, CountsFrequenciesAsTheDenseMatrixDoes, ()) {
  StiffnessAtRest rest(any_at_rest());
  RC_PRE(rest.equations.size() > rest.equations.num_rows());
  rest.equations.linearise(rest.r.data(), rest.lambda.data());
  const auto n = static_cast<Eigen::Index>(rest.equations.size());
  const auto d = static_cast<Eigen::Index>(rest.equations.num_rows());
  Eigen::MatrixXd W(n, n), K = Eigen::MatrixXd::Zero(n, d);
  Eigen::VectorXd root(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    W.col(i) = multiply(rest.equations.stiffness(), Eigen::VectorXd::Unit(n, i));
    root[i] = 1.0 / std::sqrt(rest.equations.model().mass[static_cast<std::size_t>(i) / 3]);
  }
  RC_PRE((W - W.transpose()).cwiseAbs().maxCoeff() < 1e-12 * std::max(1e-300, W.cwiseAbs().maxCoeff()));
  for (Eigen::Index a = 0; a < d; ++a) {
    std::vector<double> unit(rest.lambda.size()), column(rest.equations.size());
    unit[static_cast<std::size_t>(a)] = 1.0;
    rest.equations.add_reactions(unit.data(), column.data());
    K.col(a) = Eigen::Map<const Eigen::VectorXd>(column.data(), n);
  }
  const Eigen::MatrixXd scaled = root.asDiagonal() * K;
  const Eigen::MatrixXd Z = reference::orthonormal_basis(scaled).rightCols(n - d);
  const Eigen::VectorXd omega2 = reference::eigenvalues(Z.transpose() * root.asDiagonal() * W * root.asDiagonal() * Z);
  KktSolver solver(rest.equations);
  const double size = std::max(1e-3, omega2.cwiseAbs().maxCoeff());
  for (const double part : {-0.4, -0.01, 0.013, 0.3}) {
    const double at = part * size;
    if ((omega2.array() - at).abs().minCoeff() < 1e-6 * size) continue;
    const auto below = static_cast<std::size_t>((omega2.array() < at).count());
    constexpr double stiffer = 100.0;
    RC_ASSERT(solver.count_below(at, stiffer) == below);
    RC_ASSERT(solver.factorize(-at) == (below == 0));
  }
}

}  // namespace
}  // namespace tanor
