#include "factor/incomplete_cholesky.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "base/parallel.hpp"
#include "dense.hpp"

namespace tanor {
using namespace detail;
namespace {

/// Makes a factor of the upper triangle of a dense symmetric matrix on its nonzeros and its diagonal.
IncompleteCholesky make_factor(const Eigen::MatrixXd& S) {
  TrianglePattern upper;
  std::vector<double> values;
  for (int j = 0; j < S.cols(); ++j) {
    for (int i = 0; i <= j; ++i) {
      if (i != j && S(i, j) == 0.0) continue;
      upper.rows.push_back(i);
      values.push_back(S(i, j));
    }
    upper.start.push_back(static_cast<int>(upper.rows.size()));
  }
  IncompleteCholesky factor(std::move(upper));
  std::copy(values.begin(), values.end(), factor.values());
  return factor;
}

/// Returns P^-1 as a matrix, column by column.
Eigen::MatrixXd inverse_of(const IncompleteCholesky& factor, const Eigen::VectorXd& scale) {
  const Eigen::Index n = scale.size();
  Eigen::MatrixXd result(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const Eigen::VectorXd b = Eigen::VectorXd::Unit(n, j);
    factor.solve_negative(scale.data(), b.data(), result.col(j).data());
  }
  return -result;
}

/// Makes S of a chain of rods, with 1 on the diagonal and cosines of angles over 2 next to it.
Eigen::MatrixXd make_chain(int size) {
  Eigen::MatrixXd S = Eigen::MatrixXd::Identity(size, size);
  for (int i = 0; i + 1 < size; ++i) S(i, i + 1) = S(i + 1, i) = -0.5 * std::cos(0.3 * i);
  return S;
}

/// Makes S of a ring with rods across it, whose elimination has fill.
Eigen::MatrixXd make_net_matrix(int size) {
  Eigen::MatrixXd S = make_chain(size);
  for (int i = 0; i + 5 < size; ++i) S(i, i + 5) = S(i + 5, i) = 0.1 * std::sin(1.0 + i);
  S(0, size - 1) = S(size - 1, 0) = 0.2;
  return S;
}

/// Makes random entries, so many that rows share neighbours and elimination updates numbers inside the pattern.
Eigen::MatrixXd make_meshed(int size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> entry(-1.0, 1.0);
  Eigen::MatrixXd S = Eigen::MatrixXd::Identity(size, size);
  for (int i = 0; i < size; ++i) {
    for (int j = 0; j < i; ++j) {
      if (std::abs(entry(random)) < 0.3) S(i, j) = S(j, i) = 0.25 * entry(random);
    }
  }
  return S;
}

TEST(IncompleteCholeskyTest, IsExactAlongAChain) {
  const Eigen::MatrixXd S = make_chain(12);
  IncompleteCholesky factor = make_factor(S);

  ASSERT_TRUE(factor.factorize());

  const Eigen::MatrixXd product = inverse_of(factor, Eigen::VectorXd::Ones(12)) * S;
  EXPECT_LT((product - Eigen::MatrixXd::Identity(12, 12)).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(IncompleteCholeskyTest, TakesTheScaleOfRowsAlong) {
  const Eigen::MatrixXd S = make_chain(12);
  const Eigen::VectorXd scale = Eigen::VectorXd::LinSpaced(12, 0.5, 3.0);
  IncompleteCholesky factor = make_factor(S);
  ASSERT_TRUE(factor.factorize());

  // S = D^-1 (scaled S) D^-1
  const Eigen::MatrixXd unscaled = scale.cwiseInverse().asDiagonal() * S * scale.cwiseInverse().asDiagonal();

  const Eigen::MatrixXd product = inverse_of(factor, scale) * unscaled;
  EXPECT_LT((product - Eigen::MatrixXd::Identity(12, 12)).cwiseAbs().maxCoeff(), 1e-12);
}

/// Expects P = U'DU = S on the pattern of S, which defines P, and that P is symmetric and positive definite.
void expect_agreement_on_the_pattern(const Eigen::MatrixXd& S) {
  IncompleteCholesky factor = make_factor(S);

  ASSERT_TRUE(factor.factorize());

  const Eigen::MatrixXd inverse = inverse_of(factor, Eigen::VectorXd::Ones(S.rows())), P = inverse.inverse();
  EXPECT_LT((inverse - inverse.transpose()).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_GT(reference::eigenvalues(inverse).minCoeff(), 0.0);
  double on_pattern = 0.0, beside = 0.0;
  for (int i = 0; i < S.rows(); ++i) {
    for (int j = 0; j < S.cols(); ++j) {
      double& largest = S(i, j) != 0.0 ? on_pattern : beside;
      largest = larger(largest, std::abs(P(i, j) - S(i, j)));
    }
  }
  EXPECT_LT(on_pattern, 1e-13);
  EXPECT_GT(beside, 1e-3) << "the fill was kept";
}

TEST(IncompleteCholeskyTest, AgreesWithTheMatrixOnItsPattern) {
  expect_agreement_on_the_pattern(make_net_matrix(20));
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const Eigen::MatrixXd S = make_meshed(12, seed);
    if (reference::eigenvalues(S).minCoeff() > 0.2) expect_agreement_on_the_pattern(S);
  }
}

/// Makes a sheet of triangles, whose rows share neighbours, so that elimination changes entries inside the pattern.
Eigen::MatrixXd make_sheet(int side) {
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(side * side, side * side);
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const int own = side * i + j;
      S(own, own) = 6.0 + 1e-3;
      const auto join = [&](int other) { S(own, other) = S(other, own) = -1.0; };
      if (j + 1 < side) join(own + 1);
      if (i + 1 < side) join(own + side);
      if (i + 1 < side && j + 1 < side) join(own + side + 1);
    }
  }
  return S;
}

/// Counts the iterations of conjugate gradients for S x = 1 until sqrt(rho'P^-1 rho) has fallen by 1e-10.
int count_iterations(const Eigen::MatrixXd& S, const Eigen::MatrixXd& inverse_of_P) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(S.rows()), rho = Eigen::VectorXd::Ones(S.rows()), p = inverse_of_P * rho;
  const double first = rho.dot(p);
  double now = first;
  int count = 0;
  for (; now > 1e-20 * first; ++count) {
    const double length = now / p.dot(S * p);
    x += length * p;
    rho -= length * (S * p);
    const Eigen::VectorXd z = inverse_of_P * rho;
    const double next = rho.dot(z);
    p = z + next / now * p;
    now = next;
  }
  return count;
}

/// Without the factor there are 53 iterations. Entries that are updated by a tenth too little make it 21.
TEST(IncompleteCholeskyTest, TakesTwentyIterationsOnAKnownSheet) {
  const Eigen::MatrixXd S = make_sheet(24);
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(S.rows());
  IncompleteCholesky factor = make_factor(S);
  ASSERT_TRUE(factor.factorize());

  EXPECT_LE(count_iterations(S, inverse_of(factor, ones)), 20);
  EXPECT_GE(count_iterations(S, Eigen::MatrixXd::Identity(S.rows(), S.cols())), 50);
}

/// The matrix is positive definite, but not without its fill (D. S. Kershaw 1978).
TEST(IncompleteCholeskyTest, RaisesTheDiagonalWherePivotsFail) {
  Eigen::MatrixXd S(4, 4);
  S << 3, -2, 0, 2, -2, 3, -2, 0, 0, -2, 3, -2, 2, 0, -2, 3;
  ASSERT_GT(reference::eigenvalues(S).minCoeff(), 0.0);
  IncompleteCholesky factor = make_factor(S);

  ASSERT_TRUE(factor.factorize());

  const Eigen::MatrixXd inverse = inverse_of(factor, Eigen::VectorXd::Ones(4));
  EXPECT_GT(reference::eigenvalues(inverse).minCoeff(), 0.0);
}

TEST(IncompleteCholeskyTest, FailsOnNegativeDiagonalsAndNan) {
  Eigen::MatrixXd S = make_chain(3);
  S(1, 1) = -1.0;
  EXPECT_FALSE(make_factor(S).factorize());
  S(1, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(make_factor(S).factorize());
}

}  // namespace
}  // namespace tanor
