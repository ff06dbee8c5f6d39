/// The tests compare r(q, t) of every kind with differences, its charts with motions that they leave unchanged, and
/// A'WA with dense matrices.

#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <Eigen/Dense>

#include "evaluate/charts.hpp"
#include "evaluate/parametrisation.hpp"
#include "random_coordinates.hpp"

namespace tanor {
using namespace detail;
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A system's coordinates inside the library, near the motion's place at t, with everything in the inner order.
struct Placed {
  RandomCoordinates random;
  double t;
  Numbering numbering;
  Parametrisation coordinates;
  Parallel parallel{1};
  VectorXd q, q_dot, q_ddot;

  Placed(RandomCoordinates given, double time)
      : random(std::move(given)),
        t(time),
        numbering(number(random.system)),
        coordinates(random.system, numbering, 0.0),
        q(VectorXd::Zero(size())),
        q_dot(VectorXd::Zero(size())),
        q_ddot(VectorXd::Zero(size())) {
    std::mt19937 generator(3);
    std::normal_distribution<double> normal;
    coordinates.write_start(q.data(), q_dot.data());
    for (double step = 0.05; step < t; step += 0.05) locate(step);
    locate(t);
    // The state is off the centres of the charts.
    for (double& x : q) x += 0.2 * normal(generator);
    for (double& x : q_dot) x = normal(generator);
    for (double& x : q_ddot) x = normal(generator);
  }

  Eigen::Index size() const { return static_cast<Eigen::Index>(coordinates.num_coordinates()); }
  Eigen::Index num_numbers() const { return static_cast<Eigen::Index>(3 * numbering.num_points()); }
  VectorXd places(double time, int k) const {
    VectorXd inner(num_numbers());
    numbering.gather_points(random.derivative(time, k), {inner.data(), static_cast<std::size_t>(inner.size())});
    return inner;
  }
  void locate(double time) {
    coordinates.set_time(time);
    coordinates.locate(places(time, 0).data(), q.data());
  }

  struct Value {
    VectorXd r, v, psi, blocks;
  };
  /// Evaluates the coordinates at a time. Supports have their prescribed motion.
  Value at(double time, const VectorXd& where, const VectorXd& rate) {
    coordinates.set_time(time);
    Value value{places(time, 0), places(time, 1), places(time, 2), VectorXd(3 * coordinates.num_blocks())};
    coordinates.evaluate(parallel, where.data(), rate.data(), value.r.data(), value.v.data(), value.psi.data(),
                         value.blocks.data());
    return value;
  }
  /// Returns A column by column. Supports have no rows.
  MatrixXd A(const VectorXd& blocks) {
    MatrixXd result = MatrixXd::Zero(num_numbers(), size());
    for (Eigen::Index j = 0; j < size(); ++j) {
      const VectorXd e = VectorXd::Unit(size(), j);
      coordinates.apply(parallel, blocks.data(), e.data(), result.col(j).data());
    }
    return result;
  }
  VectorXd weights(double of_moving) const {
    VectorXd result = VectorXd::Constant(num_numbers() / 3, of_moving);
    result.tail(num_numbers() / 3 - static_cast<Eigen::Index>(numbering.num_moving)).setZero();
    return result;
  }
};

/// Returns the first and second derivative at 0 from differences of order 8.
template <class Function>
std::pair<VectorXd, VectorXd> differentiate(double h, const Function& function) {
  constexpr double first[] = {4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0};
  constexpr double second[] = {8.0 / 5.0, -1.0 / 5.0, 8.0 / 315.0, -1.0 / 560.0};
  const VectorXd here = function(0.0);
  std::pair<VectorXd, VectorXd> result{VectorXd::Zero(here.size()), VectorXd::Zero(here.size())};
  for (int k = 1; k <= 4; ++k) {
    const VectorXd after = function(k * h), before = function(-k * h);
    result.first += first[k - 1] / h * (after - before);
    result.second += second[k - 1] / (h * h) * (after - 2.0 * here + before);
  }
  return result;
}

class KindTest : public testing::TestWithParam<int> {
 protected:
  static Placed make(double t, std::uint32_t seed) {
    return Placed(RandomCoordinatesMaker(seed).make({GetParam(), GetParam()}), t);
  }
};

TEST_P(KindTest, VelocityAndPsiAreDerivativesAlongTheMotion) {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    Placed placed = make(0.6, seed);
    const auto [first, second] = differentiate(
        0.01, [&](double e) { return VectorXd(placed.at(placed.t + e, placed.q + e * placed.q_dot, placed.q_dot).r); });

    const auto [r, v, psi, blocks] = placed.at(placed.t, placed.q, placed.q_dot);

    EXPECT_LE((v - first).norm(), 1e-10 * (1.0 + first.norm())) << "seed " << seed;
    EXPECT_LE((psi - second).norm(), 1e-8 * (1.0 + second.norm())) << "seed " << seed;
  }
}

