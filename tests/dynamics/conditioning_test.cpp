/// Heavy tips on light chains, large coordinates: what rounding does, and refinement undoes.

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "solved.hpp"

namespace tanor {
namespace {

using Eigen::VectorXd;

// ---- a heavy tip (theory, section 8) -----------------------------------------------------------------------------
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
  (void)dynamics.project_velocities(0.0, random.positions, random.velocities);
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
  // |K'w + phi| against its terms, found independently
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

INSTANTIATE_TEST_SUITE_P(Dynamics, HeavyTip,
                         testing::Values(HeavyTipCase{1e3, 0.0}, HeavyTipCase{1e6, 0.0}, HeavyTipCase{1e9, 0.0},
                                         HeavyTipCase{1e12, 0.0}, HeavyTipCase{1e3, 0.3}, HeavyTipCase{1e6, 0.3},
                                         HeavyTipCase{1e9, 0.3}, HeavyTipCase{1e12, 0.3}));

// ---- far from the origin -----------------------------------------------------------------------------------------

RC_GTEST_PROP(NormalForm, MovedAMillionLengthsAwayItAnswersTheSame, ()) {
  const RandomSystem random = without_guides(any_system());
  RandomSystem moved = random;
  for (double& x : moved.system.positions) x += 1e6;
  for (double& x : moved.positions) x += 1e6;

  const Solved here(random), far(std::move(moved));

  // Differences of positions carry eps 1e6 = 2e-10 of absolute rounding.
  const double tolerance = 1e-9 * std::pow(here.dense.sqrt_condition(), 2);
  RC_ASSERT(far.report.outcome.ok());
  RC_ASSERT((far.w - here.w).norm() <= tolerance * here.size);
  RC_ASSERT(far.report.residual <= 1e-14);
}

RC_GTEST_PROP(NormalForm, ProjectionConvergesAMillionLengthsAway, ()) {
  RandomSystem random = without_guides(any_system());
  for (double& x : random.system.positions) x += 1e6;
  for (double& x : random.positions) x += 1e6;
  Dynamics dynamics(random.system);

  const ProjectionReport positions = dynamics.project_positions(random.t, random.positions);
  const ProjectionReport velocities = dynamics.project_velocities(random.t, random.positions, random.velocities);

  RC_ASSERT(positions.outcome.ok());
  RC_ASSERT(positions.violation <= 1e-8);
  RC_ASSERT(velocities.outcome.ok());
  RC_ASSERT(velocities.violation <= 1e-12);
}

}  // namespace
}  // namespace tanor
