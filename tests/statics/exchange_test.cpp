#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>
#include <vector>

#include "dense.hpp"
#include "statics/one_sided.hpp"

namespace tanor {
using namespace detail;
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

/// Contacts obey z >= 0, w = q + M z >= 0, z'w = 0, where z presses and w is the gap.
struct Complementarity {
  MatrixXd M;
  VectorXd q, z, w;

  /// Computes z of closed contacts and w of open ones.
  void solve(const std::vector<bool>& open) {
    const auto size = static_cast<Eigen::Index>(open.size());
    MatrixXd A = M;
    for (Eigen::Index i = 0; i < size; ++i) {
      if (!open[static_cast<std::size_t>(i)]) continue;
      A.row(i).setZero();
      A(i, i) = 1.0;
    }
    VectorXd b = -q;
    for (Eigen::Index i = 0; i < size; ++i) {
      if (open[static_cast<std::size_t>(i)]) b[i] = 0.0;
    }
    z = reference::solve_partial(A, b);
    w = q + M * z;
  }
  UserRows find_wrong(const std::vector<bool>& open) {
    solve(open);
    UserRows wrong;
    for (std::size_t i = 0; i < open.size(); ++i) {
      if ((open[i] ? w : z)[static_cast<Eigen::Index>(i)] < -1e-12) wrong.push_back(i);
    }
    return wrong;
  }
};

void change(std::vector<bool>& open, const UserRows& rows) {
  for (const std::size_t row : rows) open[row] = !open[row];
}

/// Returns the rounds until nothing is wrong, or -1 where a set comes back before.
int count_rounds(Complementarity problem, std::vector<bool> open) {
  Exchange exchange;
  for (int round = 0; round < 1000; ++round) {
    const UserRows rows = exchange.choose(problem.find_wrong(open), open);
    if (rows.empty()) return round;
    if (exchange.is_stuck()) return -1;
    change(open, rows);
  }
  return -1;
}

/// The principal minors of this matrix are positive, and changing all that is wrong runs in a circle (Ben Gharbia &
/// Gilbert, Mathematical Programming 134, 2012).
TEST(Exchange, EndsWhereChangingAllThatIsWrongGoesInACircle) {
  Complementarity problem{MatrixXd(3, 3), VectorXd::Constant(3, -1.0), {}, {}};
  problem.M << 1, 2, 0, 0, 1, 2, 2, 0, 1;
  std::vector<bool> open{true, false, false};
  for (int round = 0; round < 3; ++round) {
    const UserRows wrong = problem.find_wrong(open);
    ASSERT_FALSE(wrong.empty());
    change(open, wrong);
  }
  ASSERT_EQ(open, (std::vector<bool>{true, false, false})) << "this is no circle";

  EXPECT_GT(count_rounds(problem, open), 0);
}

TEST(Exchange, EndsForRandomPositiveDefiniteMatrices) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 300; ++trial) {
    const Eigen::Index size = 2 + trial % 30;
    // Nearly singular matrices take longest.
    const MatrixXd any = MatrixXd::NullaryExpr(size, size / 2 + 1, [&] { return normal(random); });
    Complementarity problem{any * any.transpose() + 1e-3 * MatrixXd::Identity(size, size),
                            VectorXd::NullaryExpr(size, [&] { return normal(random); }),
                            {},
                            {}};

    EXPECT_GE(count_rounds(problem, std::vector<bool>(static_cast<std::size_t>(size), trial % 2 == 0)), 0) << trial;
  }
}

/// The conditions -z + 1 and z - 1 contradict each other: M is no matrix of a stiffness, and no set is right.
TEST(Exchange, SaysWhereItIsStuck) {
  Complementarity problem{MatrixXd::Constant(1, 1, -1.0), VectorXd::Constant(1, -1.0), {}, {}};

  EXPECT_EQ(count_rounds(problem, {true}), -1);
}

}  // namespace
}  // namespace tanor
