/// The tests compare Linearization and Projector with dense algebra on random systems.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "dense.hpp"
#include "dynamics/linearization.hpp"
#include "dynamics/projector.hpp"
#include "linearised.hpp"
#include "random_numbers.hpp"

namespace tanor {
using namespace detail;
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A random system, linearized at its state by the library and once more as dense matrices.
struct AtState {
  Workspace work;
  const Model& model{work.model()};
  Linearised dense;
  Linearization linearization;
  Residuals residuals;
  Projector projector;
  double t;
  Outcome outcome;

  explicit AtState(const RandomSystem& random, const SolverOptions& options = {.threads = 1})
      : work(random.system, options, random.t),
        dense(random),
        linearization(work, options),
        residuals(work, linearization.blocks()),
        projector(work, linearization, residuals),
        t(random.t) {
    work.set_time(t);
    work.prescribe_all(t, dense.r.data(), dense.v.data());
    work.measure_velocity_scale(t, dense.r.data(), dense.v.data());
    outcome = linearization.update(t, dense.r.data());
  }

  VectorXd vector(const std::vector<double>& x) const { return reference::vector(x); }
  /// Returns the size of x [3n] of points that move, in the M-norm.
  double norm(const VectorXd& x) const {
    double square = 0.0;
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(3 * model.num_moving()); ++i)
      square += model.mass[static_cast<std::size_t>(i / 3)] * x[i] * x[i];
    return std::sqrt(square);
  }
  /// Returns a factor by which rounding errors of a solve with S are multiplied at least.
  double sqrt_condition() const {
    const VectorXd inverse_M = dense.inverse_M().head(static_cast<Eigen::Index>(3 * model.num_moving()));
    reference::Mechanics mechanics;
    mechanics.K = dense.K().topRows(inverse_M.size());
    mechanics.M = inverse_M.cwiseInverse();
    return mechanics.sqrt_condition();
  }
};

RC_GTEST_PROP(Linearization, RefinedSolutionIsThatOfTheDenseS, ()) {
  AtState state(any_system());
  RC_ASSERT(state.outcome.ok());
  const std::vector<double> b = normal_numbers(state.model.num_rows(), 1);
  std::vector<double> lambda(b.size()), dw(state.dense.r.size());

  state.linearization.solve_refined(b.data(), lambda.data(), dw.data());

  const MatrixXd S = state.dense.S();
  const VectorXd root = S.diagonal().cwiseSqrt(), x = state.vector(lambda), right = state.vector(b);
  const double accuracy = 1e-13 * state.sqrt_condition();
  RC_ASSERT((S * x + right).cwiseQuotient(root).norm() <= accuracy * (root.cwiseProduct(x).norm() + 1.0));
  const VectorXd wanted = state.dense.inverse_M().asDiagonal() * (state.dense.K() * x);
  RC_ASSERT((state.vector(dw) - wanted).norm() <= accuracy * (wanted.norm() + 1.0));
}

RC_GTEST_PROP(Linearization, CorrectionRemovesFromPointsWhatTheConstraintsForbid, ()) {
  AtState state(any_system());
  RC_ASSERT(state.outcome.ok());
  std::vector<double> points = normal_numbers(state.dense.r.size(), 2), rows(state.model.num_rows());
  std::fill(points.begin() + static_cast<std::ptrdiff_t>(3 * state.model.num_moving()), points.end(), 0.0);
  const VectorXd before = state.vector(points);

  state.linearization.apply_transposed(points.data(), nullptr, rows.data());
  state.linearization.correct(rows.data(), points.data());

  // The result has K'x = 0, and is orthogonal in the M-norm to the part that was removed.
  const VectorXd after = state.vector(points), taken = before - after;
  const double accuracy = 1e-12 * state.sqrt_condition() * state.sqrt_condition();
  const VectorXd root = state.dense.S().diagonal().cwiseSqrt();
  RC_ASSERT((state.dense.K().transpose() * after).cwiseQuotient(root).norm() <= accuracy * state.norm(before));
  const double whole = state.norm(before), left = state.norm(after), part = state.norm(taken);
  RC_ASSERT(std::abs(whole * whole - left * left - part * part) <= accuracy * whole * whole);
}

TEST(Linearization, ConstantGradientsAreFactorizedOnce) {
  System system;
  system.positions = {0.0, 0.0, 1.0, 1.0, 0.0, 1.0};
  system.masses = {1.0, 2.0};
  system.velocities.assign(6, 0.0);
  system.constraints = {Planes{"floor", {0, 1}, Vector3{0.0, 0.0, 1.0}, 1.0}};
  AtState state({system, 0.0, system.positions, system.velocities});
  ASSERT_TRUE(state.outcome.ok());
  const std::size_t factorizations = state.work.counters.factorizations;

  ASSERT_TRUE(state.linearization.update(1.0, system.positions.data()).ok());

  EXPECT_EQ(state.work.counters.factorizations, factorizations);
}

