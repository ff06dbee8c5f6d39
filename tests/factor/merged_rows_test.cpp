/// QR by merged rows: its R is that of SuiteSparseQR's C'C, and it leaves out the columns that depend.

#include "factor/merged_rows.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

namespace tanor {
namespace {

/// Column k joins the three rows of point parent[k] and of point k + 1: a tree of rods, leaves last.
SparseColumns make_tree(const std::vector<int>& parent, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  SparseColumns C;
  C.num_rows = 3 * static_cast<int>(parent.size() + 1);
  // Leaves first: no fill.
  for (std::size_t k = parent.size(); k-- > 0;) {
    for (const int point : {parent[k], static_cast<int>(k) + 1}) {
      for (int c = 0; c < 3; ++c) {
        C.rows.push_back(3 * point + c);
        C.values.push_back(normal(generator));
      }
    }
    C.start.push_back(static_cast<int>(C.rows.size()));
  }
  return C;
}

Eigen::MatrixXd dense(const SparseColumns& C) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(C.num_rows, static_cast<Eigen::Index>(C.num_columns()));
  for (std::size_t j = 0; j < C.num_columns(); ++j) {
    for (int k = C.start[j]; k < C.start[j + 1]; ++k) {
      const auto entry = static_cast<std::size_t>(k);
      result(C.rows[entry], static_cast<Eigen::Index>(j)) += C.values[entry];
    }
  }
  return result;
}

/// |R'R - C'C| over the independent columns.
double error_of(const TriangularFactor& R, const SparseColumns& C) {
  const auto rank = static_cast<Eigen::Index>(R.rank());
  Eigen::MatrixXd upper = Eigen::MatrixXd::Zero(rank, rank), all = dense(C), chosen(C.num_rows, rank);
  for (Eigen::Index j = 0; j < rank; ++j) {
    const auto column = static_cast<std::size_t>(j);
    chosen.col(j) = all.col(R.independent[column]);
    for (int k = R.start[column]; k < R.start[column + 1]; ++k)
      upper(R.rows[static_cast<std::size_t>(k)], j) = R.values[static_cast<std::size_t>(k)];
    EXPECT_EQ(R.rows[static_cast<std::size_t>(R.start[column + 1]) - 1], j) << "the diagonal entry is last";
  }
  return (upper.transpose() * upper - chosen.transpose() * chosen).cwiseAbs().maxCoeff();
}

TEST(MergedRows, GiveTheFactorOfChainsStarsAndTrees) {
  const std::vector<std::vector<int>> trees{{0, 1, 2, 3, 4, 5}, {0, 0, 0, 0, 0}, {0, 0, 1, 1, 2, 2, 3, 6, 7}};
  for (unsigned seed = 1; seed <= 5; ++seed) {
    for (const std::vector<int>& parent : trees) {
      const SparseColumns C = make_tree(parent, seed);
      const TriangularFactor R = merge_rows(C, 1e-12);
      EXPECT_EQ(R.rank(), parent.size());
      EXPECT_LE(error_of(R, C), 1e-13);
    }
  }
}

TEST(MergedRows, AnyOtherPatternIsRightToo) {
  // Fill costs, but is no harm: random columns, more of them than an order without fill allows.
  std::mt19937 generator(7);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 20; ++trial) {
    SparseColumns C;
    C.num_rows = 30;
    for (int j = 0; j < 25; ++j) {
      for (int row = 0; row < 30; ++row) {
        if (generator() % 5 != 0) continue;
        C.rows.push_back(row);
        C.values.push_back(normal(generator));
      }
      C.start.push_back(static_cast<int>(C.rows.size()));
    }
    const TriangularFactor R = merge_rows(C, 1e-10);
    EXPECT_EQ(static_cast<Eigen::Index>(R.rank()), dense(C).fullPivHouseholderQr().rank());
    EXPECT_LE(error_of(R, C), 1e-12);
  }
}

TEST(MergedRows, LeaveOutWhatDepends) {
  // Column 2 is column 0 plus twice column 1, column 3 is empty; column 4 shares rows with both.
  SparseColumns C;
  C.num_rows = 4;
  C.rows = {0, 1, 1, 2, 0, 1, 2, 1, 3};
  C.values = {1.0, 0.5, 1.0, -1.0, 1.0, 2.5, -2.0, 3.0, 1.0};
  C.start = {0, 2, 4, 7, 7, 9};

  const TriangularFactor R = merge_rows(C, 1e-12);

  EXPECT_EQ(R.independent, (std::vector<int>{0, 1, 4}));
  EXPECT_EQ(R.dependent, (std::vector<int>{2, 3}));
  EXPECT_LE(error_of(R, C), 1e-14);
}

}  // namespace
}  // namespace tanor
