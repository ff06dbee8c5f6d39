#include "schur/multiplier_history.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace tanor {
using namespace detail;
namespace {

std::vector<double> motion(double t) {
  return {1.0 - 2.0 * t + 3.0 * t * t, 0.5 * t * t - t, 4.0};
}

std::vector<double> guess(const MultiplierHistory& history, double t) {
  std::vector<double> lambda(3, -1.0);
  history.extrapolate(Parallel(1), t, &lambda);
  return lambda;
}

void expect_near(const std::vector<double>& a, const std::vector<double>& b, double tolerance) {
  for (std::size_t k = 0; k < a.size(); ++k) EXPECT_NEAR(a[k], b[k], tolerance) << k;
}

TEST(MultiplierHistoryTest, LeavesTheGuessWhereNothingIsKnown) {
  EXPECT_EQ(guess(MultiplierHistory(3), 1.0), std::vector<double>(3, -1.0));
}

TEST(MultiplierHistoryTest, IsExactForParabolasInAnyOrderOfTime) {
  MultiplierHistory history(3);
  for (const double t : {5.0, 0.25, 1.0, 0.5}) history.add(t, motion(t));

  expect_near(guess(history, 1.25), motion(1.25), 1e-13);
}

TEST(MultiplierHistoryTest, ANewSolutionOfTheSameTimeTakesThePlaceOfTheOld) {
  MultiplierHistory history(3);
  history.add(1.0, motion(1.0));
  history.add(0.0, motion(0.0));
  history.add(1.0, {7.0, 7.0, 7.0});

  EXPECT_EQ(guess(history, 1.0), std::vector<double>(3, 7.0));
  expect_near(guess(history, 0.0), motion(0.0), 1e-15);
}

/// Three solutions at nearly the same time tell nothing about a curvature, so that the last one alone is taken.
TEST(MultiplierHistoryTest, TakesTheLastSolutionAloneFarFromAllTimes) {
  MultiplierHistory history(3);
  std::vector<double> last;
  for (const double t : {1.0, 1.001, 1.002}) history.add(t, last = motion(t));

  EXPECT_EQ(guess(history, 2.0), last);
}

TEST(MultiplierHistoryTest, GoesOnFromItsNumbers) {
  MultiplierHistory history(3), copy(3);
  for (const double t : {0.25, 1.0, 0.5}) history.add(t, motion(t));
  std::vector<double> numbers;
  Memory written(&numbers);
  history.exchange_memory(written);
  copy.add(3.0, motion(1.0));

  Memory read{std::span<const double>(numbers)};
  copy.exchange_memory(read);
  read.finish();

  EXPECT_EQ(guess(copy, 1.2), guess(history, 1.2));
}

TEST(MultiplierHistoryTest, NumbersThatNoHistoryWritesAreRefused) {
  const auto read = [](const std::vector<double>& numbers) {
    MultiplierHistory history(1);
    Memory memory{std::span<const double>(numbers)};
    history.exchange_memory(memory);
    memory.finish();
  };

  EXPECT_NO_THROW(read({2, 1.0, 5.0, 2.0, 6.0, 0.0, 0.0}));
  EXPECT_THROW(read({2, 1.0, 5.0, 1.0, 6.0, 0.0, 0.0}), InputError) << "two of one time";
  EXPECT_THROW(read({4, 1.0, 5.0, 2.0, 6.0, 3.0, 0.0}), InputError) << "it keeps three";
  EXPECT_THROW(read({-1, 1.0, 5.0, 2.0, 6.0, 3.0, 0.0}), InputError);
  EXPECT_THROW(read({0.5, 1.0, 5.0, 2.0, 6.0, 3.0, 0.0}), InputError);
  EXPECT_THROW(read({2, 1.0, 5.0, 2.0, 6.0, 0.0}), InputError) << "too few";
  EXPECT_THROW(read({2, 1.0, 5.0, 2.0, 6.0, 0.0, 0.0, 0.0}), InputError) << "too many";
}

}  // namespace
}  // namespace tanor
