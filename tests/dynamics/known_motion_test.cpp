/// For motions that are known exactly, the forces and reactions that make them are given, and the accelerations are
/// found.

#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "dense.hpp"
#include "solved.hpp"

namespace tanor {
namespace {

using Eigen::VectorXd;

// ---- two rods of changing length on a moving anchor --------------------------------------------------------------
//
//   a(t) o----- l(t) -----o r1 ----- b(t) -----o r2        r1 = a + l e(theta1, phi1), r2 = r1 + b e(theta2, phi2)
//
// Angles are any functions of time. The force that makes the motion is f = M r'' - K mu with any multipliers mu.

struct TwoRods {
  static constexpr double masses[2] = {1.3, 0.4};
  static constexpr double multipliers[2] = {-2.5, 7.0};

  using Number = Jet<2>;
  using Place = std::array<Number, 3>;

  static Number l(const Number& t) { return 1.0 + 0.2 * sin(t); }
  static Number b(const Number& t) { return 0.8 + 0.1 * cos(2.0 * t); }
  static Place a(const Number& t) { return {0.3 * sin(2.0 * t), 0.1 * cos(3.0 * t), 0.2 * t * t}; }
  static Place e(const Number& theta, const Number& phi) {
    return {sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta)};
  }
  static Place e1(const Number& t) { return e(0.5 + sin(t), 2.0 * t); }
  static Place e2(const Number& t) { return e(1.0 - 0.3 * t, cos(t)); }
  static std::array<Place, 3> places(const Number& t) {
    const Place r0 = a(t), r1 = reference::operator+(r0, reference::operator*(l(t), e1(t)));
    return {r0, r1, reference::operator+(r1, reference::operator*(b(t), e2(t)))};
  }

  /// Returns the k-th derivatives of the coordinates of points 0 to 2, point by point.
  static std::vector<double> derivative(double t, int k) {
    std::vector<double> result;
    for (const Place& r : places(Number::variable(t))) {
      for (const Number& x : r) result.push_back(x.derivative(k));
    }
    return result;
  }

