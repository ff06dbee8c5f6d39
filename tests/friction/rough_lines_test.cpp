#include <gtest/gtest.h>

#include <tanor/tanor.hpp>

#include "friction/rough_lines.hpp"

namespace tanor {
namespace {

struct Tally {
  int unique = 0, several = 0, none = 0, failed = 0;
  double iterations = 0.0;
};

Tally try_scenes(FrictionMethod method) {
  Tally tally;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    const std::size_t count = seed % 3 == 0 ? 8 : seed % 3 == 1 ? 4 : 6;
    const double mu = std::array{0.3, 0.6, 0.9}[(seed / 3) % 3];
    const System system = make_rough_lines(seed, count, mu, seed % 2 == 0);
    const DenseFriction dense(system, mu);
    const std::vector<Eigen::VectorXd> all = dense.find_all();
    Dynamics dynamics(system, {.friction = method});
    std::vector<double> w(system.positions.size()), lambda(dynamics.num_equations());
    const SolveReport report =
        dynamics.solve({.time = 0.0, .positions = system.positions, .velocities = system.velocities},
                       {.accelerations = w, .multipliers = lambda});
    SCOPED_TRACE("seed " + std::to_string(seed) + ": " + report.outcome.what);
    if (all.size() == 1) {
      ++tally.unique;
      tally.iterations += report.friction.iterations;
      if (!report.outcome.ok()) {
        ++tally.failed;
        continue;
      }
      const Eigen::VectorXd found = reference::vector(lambda);
      EXPECT_LE(dense.residual(found), 1e-11);
      EXPECT_LE((found - all[0]).norm(), 1e-12 * std::pow(dense.dense.sqrt_condition(), 2) * all[0].norm());
      EXPECT_EQ(report.friction.uniqueness, Uniqueness::Proven);
    } else if (all.empty()) {
      ++tally.none;
      EXPECT_EQ(report.outcome.status, Status::NoSolution);
    } else {
      ++tally.several;
      EXPECT_EQ(report.outcome.status, Status::NotUnique);
    }
  }
  return tally;
}

TEST(FrictionOnRoughLines, UniqueScenesAreSolvedAndTheOthersDetected) {
  const Tally tally = try_scenes(FrictionMethod::Auto);
  EXPECT_EQ(tally.failed, 0);
  EXPECT_GT(tally.unique, 30);
  EXPECT_GT(tally.several, 5);
  EXPECT_GT(tally.none, 5);
}

TEST(FrictionOnRoughLines, NewtonNeedsAboutTwoSteps) {
  const Tally tally = try_scenes(FrictionMethod::Newton);
  EXPECT_EQ(tally.failed, 0);
  EXPECT_LE(tally.iterations / tally.unique, 3.0);
}

TEST(FrictionOnRoughLines, EnumerationAloneSolvesEveryScene) {
  const Tally tally = try_scenes(FrictionMethod::Enumeration);
  EXPECT_EQ(tally.failed, 0);
}

}  // namespace
}  // namespace tanor
