/// Heavy tips on light chains and large coordinates lose digits by rounding, which refinement regains.

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "solved.hpp"

namespace tanor {
namespace {

using Eigen::VectorXd;

// ---- a heavy tip (docs/certificate.md) -----------------------------------------------------------------------------
//
//   (0)--o--o-- ... --o--O     20 rods, bead mass 1, tip mass R: cond S = 80 R, straight or bent.

RandomSystem make_heavy_tip(double ratio, double bend) {
  constexpr Index rods = 20;
  RandomSystem random;
  System& system = random.system;
  Rods group;
  double x = 0.0, z = 0.0;
  for (Index k = 0; k <= rods; ++k) {
    system.positions.insert(system.positions.end(), {x, 0.0, z});
    system.masses.push_back(k == rods ? ratio : 1.0);
    if (k > 0) group.pairs.push_back({k - 1, k});
    const double angle = bend * std::sin(1.7 * k);
    x += 0.1 * std::cos(angle);
    z += 0.1 * std::sin(angle);
  }
  system.supports = {{"", {0}, {}}};
  system.constraints = {group};
  system.forces = {Gravity{"", {3.0, 0.5, -9.81}}};
  random.positions = system.positions;
  std::mt19937 generator(5);
  std::normal_distribution<double> normal;
  for (Index c = 0; c < 3 * (rods + 1); ++c) random.velocities.push_back(normal(generator));
  Dynamics dynamics(system);
  (void)dynamics.project_velocities({.time = 0.0, .positions = random.positions, .velocities = random.velocities});
  return random;
}

struct HeavyTipCase {
  double ratio, bend;
  friend std::ostream& operator<<(std::ostream& out, const HeavyTipCase& tip) {
    return out << "ratio " << tip.ratio << ", bend " << tip.bend;
  }
};

class HeavyTip : public testing::TestWithParam<HeavyTipCase> {};

TEST_P(HeavyTip, RefinementBringsTheResidualToRounding) {
  const Solved solved(make_heavy_tip(GetParam().ratio, GetParam().bend));
  const reference::Mechanics& dense = solved.dense;

  ASSERT_TRUE(solved.report.outcome.ok()) << solved.report.outcome.what;
  EXPECT_LE(solved.report.residual, 1e-14);
  // The residual |K'w + phi| is found independently and compared with its terms.
  const VectorXd residual = dense.K.transpose() * solved.w + dense.phi;
  const VectorXd terms = dense.K.cwiseAbs().transpose() * solved.w.cwiseAbs() + dense.phi.cwiseAbs();
  EXPECT_LE(residual.lpNorm<Eigen::Infinity>(), 4e-15 * terms.lpNorm<Eigen::Infinity>());
}

TEST_P(HeavyTip, AccelerationsAndTensionsAreThoseOfTheKktMatrix) {
  const Solved solved(make_heavy_tip(GetParam().ratio, GetParam().bend));
  const reference::Solution expected = reference::solve_kkt(solved.dense);

  ASSERT_TRUE(solved.report.outcome.ok()) << solved.report.outcome.what;
  EXPECT_LE((solved.w - expected.w).norm(), 1e-12 * expected.w.norm());
  EXPECT_LE((solved.lambda - expected.lambda).norm(), 1e-12 * expected.lambda.norm());
}

// ---- the same in quadruple precision -------------------------------------------------------------------------------

__extension__ typedef __float128 Quad;

Quad root(Quad x) {
  Quad result = std::sqrt(static_cast<double>(x));
  for (int k = 0; k < 3; ++k) result = (result + x / result) / 2;
  return result;
}

/// Solves the rows a, each with its right side behind it, by Gaussian elimination with pivoting.
std::vector<Quad> solve(std::vector<std::vector<Quad>> a) {
  const std::size_t n = a.size();
  const auto size = [](Quad x) { return x < 0 ? -x : x; };
  for (std::size_t k = 0; k < n; ++k) {
    const auto pivot = std::max_element(a.begin() + static_cast<std::ptrdiff_t>(k), a.end(),
                                        [&](const auto& x, const auto& y) { return size(x[k]) < size(y[k]); });
    std::swap(a[k], *pivot);
    for (std::size_t i = k + 1; i < n; ++i) {
      const Quad factor = a[i][k] / a[k][k];
      if (factor == 0) continue;
      for (std::size_t j = k; j <= n; ++j) a[i][j] -= factor * a[k][j];
    }
  }
  std::vector<Quad> x(n);
  for (std::size_t k = n; k-- > 0;) {
    Quad sum = a[k][n];
    for (std::size_t j = k + 1; j < n; ++j) sum -= a[k][j] * x[j];
    x[k] = sum / a[k][k];
  }
  return x;
}

/// The equations of a chain on its support in w and lambda, with xi = |r_k - r_(k-1)| - l:
///
///   m w_k - u_k lambda_k + u_(k+1) lambda_(k+1) = m g
///   u_k.(w_k - w_(k-1)) = -(|dv|^2 - (u_k.dv)^2)/|dr|
struct QuadChain {
  explicit QuadChain(const RandomSystem& random) {
    const System& system = random.system;
    const std::size_t rods = system.num_points() - 1, n = 4 * rods;
    const Vector3 g = std::get<Gravity>(system.forces[0]).acceleration;
    gradients.resize(3 * rods);
    curvatures.resize(rods);
    std::vector<std::vector<Quad>> equations(n, std::vector<Quad>(n + 1, 0));
    for (std::size_t k = 0; k < rods; ++k) {
      Quad dr[3], dv[3], length2 = 0, speed2 = 0, along = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        dr[c] = Quad(random.positions[3 * (k + 1) + c]) - Quad(random.positions[3 * k + c]);
        dv[c] = Quad(random.velocities[3 * (k + 1) + c]) - (k > 0 ? Quad(random.velocities[3 * k + c]) : Quad(0));
        length2 += dr[c] * dr[c];
        speed2 += dv[c] * dv[c];
        along += dr[c] * dv[c];
      }
      const Quad length = root(length2), m = system.masses[k + 1];
      curvatures[k] = (speed2 - along * along / length2) / length;
      equations[3 * rods + k][n] = -curvatures[k];
      for (std::size_t c = 0; c < 3; ++c) {
        const Quad u = gradients[3 * k + c] = dr[c] / length;
        equations[3 * k + c][3 * k + c] = m;
        equations[3 * k + c][n] = m * Quad(g[c]);
        equations[3 * k + c][3 * rods + k] = -u;
        equations[3 * rods + k][3 * k + c] = u;
        if (k == 0) continue;
        equations[3 * (k - 1) + c][3 * rods + k] = u;
        equations[3 * rods + k][3 * (k - 1) + c] = -u;
      }
    }
    w = solve(equations);  // lambda behind w
  }
  std::vector<Quad> gradients, curvatures, w;
};

TEST_P(HeavyTip, EachBeadMovesAsInQuadruplePrecision) {
  const RandomSystem random = make_heavy_tip(GetParam().ratio, GetParam().bend);
  const QuadChain exact(random);
  const std::size_t rods = random.system.num_points() - 1;
  Dynamics dynamics(random.system);
  std::vector<double> w(3 * rods + 3), lambda(rods);

  ASSERT_TRUE(dynamics
                  .solve({.time = 0.0, .positions = random.positions, .velocities = random.velocities},
                         {.accelerations = w, .multipliers = lambda})
                  .outcome.ok());

  for (std::size_t k = 0; k < rods; ++k) {
    Quad residual = exact.curvatures[k];
    double error2 = 0.0, size2 = 0.0, terms = static_cast<double>(exact.curvatures[k]);
    for (std::size_t c = 0; c < 3; ++c) {
      const Quad here = w[3 * (k + 1) + c], before = k > 0 ? w[3 * k + c] : 0.0, u = exact.gradients[3 * k + c];
      residual += u * (here - before);
      terms += std::abs(static_cast<double>(u * here)) + std::abs(static_cast<double>(u * before));
      error2 += std::pow(static_cast<double>(here - exact.w[3 * k + c]), 2);
      size2 += std::pow(static_cast<double>(exact.w[3 * k + c]), 2);
    }
    EXPECT_LE(std::abs(static_cast<double>(residual)), 1e-12 * terms) << "rod " << k;
    EXPECT_LE(std::sqrt(error2), 1e-9 * std::sqrt(size2)) << "bead " << k + 1;
    const double tension = static_cast<double>(exact.w[3 * rods + k]);
    EXPECT_NEAR(lambda[k], tension, 1e-9 * std::abs(tension)) << "rod " << k;
  }
}

INSTANTIATE_TEST_SUITE_P(Dynamics, HeavyTip,
                         testing::Values(HeavyTipCase{1e3, 0.0}, HeavyTipCase{1e6, 0.0}, HeavyTipCase{1e9, 0.0},
                                         HeavyTipCase{1e12, 0.0}, HeavyTipCase{1e3, 0.3}, HeavyTipCase{1e6, 0.3},
                                         HeavyTipCase{1e9, 0.3}, HeavyTipCase{1e12, 0.3}));

// ---- far from the origin -----------------------------------------------------------------------------------------

RC_GTEST_PROP(ForwardDynamics, MovedAMillionLengthsAwayItAnswersTheSame, ()) {
  // After adding and subtracting the distance, no difference of two places is rounded.
  constexpr double away = 1 << 20;
  RandomSystem random = without_guides(any_system());
  for (Support& support : random.system.supports) support.displacement = {};  // they would be rounded there
  for (std::vector<double>* places : {&random.system.positions, &random.positions}) {
    for (double& x : *places) x = (x + away) - away;
  }
  RandomSystem moved = random;
  for (std::vector<double>* places : {&moved.system.positions, &moved.positions}) {
    for (double& x : *places) x += away;
  }

  const Solved here(random), far(std::move(moved));

  const double tolerance = here.accuracy;
  RC_ASSERT(far.report.outcome.ok());
  RC_ASSERT((far.w - here.w).norm() <= tolerance * here.size);
  RC_ASSERT(far.report.residual <= 1e-14);
}

RC_GTEST_PROP(ForwardDynamics, ProjectionConvergesAMillionLengthsAway, ()) {
  RandomSystem random = without_guides(any_system());
  for (double& x : random.system.positions) x += 1e6;
  for (double& x : random.positions) x += 1e6;
  Dynamics dynamics(random.system);

  const ProjectionReport positions = dynamics.project_positions({.time = random.t, .positions = random.positions});
  const ProjectionReport velocities =
      dynamics.project_velocities({.time = random.t, .positions = random.positions, .velocities = random.velocities});

  RC_ASSERT(positions.outcome.ok());
  RC_ASSERT(positions.violation <= 1e-8);
  RC_ASSERT(velocities.outcome.ok());
  RC_ASSERT(velocities.violation <= 1e-12);
}

}  // namespace
}  // namespace tanor