  static System system(double t) {
    System result;
    result.positions = derivative(0.0, 0);
    result.masses = {1.0, masses[0], masses[1]};
    // The displacement from the initial position is a(t) - a(0).
    VectorFunction displacement;
    for (std::size_t k = 0; k < 3; ++k) {
      displacement.components[k] =
          ScalarFunction::custom([k](const Number& s) { return a(s)[k] - a(Number(0.0))[k].value(); });
    }
    result.supports = {{"", {0}, displacement}};
    result.constraints = {Rods{"l", {{0, 1}}, ScalarFunction::custom(l), {}},
                          Rods{"b", {{1, 2}}, ScalarFunction::custom(b), {}}};
    // Row 0 of K mu pulls point 1 along e1, and row 1 pulls points 1 and 2 along -e2 and e2.
    const Place u1 = e1(t), u2 = e2(t);
    const std::vector<double> w = derivative(t, 2);
    Vector3 f1, f2;
    for (std::size_t k = 0; k < 3; ++k) {
      f1[k] = masses[0] * w[3 + k] - multipliers[0] * u1[k].value() + multipliers[1] * u2[k].value();
      f2[k] = masses[1] * w[6 + k] - multipliers[1] * u2[k].value();
    }
    result.forces = {ConstantForce{"", {1}, f1}, ConstantForce{"", {2}, f2}};
    return result;
  }
};

class TwoRodsOnAMovingAnchor : public testing::TestWithParam<double> {
 protected:
  const double t = GetParam();
  Dynamics dynamics{TwoRods::system(t)};
  const std::vector<double> r = TwoRods::derivative(t, 0), v = TwoRods::derivative(t, 1);
};

TEST_P(TwoRodsOnAMovingAnchor, AccelerationsAreThoseOfTheMotion) {
  std::vector<double> w(9), lambda(2);

  const SolveReport report =
      dynamics.solve({.time = t, .positions = r, .velocities = v}, {.accelerations = w, .multipliers = lambda});

  ASSERT_TRUE(report.outcome.ok());
  EXPECT_LE((reference::vector(w) - reference::vector(TwoRods::derivative(t, 2))).norm(), 2e-14);
  EXPECT_NEAR(lambda[0], TwoRods::multipliers[0], 2e-14);
  EXPECT_NEAR(lambda[1], TwoRods::multipliers[1], 2e-14);
}

TEST_P(TwoRodsOnAMovingAnchor, AccelerationsAreSecondDifferencesOfThePositions) {
  // Difference of order 8: sum over k of c_k (r(t + k h) - 2 r(t) + r(t - k h))/h^2
  constexpr double h = 0.02, c[] = {8.0 / 5.0, -1.0 / 5.0, 8.0 / 315.0, -1.0 / 560.0};
  VectorXd difference = VectorXd::Zero(9);
  const VectorXd here = reference::vector(r);
  for (int k = 1; k <= 4; ++k) {
    const std::vector<double> after = TwoRods::derivative(t + k * h, 0), before = TwoRods::derivative(t - k * h, 0);
    difference += c[k - 1] / (h * h) * (reference::vector(after) - 2.0 * here + reference::vector(before));
  }
  std::vector<double> w(9);

  const SolveReport report = dynamics.solve({.time = t, .positions = r, .velocities = v}, {.accelerations = w});

  ASSERT_TRUE(report.outcome.ok());
  EXPECT_LE((reference::vector(w) - difference).norm(), 1e-9);
}

TEST_P(TwoRodsOnAMovingAnchor, StateOfTheMotionIsAdmissible) {
  EXPECT_LE(dynamics.position_violation({.time = t, .positions = r}), 1e-15);
  EXPECT_LE(dynamics.velocity_violation({.time = t, .positions = r, .velocities = v}), 1e-15);
}

TEST_P(TwoRodsOnAMovingAnchor, SupportCarriesThePullOfItsRod) {
  std::vector<double> carried(9);

  const SolveReport report = dynamics.solve({.time = t, .positions = r, .velocities = v}, {.support_forces = carried});

  ASSERT_TRUE(report.outcome.ok());

  // lambda_1 = -2.5 pulls, so that the anchor is drawn towards r1 by 2.5 N.
  const auto u = TwoRods::e1(t);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(carried[k], 2.5 * u[k].value(), 2e-14);
  for (std::size_t k = 3; k < 9; ++k) EXPECT_EQ(carried[k], 0.0);
}

INSTANTIATE_TEST_SUITE_P(Dynamics, TwoRodsOnAMovingAnchor, testing::Values(-0.4, 0.0, 0.3, 1.7));

// ---- any motion of any system ------------------------------------------------------------------------------------

/// Returns admissible accelerations, K'w = -phi, that are otherwise random.
VectorXd any_admissible(const reference::Mechanics& dense, std::mt19937& generator) {
  std::normal_distribution<double> normal;
  VectorXd w(dense.M.size());
  for (double& x : w) x = normal(generator);
  for (int pass = 0; pass < 2 && dense.K.cols() > 0; ++pass) {
    const Eigen::MatrixXd Gamma = dense.K.transpose() * dense.K;
    w -= dense.K * reference::solve_definite(Gamma, dense.K.transpose() * w + dense.phi);
  }
  return w;
}

RC_GTEST_PROP(ForwardDynamics, ForcesThatMakeAMotionGiveBackItsAccelerationsAndMultipliers, ()) {
  RandomSystem random = any_system({.forces = false});
  const auto dense = reference::make_mechanics(random.system, random.t, random.positions, random.velocities);
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  const VectorXd w = any_admissible(dense, generator);
  VectorXd mu(dense.K.cols());
  for (double& x : mu) x = normal(generator);
  // Inverse dynamics gives f = M w - K mu.
  const VectorXd f = dense.M.cwiseProduct(w) - dense.K * mu;
  for (Eigen::Index c = 0; c < f.size(); c += 3) {
    const auto point = static_cast<Index>(dense.coordinates[static_cast<std::size_t>(c)] / 3);
    random.system.forces.push_back(ConstantForce{"", {point}, Vector3{f[c], f[c + 1], f[c + 2]}});
  }

  const Solved solved(std::move(random));

  RC_ASSERT(solved.is_small(solved.w - w));
  const VectorXd root = dense.S().diagonal().cwiseSqrt();
  RC_ASSERT(root.cwiseProduct(solved.lambda - mu).norm() <=
            solved.accuracy * (solved.size + root.cwiseProduct(mu).norm()));
}

}  // namespace
}  // namespace tanor
