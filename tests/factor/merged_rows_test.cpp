/// QR by merged rows has R'R = C'C and leaves out the columns that depend on others.

#include "factor/merged_rows.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "dense.hpp"

namespace tanor {
using namespace detail;
namespace {

Vec3 random_vector(std::mt19937& generator) {
  std::normal_distribution<double> normal;
  const double x = normal(generator), y = normal(generator);
  return {x, y, normal(generator)};
}

/// Makes a tree of rods with the leaves last. Column k joins point parent[k] and point k + 1.
PointColumns make_tree(const std::vector<int>& parent, unsigned seed) {
  std::mt19937 generator(seed);
  PointColumns C;
  C.num_points = static_cast<int>(parent.size() + 1);
  // An order from the leaves on has no fill.
  for (std::size_t k = parent.size(); k-- > 0;) {
    for (const int point : {parent[k], static_cast<int>(k) + 1}) C.entries.push_back({point, random_vector(generator)});
    C.start.push_back(static_cast<int>(C.entries.size()));
  }
  return C;
}

Eigen::MatrixXd dense(const PointColumns& C) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(3 * C.num_points, static_cast<Eigen::Index>(C.num_columns()));
  for (std::size_t j = 0; j < C.num_columns(); ++j) {
    for (int k = C.start[j]; k < C.start[j + 1]; ++k) {
      const auto& [point, value] = C.entries[static_cast<std::size_t>(k)];
      result.col(static_cast<Eigen::Index>(j)).segment<3>(3 * point) += Eigen::Vector3d(value.x, value.y, value.z);
    }
  }
  return result;
}

/// Returns |R'R - C'C| over the independent columns.
double error_of(const TriangularFactor& R, const PointColumns& C) {
  const auto rank = static_cast<Eigen::Index>(R.rank());
  Eigen::MatrixXd upper = Eigen::MatrixXd::Zero(rank, rank), all = dense(C), chosen(3 * C.num_points, rank);
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
      const PointColumns C = make_tree(parent, seed);
      const TriangularFactor R = merge_rows(C, 1e-12);
      EXPECT_EQ(R.rank(), parent.size());
      EXPECT_LE(error_of(R, C), 1e-13);
    }
  }
}

TEST(MergedRows, GiveTheFactorOfRandomColumns) {
  // There are more random columns than an order without fill allows. Fill costs, but does no harm.
  std::mt19937 generator(7);
  for (int trial = 0; trial < 20; ++trial) {
    PointColumns C;
    C.num_points = 10;
    for (int j = 0; j < 25; ++j) {
      for (int point = 0; point < C.num_points; ++point) {
        if (generator() % 5 != 0) continue;
        C.entries.push_back({point, random_vector(generator)});
      }
      C.start.push_back(static_cast<int>(C.entries.size()));
    }
    const TriangularFactor R = merge_rows(C, 1e-10);
    EXPECT_EQ(static_cast<Eigen::Index>(R.rank()), reference::rank_of(dense(C)));
    EXPECT_LE(error_of(R, C), 1e-12);
  }
}

TEST(MergedRows, LeaveOutDependentColumns) {
  // Column 2 is column 0 plus twice column 1, column 3 is empty, and column 4 shares rows with both.
  PointColumns C;
  C.num_points = 2;
  C.entries = {
      {0, {1.0, 0.5, 0.0}}, {0, {0.0, 1.0, -1.0}}, {0, {1.0, 2.5, -2.0}}, {0, {0.0, 3.0, 0.0}}, {1, {1.0, 0.0, 0.0}}};
  C.start = {0, 1, 2, 3, 3, 5};

  const TriangularFactor R = merge_rows(C, 1e-12);

  EXPECT_EQ(R.independent, (std::vector<int>{0, 1, 4}));
  EXPECT_EQ(R.dependent, (std::vector<int>{2, 3}));
  EXPECT_LE(error_of(R, C), 1e-14);
}

TEST(MergedRows, ExpandToTheSameMatrix) {
  const PointColumns C = make_tree({0, 0, 1, 1, 2}, 3);
  const SparseColumns all = C.expand();
  Eigen::MatrixXd expanded = Eigen::MatrixXd::Zero(all.num_rows, static_cast<Eigen::Index>(all.num_columns()));
  for (std::size_t j = 0; j < all.num_columns(); ++j) {
    for (auto k = static_cast<std::size_t>(all.start[j]); k < static_cast<std::size_t>(all.start[j + 1]); ++k)
      expanded(all.rows[k], static_cast<Eigen::Index>(j)) = all.values[k];
  }
  EXPECT_EQ(expanded, dense(C));
}

}  // namespace
}  // namespace tanor
