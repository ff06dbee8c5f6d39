/// QR by fronts has R'R = C'C and leaves out dependent columns.

#include "factor/sparse_qr.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/Dense>
#include <numeric>

#include "dense.hpp"
#include "patterns.hpp"

namespace tanor {
using namespace detail;
namespace {

using namespace patterns;
using Matrix = Eigen::MatrixXd;

Matrix dense(const SparseColumns& C) {
  Matrix result = Matrix::Zero(C.num_rows, static_cast<Eigen::Index>(C.num_columns()));
  for (std::size_t j = 0; j < C.num_columns(); ++j) {
    for (auto k = static_cast<std::size_t>(C.start[j]); k < static_cast<std::size_t>(C.start[j + 1]); ++k)
      result(C.rows[k], static_cast<Eigen::Index>(j)) += C.values[k];
  }
  return result;
}

/// Makes random columns of a few entries, some of them empty or sums of others.
SparseColumns make_columns(std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  const auto any_of = [&](int n) { return std::uniform_int_distribution<int>(0, n - 1)(generator); };
  const int m = 1 + any_of(60), d = any_of(50);
  Matrix A = Matrix::Zero(m, d);
  for (int j = 0; j < d; ++j) {
    for (int k = any_of(6); k > 0; --k) A(any_of(m), j) += normal(generator);
    if (j > 2 && any_of(5) == 0) A.col(j) = normal(generator) * A.col(any_of(j)) + normal(generator) * A.col(any_of(j));
    if (A.col(j).norm() > 0.0) A.col(j).normalize();
  }
  SparseColumns C;
  C.num_rows = m;
  for (int j = 0; j < d; ++j) {
    for (int i = 0; i < m; ++i) {
      if (A(i, j) == 0.0) continue;
      C.rows.push_back(i);
      C.values.push_back(A(i, j));
    }
    C.start.push_back(static_cast<int>(C.rows.size()));
  }
  return C;
}

void check_factor(const TriangularFactor& R, const SparseColumns& C) {
  std::vector<int> columns = R.independent;
  columns.insert(columns.end(), R.dependent.begin(), R.dependent.end());
  std::ranges::sort(columns);
  std::vector<int> all(C.num_columns());
  std::iota(all.begin(), all.end(), 0);
  RC_ASSERT(columns == all);
  RC_ASSERT(std::ranges::is_sorted(R.dependent));
  const Matrix upper = dense(R), chosen = dense(C)(Eigen::all, R.independent);
  for (std::size_t j = 0; j < R.rank(); ++j) {
    RC_ASSERT(R.rows[static_cast<std::size_t>(R.start[j + 1]) - 1] == static_cast<int>(j));
    RC_ASSERT(std::is_sorted(R.rows.begin() + R.start[j], R.rows.begin() + R.start[j + 1]));
  }
  if (R.rank() > 0) RC_ASSERT((upper.transpose() * upper - chosen.transpose() * chosen).cwiseAbs().maxCoeff() <= 1e-13);
}

RC_GTEST_PROP(MultifrontalQr, GivesTheFactorOfTheIndependentColumns, ()) {
  const SparseColumns C = make_columns(*rc::gen::arbitrary<std::uint32_t>());

  const TriangularFactor R = factorize_by_fronts(C, 1e-10);

  check_factor(R, C);
  if (C.rows.empty()) return;
  RC_ASSERT(static_cast<Eigen::Index>(R.rank()) == reference::rank_of(dense(C), 1e-9));
}

TEST(MultifrontalQr, FrontsOfEverySizeAreThoseOfDenseQr) {
  std::mt19937 generator(3);
  std::normal_distribution<double> normal;
  for (const int n : {1, 2, 3, 4, 5, 7, 8, 9, 16, 33, 70, 150}) {
    for (const int m : {n, n + 1, n + 9, 3 * n}) {
      SparseColumns C;
      C.num_rows = m;
      for (int j = 0; j < n; ++j) {
        for (int i = 0; i < m; ++i) {
          C.rows.push_back(i);
          C.values.push_back(normal(generator));
        }
        C.start.push_back(static_cast<int>(C.rows.size()));
      }

      const TriangularFactor R = factorize_by_fronts(C, 1e-12);

      ASSERT_EQ(R.rank(), static_cast<std::size_t>(n)) << m;
      const Matrix upper = dense(R), A = dense(C)(Eigen::all, R.independent);
      EXPECT_LE((upper.transpose() * upper - A.transpose() * A).cwiseAbs().maxCoeff(), 1e-13 * m) << n << " " << m;
    }
  }
}

TEST(MultifrontalQr, ANegativeToleranceKeepsWhateverIsNotZero) {
  SparseColumns C;
  C.num_rows = 2;
  C.rows = {0, 0, 1};
  C.values = {1.0, 1.0, 1e-200};
  C.start = {0, 1, 3, 3};

  const TriangularFactor R = factorize_by_fronts(C, -1.0);

  EXPECT_EQ(R.dependent.back(), 2) << "the empty one";
  EXPECT_EQ(factorize_by_fronts(SparseColumns{}, 1e-12).rank(), 0u);
}

TEST(MultifrontalQr, EndsOnNumbersThatAreNotFinite) {
  SparseColumns C = gradients_of(make_net(5, 5), 1);
  C.values[17] = NAN;
  C.values[40] = INFINITY;

  const TriangularFactor R = factorize_by_fronts(C, 1e-12);

  EXPECT_EQ(R.independent.size() + R.dependent.size(), C.num_columns());
}

RC_GTEST_PROP(MultifrontalQr, SolvesWithRAndItsTranspose, ()) {
  const SparseColumns C = gradients_of(make_net(6, 7), *rc::gen::arbitrary<std::uint32_t>());
  const TriangularFactor R = factorize_by_fronts(C, 1e-12);
  const auto d = static_cast<Eigen::Index>(R.rank());
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(d, -1.0, 2.0);

  Eigen::VectorXd x = b;
  R.solve_transposed(x.data());
  R.solve(x.data());

  const Matrix A = dense(C)(Eigen::all, R.independent);
  RC_ASSERT((A.transpose() * (A * x) - b).norm() <= 1e-13 * x.norm());
}

}  // namespace
}  // namespace tanor
