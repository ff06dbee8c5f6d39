/// With redundant constraints accelerations are unique and multipliers the smallest, as dense pseudo-inverses give
/// them.

#include <Eigen/Dense>
#include <cmath>

#include <gtest/gtest.h>
#include <tanor/dynamics.hpp>

#include "dense.hpp"

namespace tanor {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Makes an octahedron with its three diagonals, 15 rods of which 12 make it rigid, and a tail of two rods. The truss
/// spins and is loaded. No multiplier of the octahedron is determined, both of the tail are.
System make_truss() {
  System system;
  system.positions = {1.1, 0,   0,   -0.9, 0, 0.1,  0,   1.2, 0,   0.1, -1,  0,
                      0,   0.2, 1.3, 0,    0, -0.8, 2.0, 0.3, 0.2, 2.6, 0.9, 0.1};
  system.masses = {1, 2, 0.5, 3, 1, 1.5, 0.7, 1.2};
  Rods rods{"rods", {}, {}, {}};
  for (Index i = 0; i < 6; ++i) {
    for (Index j = i + 1; j < 6; ++j) rods.pairs.push_back({i, j});
  }
  rods.pairs.push_back({0, 6});
  rods.pairs.push_back({6, 7});
  system.constraints = {rods};
  system.forces = {Gravity{"", {0, 0, -9.81}}, ConstantForce{"", {2}, VectorFunction(Vector3{3.0, -1.0, 7.0})},
                   ConstantForce{"", {7}, VectorFunction(Vector3{-2.0, 4.0, 1.0})}};
  // The velocities v = (0.3, -0.5, 1.1) x r are those of a rigid motion, which is admissible.
  for (std::size_t i = 0; i < 8; ++i) {
    const double x = system.positions[3 * i], y = system.positions[3 * i + 1], z = system.positions[3 * i + 2];
    system.velocities.insert(system.velocities.end(), {-0.5 * z - 1.1 * y, 1.1 * x - 0.3 * z, 0.3 * y + 0.5 * x});
  }
  return system;
}

struct Dense {
  MatrixXd K;  // [3n x d]
  VectorXd phi, f, inverse_mass;
};

Dense make_dense(const System& system) {
  const auto& pairs = std::get<Rods>(system.constraints[0]).pairs;
  const auto n = static_cast<Eigen::Index>(system.positions.size()), d = static_cast<Eigen::Index>(pairs.size());
  const Eigen::Map<const VectorXd> r(system.positions.data(), n), v(system.velocities.data(), n);
  Dense dense{MatrixXd::Zero(n, d), VectorXd(d), VectorXd::Zero(n), VectorXd(n)};
  for (Eigen::Index a = 0; a < d; ++a) {
    const auto [i, j] = pairs[static_cast<std::size_t>(a)];
    const Eigen::Vector3d dr = r.segment<3>(3 * j) - r.segment<3>(3 * i),
                          dv = v.segment<3>(3 * j) - v.segment<3>(3 * i);
    const double length = dr.norm();
    dense.K.block<3, 1>(3 * i, a) = -dr / length;
    dense.K.block<3, 1>(3 * j, a) = dr / length;
    dense.phi[a] = (dv.squaredNorm() - std::pow(dr.dot(dv) / length, 2)) / length;
  }
  for (Eigen::Index i = 0; i < n / 3; ++i) {
    const double mass = system.masses[static_cast<std::size_t>(i)];
    dense.inverse_mass.segment<3>(3 * i).setConstant(1.0 / mass);
    dense.f[3 * i + 2] = -9.81 * mass;
  }
  dense.f.segment<3>(6) += Eigen::Vector3d(3.0, -1.0, 7.0);
  dense.f.segment<3>(21) += Eigen::Vector3d(-2.0, 4.0, 1.0);
  return dense;
}

TEST(Rank, OverBracedTrussHasTheAccelerationsAndMultipliersOfThePseudoInverse) {
  const System system = make_truss();
  const Dense dense = make_dense(system);
  Dynamics dynamics(system);
  VectorXd w(24), lambda(17), eta(24);

  const SolveReport report = dynamics.solve(
      {.time = 0.0, .positions = system.positions, .velocities = system.velocities},
      {.accelerations = {w.data(), 24}, .multipliers = {lambda.data(), 17}, .reactions = {eta.data(), 24}});
  const RankReport rank = dynamics.rank({.time = 0.0, .positions = system.positions, .velocities = system.velocities});

  ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
  // The smallest of all solutions is lambda = -S^+ (phi + K'M^-1 f).
  const MatrixXd S = dense.K.transpose() * dense.inverse_mass.asDiagonal() * dense.K;
  const VectorXd b = dense.phi + dense.K.transpose() * dense.inverse_mass.cwiseProduct(dense.f);
  const VectorXd expected = -reference::solve_least_squares(S, b);
  const VectorXd expected_w = dense.inverse_mass.cwiseProduct(dense.f + dense.K * expected);
  EXPECT_LE((w - expected_w).norm(), 1e-12 * expected_w.norm());
  EXPECT_LE((lambda - expected).norm(), 1e-10 * expected.norm());
  EXPECT_LE((eta - dense.K * expected).norm(), 1e-11 * eta.norm());

  EXPECT_EQ(rank.rank, 14U);
  EXPECT_EQ(rank.degrees_of_freedom, 10U);
  EXPECT_EQ(rank.dependences.size(), 3U);
  // A multiplier is unique where it has no part in any self-stress of K.
  const MatrixXd null_space = reference::null_space(dense.K);
  ASSERT_EQ(null_space.cols(), 3);
  for (Eigen::Index a = 0; a < 17; ++a) {
    EXPECT_EQ(rank.multipliers_unique[static_cast<std::size_t>(a)], null_space.row(a).norm() < 1e-9) << a;
  }
  EXPECT_TRUE(rank.multipliers_unique[15] && rank.multipliers_unique[16]);
  EXPECT_FALSE(rank.multipliers_unique[0]);
}

TEST(Rank, EachDependenceIsAnEquationBetweenGradients) {
  const System system = make_truss();
  const Dense dense = make_dense(system);
  Dynamics dynamics(system);
  std::vector<double> w(24);
  ASSERT_TRUE(
      dynamics
          .solve({.time = 0.0, .positions = system.positions, .velocities = system.velocities}, {.accelerations = w})
          .outcome.ok());

  const RankReport rank = dynamics.rank({.time = 0.0, .positions = system.positions, .velocities = system.velocities});

  // C = M^-1/2 K has unit columns.
  MatrixXd C = dense.inverse_mass.cwiseSqrt().asDiagonal() * dense.K;
  C.colwise().normalize();
  for (const RowDependence& dependence : rank.dependences) {
    VectorXd rest = C.col(static_cast<Eigen::Index>(dependence.row));
    for (const auto& [row, coefficient] : dependence.terms) rest -= coefficient * C.col(static_cast<Eigen::Index>(row));
    EXPECT_LE(rest.norm(), 1e-13);
  }
}

TEST(Rank, StraightChainRaisesNoSuspicion) {
  // cond S = 1.6 N^2 = 1.6e6, so that refinement alone is enough.
  constexpr Index rods = 1000;
  System system;
  Rods group;
  for (Index k = 0; k <= rods; ++k) {
    system.positions.insert(system.positions.end(), {0.1 * k, 0.0, 0.0});
    if (k > 0) group.pairs.push_back({k - 1, k});
  }
  system.masses.assign(rods + 1, 0.1);
  system.supports = {{"", {0}, {}}};
  system.constraints = {group};
  system.forces = {Gravity{"", {1.0, 0.0, -9.81}}};
  Dynamics dynamics(system);
  std::vector<double> w(3 * (rods + 1));
  const StateView at_rest{.time = 0.0, .positions = system.positions};

  const SolveReport report = dynamics.solve(at_rest, {.accelerations = w});

  ASSERT_TRUE(report.outcome.ok());
  EXPECT_LE(report.residual, 1e-13);
  EXPECT_EQ(dynamics.counters().rank_decisions, 0U);
  EXPECT_EQ(dynamics.rank(at_rest, true).rank, 1000U);
  EXPECT_EQ(dynamics.counters().rank_decisions, 1U);
}

/// Light beads lie between heavy ones. As columns of M^-1/2 K both rods of a light bead are equal to 1e-6 and less,
/// while K itself is far from losing rank. Off xi = 0 K is known only to 1e-5.
TEST(Rank, UnequalMassesDoNotLowerTheRank) {
  for (const double ratio : {1e12, 1e15, 1e18}) {
    System system;
    Rods rods{"rods", {}, 0.1, {}};
    for (Index i = 0; i <= 10; ++i) {
      system.positions.insert(system.positions.end(), {0.1 * i * (1.0 + 1e-7), 0, 0});
      system.masses.push_back(i % 2 == 0 ? ratio : 1.0);
      if (i > 0) rods.pairs.push_back({i - 1, i});
    }
    system.velocities.assign(system.positions.size(), 0.0);
    system.supports = {{"", {0}, {}}};
    system.constraints = {rods};
    system.forces = {Gravity{"", {0, 0, -9.81}}};
    Dynamics dynamics(system);
    std::vector<double> w(system.positions.size());

    ASSERT_TRUE(
        dynamics
            .solve({.time = 0.0, .positions = system.positions, .velocities = system.velocities}, {.accelerations = w})
            .outcome.ok());

    EXPECT_EQ(dynamics.rank({.time = 0.0, .positions = system.positions, .velocities = system.velocities}, true).rank,
              10U)
        << ratio;
    for (std::size_t i = 1; i <= 10; ++i) EXPECT_NEAR(w[3 * i + 2], -9.81, 1e-9) << ratio;
  }
}

}  // namespace
}  // namespace tanor
