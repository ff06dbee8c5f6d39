#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <tanor/tanor.hpp>

#include "rough_scenes.hpp"

namespace tanor {
namespace {

struct Answer {
  SolveReport report;
  std::vector<double> w, lambda, eta, tau;
};

Answer solve(const System& system, const SolverOptions& options = {}) {
  Dynamics dynamics(system, options);
  Answer answer;
  answer.w.resize(system.positions.size());
  answer.eta.resize(answer.w.size());
  answer.tau.resize(answer.w.size());
  answer.lambda.resize(num_equations(system));
  answer.report = dynamics.solve({.time = 0.0, .positions = system.positions, .velocities = system.velocities},
                                 {.accelerations = answer.w,
                                  .multipliers = answer.lambda,
                                  .reactions = answer.eta,
                                  .friction_forces = answer.tau});
  return answer;
}

// ---- cases/04a ----

TEST(Friction, ABeadSlidesDownARoughIncline) {
  const Answer answer = solve(scenes::make_rough_incline(1.0, 0.3));
  ASSERT_TRUE(answer.report.outcome.ok()) << answer.report.outcome.what;
  EXPECT_NEAR(answer.w[0], 2.040604605562671562376062153, 1e-14);
  EXPECT_NEAR(answer.w[1], -1.178143618331198531287181354, 1e-14);
  EXPECT_NEAR(std::hypot(answer.eta[0], answer.eta[1]), 16.99141842225068624950424861, 1e-13);
  EXPECT_NEAR(std::hypot(answer.tau[0], answer.tau[1]), 0.3 * 16.99141842225068624950424861, 1e-13);
  EXPECT_EQ(answer.report.friction.uniqueness, Uniqueness::Proven);
  EXPECT_LE(answer.report.friction.residual, 1e-14);
}

TEST(Friction, ABeadAtRestSticksWhereMuReachesTheSlope) {
  const Answer held = solve(scenes::make_rough_incline(0.0, 0.58));
  ASSERT_TRUE(held.report.outcome.ok()) << held.report.outcome.what;
  EXPECT_EQ(held.report.friction.sticking, 1u);
  for (const double w : held.w) EXPECT_NEAR(w, 0.0, 2.0 * 9.81 * 2.2e-16);  // rounding of gravity
  // Friction carries the component of the weight that pulls downhill.
  EXPECT_NEAR(std::hypot(held.tau[0], held.tau[1]), 2.0 * 9.81 * 0.5, 1e-13);
  EXPECT_NEAR(std::hypot(held.eta[0], held.eta[1]), 16.99141842225068624950424861, 1e-13);

  const Answer slides = solve(scenes::make_rough_incline(0.0, 0.57));
  ASSERT_TRUE(slides.report.outcome.ok()) << slides.report.outcome.what;
  EXPECT_EQ(slides.report.friction.sticking, 0u);
  const double a = 9.81 * (0.5 - 0.57 * std::cos(std::numbers::pi / 6.0));
  EXPECT_NEAR(std::hypot(slides.w[0], slides.w[1]), a, 1e-13);
  EXPECT_LT(slides.w[1], 0.0);
}

// ---- cases/10b ----

using scenes::Rails;

TEST(Painleve, SolutionIsUniqueWhereTheCriterionHolds) {
  const Answer answer = solve(scenes::make_rails({0.4, 1.0}));
  ASSERT_TRUE(answer.report.outcome.ok()) << answer.report.outcome.what;
  EXPECT_EQ(answer.report.friction.uniqueness, Uniqueness::Proven);
  EXPECT_NEAR(answer.w[0], -0.40974901214841566341, 1e-12);
  EXPECT_NEAR(answer.w[3], -0.40974901214841566341, 1e-12);
  EXPECT_NEAR(answer.eta[1] - 0.0,
              4.5487450607420783170 + 5.4468519176786246638 * std::sin(75.0 * std::numbers::pi / 180.0), 1e-11);
}

TEST(Painleve, MissingSolutionIsReported) {
  const Answer answer = solve(scenes::make_rails({0.6, 30.0}));
  EXPECT_EQ(answer.report.outcome.status, Status::NoSolution);
  EXPECT_NE(answer.report.outcome.what.find("would have to jump"), std::string::npos) << answer.report.outcome.what;
  EXPECT_EQ(answer.report.friction.uniqueness, Uniqueness::None);
}

/// Both beads have the acceleration a, the rod holds the upper one: R cos(alpha) = f2 - m2 a, N = m1 g - R sin(alpha),
/// and
///
///   (m1 + m2) a = f1 + f2 - mu |N|,   so for s = sign N
///   a = (f1 + f2 - mu s (m1 g - f2 tan(alpha)))/(m1 + m2 + mu s m2 tan(alpha)),   if then s N > 0
std::vector<double> list_accelerations(const Rails& c) {
  const double slope = std::tan(c.alpha * std::numbers::pi / 180.0);
  std::vector<double> found;
  for (const double s : {-1.0, 1.0}) {
    const double a = (c.f1 + c.f2 - c.mu * s * (c.m1 * 9.81 - c.f2 * slope)) / (c.m1 + c.m2 + c.mu * s * c.m2 * slope);
    if (s * (c.m1 * 9.81 - (c.f2 - c.m2 * a) * slope) > 0.0) found.push_back(a);
  }
  return found;
}

/// Returns the first number of each bracket of "… (a, 0, 0) and (b, 0, 0) m/s^2 …" and expects zeros behind it.
std::vector<double> read_accelerations(const std::string& what) {
  std::vector<double> found;
  for (std::size_t at = what.find('(', what.find("obey the law")); at != std::string::npos;
       at = what.find('(', at + 1)) {
    std::array<double, 3> a{};
    if (std::sscanf(what.c_str() + at, "(%lf, %lf, %lf)", &a[0], &a[1], &a[2]) != 3) continue;
    EXPECT_EQ(a[1], 0.0);
    EXPECT_EQ(a[2], 0.0);
    found.push_back(a[0]);
  }
  return found;
}

TEST(Painleve, SeveralSolutionsAreToldWithTheirAccelerations) {
  for (const Rails& rails :
       {Rails{0.6, 1.0}, Rails{0.6, -30.0}, Rails{0.9, 5.0, 60.0, 0.1, 10.0}, Rails{0.9, -5.0, 60.0, 0.1, 10.0}}) {
    SCOPED_TRACE(rails.f2);
    std::vector<double> wanted = list_accelerations(rails);
    ASSERT_EQ(wanted.size(), 2u);

    const Answer answer = solve(scenes::make_rails(rails));

    EXPECT_EQ(answer.report.outcome.status, Status::NotUnique) << answer.report.outcome.what;
    EXPECT_EQ(answer.report.friction.uniqueness, Uniqueness::Several);
    std::vector<double> told = read_accelerations(answer.report.outcome.what);
    ASSERT_EQ(told.size(), 2u) << answer.report.outcome.what;
    std::ranges::sort(wanted);
    std::ranges::sort(told);
    for (std::size_t k = 0; k < 2; ++k)
      EXPECT_NEAR(told[k], wanted[k], 5e-4 * std::abs(wanted[k])) << k;  // four digits
  }
}

}  // namespace
}  // namespace tanor