TEST_P(KindTest, BlocksAreTheDerivativesInEachCoordinate) {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    Placed placed = make(0.6, seed);
    const MatrixXd A = placed.A(placed.at(placed.t, placed.q, placed.q_dot).blocks);
    for (Eigen::Index j = 0; j < placed.size(); ++j) {
      const VectorXd column =
          differentiate(0.01, [&](double e) {
            return VectorXd(placed.at(placed.t, placed.q + e * VectorXd::Unit(placed.size(), j), placed.q_dot).r);
          }).first;
      EXPECT_LE((A.col(j) - column).norm(), 1e-11 * (1.0 + column.norm())) << "seed " << seed << ", coordinate " << j;
    }
  }
}

TEST_P(KindTest, TransposeIsThatOfTheBlocks) {
  Placed placed = make(0.6, 5);
  const auto value = placed.at(placed.t, placed.q, placed.q_dot);
  VectorXd x(placed.size());

  placed.coordinates.apply_transposed(placed.parallel, value.blocks.data(), value.v.data(), x.data());

  EXPECT_LE((x - placed.A(value.blocks).transpose() * value.v).norm(), 1e-13 * (1.0 + x.norm()));
}

TEST_P(KindTest, ProductsMakeTheGramMatrix) {
  for (const bool with_masses : {true, false}) {
    Placed placed = make(0.6, 6);
    const MatrixXd A = placed.A(placed.at(placed.t, placed.q, placed.q_dot).blocks);
    const VectorXd blocks = placed.at(placed.t, placed.q, placed.q_dot).blocks;
    std::vector<double> weights(placed.numbering.num_points(), 0.0);
    VectorXd W = VectorXd::Zero(placed.num_numbers());
    for (std::size_t i = 0; i < placed.numbering.num_moving; ++i) {
      weights[i] =
          with_masses ? placed.random.system.masses[static_cast<std::size_t>(placed.numbering.user_point[i])] : 1.0;
      W.segment<3>(static_cast<Eigen::Index>(3 * i)).setConstant(weights[i]);
    }

    MatrixXd H = MatrixXd::Zero(placed.size(), placed.size());
    for (const Product& product : placed.coordinates.list_products(weights)) {
      ASSERT_GE(product.row, product.column);
      H(product.row, product.column) +=
          product.weight * blocks.segment<3>(3 * product.block_a).dot(blocks.segment<3>(3 * product.block_b));
    }

    const MatrixXd dense = A.transpose() * W.asDiagonal() * A;
    EXPECT_LE((MatrixXd(H.selfadjointView<Eigen::Lower>()) - dense).norm(), 1e-13 * dense.norm());
  }
}

TEST_P(KindTest, IslandsHoldAllProducts) {
  Placed placed = make(0.6, 7);
  const std::vector<double> weights(placed.numbering.num_points(), 1.0);
  const auto& start = placed.coordinates.island_start();

  const auto island = [&](int row) { return std::upper_bound(start.begin(), start.end(), row) - start.begin(); };

  ASSERT_EQ(start.back(), placed.size());
  for (const Product& product : placed.coordinates.list_products(weights)) {
    EXPECT_EQ(island(product.row), island(product.column));
  }
}

TEST_P(KindTest, RecentringKeepsTheMotion) {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    Placed placed = make(0.6, seed);
    const auto before = placed.at(placed.t, placed.q, placed.q_dot);
    const VectorXd w = placed.A(before.blocks) * placed.q_ddot + before.psi;

    placed.coordinates.recentre(placed.t, placed.q.data(), placed.q_dot.data(), placed.q_ddot.data());

    const auto after = placed.at(placed.t, placed.q, placed.q_dot);
    const VectorXd w_after = placed.A(after.blocks) * placed.q_ddot + after.psi;
    const auto moving = static_cast<Eigen::Index>(3 * placed.numbering.num_moving);
    EXPECT_LE((after.r - before.r).norm(), 1e-14 * (1.0 + before.r.norm())) << "seed " << seed;
    EXPECT_LE((after.v - before.v).norm(), 1e-14 * (1.0 + before.v.norm())) << "seed " << seed;
    EXPECT_LE((w_after - w).head(moving).norm(), 1e-13 * (1.0 + w.norm())) << "seed " << seed;
  }
}