TEST(Linearization, TheFactorOfAllRowsTakesThePlaceOfThatOfTheIslandsOnce) {
  System system;
  system.positions = {0.0, 0.0, 0.0, 1.0, 0.0, 0.1, 1.5, 0.6, 0.0, 1.2, 0.9, -0.7};
  system.masses = {1.0, 0.3, 2.0, 0.7};
  system.velocities.assign(12, 0.0);
  system.constraints = {Rods{"rods", {{0, 1}, {1, 2}, {2, 3}}, {}, {}}};
  AtState state({system, 0.0, system.positions, system.velocities},
                {.linear_solver = LinearSolver::Paths, .threads = 1});
  const std::vector<double> b = {1.0, -2.0, 0.5};
  std::vector<double> by_islands(3), by_all(3), dw(12);
  state.linearization.solve_refined(b.data(), by_islands.data(), dw.data());

  const std::optional<Outcome> improved = state.linearization.improve_factor(0.0, state.dense.r.data());

  ASSERT_TRUE(improved && improved->ok());
  state.linearization.solve_refined(b.data(), by_all.data(), dw.data());
  for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(by_all[a], by_islands[a], 1e-13 * std::abs(by_islands[a]));
  EXPECT_TRUE(state.linearization.is_fresh());
  EXPECT_FALSE(state.linearization.improve_factor(0.0, state.dense.r.data()));
}

/// Two triangles of rods of 1 m, which nothing joins: one around the origin, turned by `angle` and larger by the part
/// `too_large`, and one 1000 km away.
std::vector<double> place_two_triangles(double angle, double too_large) {
  std::vector<double> r;
  const double radius = 1.0 / std::sqrt(3.0);
  for (int k = 0; k < 3; ++k) {
    const double at = angle + 2.0 * std::numbers::pi * k / 3.0;
    r.insert(r.end(), {radius * (1.0 + too_large) * std::cos(at), radius * (1.0 + too_large) * std::sin(at), 0.0});
  }
  for (int k = 0; k < 3; ++k) {
    const double at = 0.1 + 2.0 * std::numbers::pi * k / 3.0;
    r.insert(r.end(), {1e6 + radius * std::cos(at), radius * std::sin(at), 0.0});
  }
  return r;
}

TEST(Projector, AnIslandConvergesWhileAnotherHasReachedItsRounding) {
  System system;
  system.positions = place_two_triangles(0.0, 0.0);
  system.masses.assign(6, 1.0);
  system.velocities.assign(18, 0.0);
  system.constraints = {Rods{"rods", {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}}, std::vector<double>(6, 1.0)}};
  AtState state({system, 0.0, system.positions, system.velocities});
  ASSERT_TRUE(state.outcome.ok());
  // The violation is below the rounding of the far triangle. Along the old K each step leaves a part of it.
  std::vector<double> r = place_two_triangles(0.5, 8e-10), sum(6);

  const ProjectionReport report = state.projector.project_along_gradients(0.0, r.data(), sum.data());

  ASSERT_TRUE(report.outcome.ok());
  EXPECT_GT(report.violation, 1e-12) << "the far triangle must show its rounding";
  for (int k = 0; k < 3; ++k) {
    const Eigen::Map<const Eigen::Vector3d> a(&r[3 * k]), b(&r[3 * ((k + 1) % 3)]);
    EXPECT_NEAR((b - a).norm(), 1.0, 2e-13);
  }
}

RC_GTEST_PROP(Projector, VelocitiesMoveAlongMInverseKAlone, ()) {
  AtState state(any_system());
  RC_ASSERT(state.outcome.ok());
  const std::vector<double> away = normal_numbers(state.dense.v.size(), 3);
  std::vector<double> v = state.dense.v;
  for (std::size_t i = 0; i < 3 * state.model.num_moving(); ++i) v[i] += 0.1 * away[i];
  const VectorXd before = state.vector(v);

  const ProjectionReport report = state.projector.project_velocities(state.t, state.dense.r.data(), v.data());

  RC_ASSERT(report.outcome.ok());
  RC_ASSERT(state.work.velocity_violation(state.t, state.dense.r.data(), v.data()) <= 1e-11);
  // With v - v* = M^-1 K nu, the part outside the range of M^-1/2 K is rounding.
  const VectorXd moved = state.vector(v) - before;
  const Eigen::Index size = static_cast<Eigen::Index>(3 * state.model.num_moving());
  const VectorXd root_M = state.dense.inverse_M().head(size).cwiseInverse().cwiseSqrt();
  const VectorXd u = root_M.cwiseProduct(moved.head(size));
  MatrixXd C = root_M.cwiseInverse().asDiagonal() * state.dense.K().topRows(size);
  if (C.cols() == 0) return;
  const VectorXd along = C * reference::solve_least_squares(C, u);
  RC_ASSERT((u - along).norm() <= 1e-11 * (u.norm() + root_M.cwiseProduct(before.head(size)).norm()));
}

RC_GTEST_PROP(Projector, PositionsNearbyEndOnTheConstraints, ()) {
  AtState state(any_system({.time_dependent = false}));
  RC_ASSERT(state.outcome.ok());
  const std::vector<double> away = normal_numbers(state.dense.r.size(), 4);
  std::vector<double> r = state.dense.r;
  for (std::size_t i = 0; i < 3 * state.model.num_moving(); ++i) r[i] += 1e-5 * away[i];

  const ProjectionReport report = state.projector.project_positions(state.t, r.data());

  RC_ASSERT(report.outcome.ok());
  RC_ASSERT(state.work.position_violation(state.t, r.data()) <= 1e-11);
}

}  // namespace
}  // namespace tanor
