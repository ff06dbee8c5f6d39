/// QR by merged rows has R'R = C'C and leaves out the columns that depend on others.

#include "factor/sparse_qr.hpp"

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

/// Columns that are made one after the other from their parts at points.
struct Parts {
  std::vector<std::vector<PointEntry>> columns{};

  SparseColumns collect(int num_points) const {
    SparseColumns C = collect_columns(columns.size(), [&](const auto& add) {
      for (std::size_t j = 0; j < columns.size(); ++j)
        for (const PointEntry& part : columns[j]) add(j, part);
    });
    C.num_rows = 3 * num_points;
    return C;
  }
};

/// Makes a tree of rods with the leaves last. Column k joins point parent[k] and point k + 1.
SparseColumns make_tree(const std::vector<int>& parent, unsigned seed) {
  std::mt19937 generator(seed);
  Parts parts;
  // An order from the leaves on has no fill.
  for (std::size_t k = parent.size(); k-- > 0;) {
    parts.columns.emplace_back();
    for (const int point : {parent[k], static_cast<int>(k) + 1})
      parts.columns.back().push_back({point, random_vector(generator)});
  }
  return parts.collect(static_cast<int>(parent.size() + 1));
}

Eigen::MatrixXd dense_of(const SparseColumns& C) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(C.num_rows, static_cast<Eigen::Index>(C.num_columns()));
  for (int j = 0; j < result.cols(); ++j) for_each_entry(C, j, [&](int row, double value) { result(row, j) += value; });
  return result;
}

/// Returns |R'R - C'C| over the independent columns.
double error_of(const TriangularFactor& R, const SparseColumns& C) {
  const auto rank = static_cast<Eigen::Index>(R.rank());
  Eigen::MatrixXd upper = Eigen::MatrixXd::Zero(rank, rank), all = dense_of(C), chosen(C.num_rows, rank);
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

TEST(MergedRows, GiveTheFactorOfRandomColumns) {
  // There are more random columns than an order without fill allows. Fill costs, but does no harm.
  std::mt19937 generator(7);
  for (int trial = 0; trial < 20; ++trial) {
    Parts parts;
    constexpr int num_points = 10;
    for (int j = 0; j < 25; ++j) {
      parts.columns.emplace_back();
      for (int point = 0; point < num_points; ++point) {
        if (generator() % 5 != 0) continue;
        parts.columns.back().push_back({point, random_vector(generator)});
      }
    }
    const SparseColumns C = parts.collect(num_points);
    const TriangularFactor R = merge_rows(C, 1e-10);
    EXPECT_EQ(static_cast<Eigen::Index>(R.rank()), reference::rank_of(dense_of(C)));
    EXPECT_LE(error_of(R, C), 1e-12);
  }
}

TEST(MergedRows, LeaveOutDependentColumns) {
  // Column 2 is column 0 plus twice column 1, column 3 is empty, and column 4 shares rows with both.
  const Parts parts{{{{0, {1.0, 0.5, 0.0}}},
                     {{0, {0.0, 1.0, -1.0}}},
                     {{0, {1.0, 2.5, -2.0}}},
                     {},
                     {{0, {0.0, 3.0, 0.0}}, {1, {1.0, 0.0, 0.0}}}}};
  const SparseColumns C = parts.collect(2);

  const TriangularFactor R = merge_rows(C, 1e-12);

  EXPECT_EQ(R.independent, (std::vector<int>{0, 1, 4}));
  EXPECT_EQ(R.dependent, (std::vector<int>{2, 3}));
  EXPECT_LE(error_of(R, C), 1e-14);
}

// Parts are those of an angle whose ends are one point.
TEST(MergedRows, TakeThePartsOfAPointThatIsNamedTwiceAsOne) {
  const Parts parts{{{{1, {1.0, 2.0, 3.0}}, {0, {4.0, 5.0, 6.0}}, {1, {0.5, -2.0, 1.0}}}, {{1, {0.0, 1.0, 0.0}}}}};

  const SparseColumns C = parts.collect(2);

  EXPECT_EQ(C.rows, (std::vector<int>{0, 1, 2, 3, 4, 5, 3, 4, 5}));
  EXPECT_EQ(C.values, (std::vector<double>{4.0, 5.0, 6.0, 1.5, 0.0, 4.0, 0.0, 1.0, 0.0}));
  EXPECT_LE(error_of(merge_rows(C, 1e-12), C), 1e-13);
}

}  // namespace
}  // namespace tanor