TEST_P(KindTest, PlacesAreFoundAgain) {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    Placed placed = make(0.6, seed);
    const VectorXd wanted = placed.at(placed.t, placed.q, placed.q_dot).r;

    placed.coordinates.locate(wanted.data(), placed.q.data());

    EXPECT_LE((placed.at(placed.t, placed.q, placed.q_dot).r - wanted).norm(), 1e-13 * (1.0 + wanted.norm()))
        << "seed " << seed;
  }
}

std::string name_kind(const testing::TestParamInfo<int>& kind) {
  static constexpr const char* names[] = {"free",  "line",           "plane",      "circle",         "sphere",
                                          "chain", "chain_in_plane", "rigid_body", "user_direction", "user_dumbbell"};
  static_assert(std::size(names) == RandomCoordinatesMaker::num_kinds);
  return names[kind.param];
}

INSTANTIATE_TEST_SUITE_P(Parametrisation, KindTest, testing::Range(0, RandomCoordinatesMaker::num_kinds), name_kind);

RC_GTEST_PROP(Parametrisation, NumbersGoIntoTheUsersOrder, ()) {
  // In the user's order the entries follow one another, each as if it were alone.
  const RandomCoordinates random = any_coordinates();
  Placed placed(random, 0.0);
  VectorXd wanted(placed.size());
  Eigen::Index count = 0;
  for (const Coordinates& entry : random.system.coordinates) {
    System single = random.system;
    single.coordinates = {entry};
    const Parametrisation alone(single, placed.numbering, 0.0);
    const auto own = static_cast<Eigen::Index>(alone.num_coordinates());
    VectorXd q = VectorXd::Zero(own), q_dot = VectorXd::Zero(own);
    Parametrisation(single, placed.numbering, 0.0).locate(placed.places(0.0, 0).data(), q.data());
    alone.write_start(q.data(), q_dot.data());
    wanted.segment(count, own) = q;
    count += own;
  }
  RC_ASSERT(count == placed.size());
  VectorXd q = VectorXd::Zero(placed.size()), q_dot = q, users(placed.size());
  placed.coordinates.set_time(0.0);
  placed.coordinates.locate(placed.places(0.0, 0).data(), q.data());
  placed.coordinates.write_start(q.data(), q_dot.data());

  placed.coordinates.scatter(q.data(), users.data());

  RC_ASSERT((users - wanted).norm() == 0.0);
}

// ---- single charts -----------------------------------------------------------------------------------------------

TEST(DirectionChart, IsAUnitVectorWithOrthonormalTangentsAtItsCentre) {
  const Vec3 n = (1.0 / 3.0) * Vec3{1.0, -2.0, 2.0};
  const DirectionChart chart(n);
  const double zero[2] = {0.0, 0.0}, rate[2] = {0.3, -0.4}, far[2] = {1.0, 2.0};

  const auto centre = chart(zero, rate), away = chart(far, rate);

  EXPECT_EQ(norm(centre.u - n), 0.0);
  EXPECT_NEAR(dot(centre.tangent[0], centre.tangent[1]), 0.0, 1e-16);
  EXPECT_NEAR(dot(centre.tangent[0], n), 0.0, 1e-16);
  EXPECT_NEAR(norm(centre.tangent[0]), 1.0, 1e-15);
  EXPECT_NEAR(norm(centre.second + 0.25 * n), 0.0, 1e-16);  // -|q'|^2 n
  EXPECT_NEAR(norm(away.u), 1.0, 1e-15);
  // The chart has 2 tan(angle/2) = |q|.
  EXPECT_NEAR(dot(away.u, n), std::cos(2.0 * std::atan(0.5 * std::sqrt(5.0))), 1e-15);
}

TEST(RotationChart, TurnsByTwiceTheAngleOfGibbs) {
  const RotationChart chart;
  const double theta[3] = {0.0, 0.0, 2.0 * std::tan(0.35)}, rate[3] = {0.0, 0.0, 1.0};

  const auto now = chart(theta, rate);

  // The chart has theta/2 = tan(angle/2).
  EXPECT_NEAR(now.rotation(0, 0), std::cos(0.7), 1e-15);
  EXPECT_NEAR(now.rotation(1, 0), std::sin(0.7), 1e-15);
  EXPECT_NEAR(now.omega.z, std::cos(0.35) * std::cos(0.35), 1e-15);
}

}  // namespace
}  // namespace tanor
