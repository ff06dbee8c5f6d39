/// Errors of a step are divided by their tolerances, eight points at once.

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "dynamics/workspace.hpp"

namespace tanor {
using namespace detail;
namespace {

constexpr double atol = 1e-3, rtol = 1e-2;

struct Step {
  Workspace work;
  std::vector<double> error, from, to;

  explicit Step(std::size_t points, int threads = 1) : work(make_system(points), {.threads = threads}, 0.0) {
    std::mt19937 random(static_cast<std::uint32_t>(points));
    std::normal_distribution<double> normal;
    for (std::vector<double>* array : {&error, &from, &to}) {
      array->resize(3 * points);
      for (double& x : *array) x = normal(random);
    }
  }
  static System make_system(std::size_t points) {
    System system;
    for (std::size_t i = 0; i < points; ++i)
      system.positions.insert(system.positions.end(), {static_cast<double>(i), 0.0, 0.0});
    system.masses.assign(points, 1.0);
    return system;
  }
  ErrorRatios ratios() const {
    const std::vector<double> none(error.size(), 0.0);
    return work.error_ratios({error.data(), none.data(), from.data(), from.data(), to.data(), to.data()}, atol, rtol);
  }
  double one_by_one() const {
    double worst = 0.0;
    for (std::size_t i = 0; i < error.size(); i += 3) {
      double size = 0.0;
      for (std::size_t c = i; c < i + 3; ++c) size += std::max(from[c] * from[c], to[c] * to[c]);
      worst = std::max(worst, norm(load(error.data(), i / 3)) / (atol + rtol * std::sqrt(size)));
    }
    return worst;
  }
};

TEST(ErrorRatios, AreTheLargestOverThePoints) {
  for (std::size_t points = 1; points <= 40; ++points) {
    for (std::size_t worst = 0; worst < points; ++worst) {
      Step step(points);
      step.error[3 * worst + worst % 3] = 100.0;
      EXPECT_DOUBLE_EQ(step.ratios().x, step.one_by_one()) << points << ", " << worst;
      EXPECT_EQ(step.ratios().v, 0.0);
    }
  }
}

TEST(ErrorRatios, AreNanWhereAnErrorIsNan) {
  for (const std::size_t place : {0, 7, 8, 30, 38}) {
    Step step(39);
    step.error[3 * place + 1] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(std::isnan(step.ratios().x)) << place;
    EXPECT_TRUE(std::isnan(step.ratios().largest())) << place;
  }
}

TEST(ErrorRatios, AreTheSameForAnyNumberOfThreads) {
  const double one = Step(20001).ratios().x;
  for (const int threads : {2, 3, 7}) EXPECT_EQ(Step(20001, threads).ratios().x, one) << threads;
}

}  // namespace
}  // namespace tanor
