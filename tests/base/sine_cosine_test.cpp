#include "base/sine_cosine.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace tanor {
using namespace detail;
namespace {

/// Returns the error in units in the last place of the larger of |wanted| and 1e-3. Near their zeros sine and cosine
/// are differences of larger numbers.
double ulps(double found, long double wanted) {
  const double size = std::max(1e-3, static_cast<double>(std::abs(wanted)));
  const double unit = std::nextafter(size, 2.0) - size;
  return static_cast<double>(std::abs(static_cast<long double>(found) - wanted)) / unit;
}

double worst_of(double x) {
  double sine = 0.0, cosine = 0.0;
  sine_cosine(x, &sine, &cosine);
  const auto exact = static_cast<long double>(x);
  return std::max(ulps(sine, std::sin(exact)), ulps(cosine, std::cos(exact)));
}

TEST(SineCosine, AgreeWithLongDoubleToAnUlp) {
  std::mt19937 generator(1);
  for (const double most : {1e-8, 0.7, 3.0, 100.0, 1e4, largest_angle}) {
    std::uniform_real_distribution<double> any(-most, most);
    double worst = 0.0;
    for (int k = 0; k < 200'000; ++k) worst = std::max(worst, worst_of(any(generator)));
    EXPECT_LE(worst, 1.0) << most;
  }
}

TEST(SineCosine, AgreeToAnUlpBesideMultiplesOfARightAngle) {
  for (int n = -600'000; n <= 600'000; n += 997) {
    const double x = n * (0.5 * std::numbers::pi);
    for (const double each : {x, std::nextafter(x, 1e9), std::nextafter(x, -1e9)}) ASSERT_LE(worst_of(each), 1.0) << x;
  }
}

TEST(SineCosine, AreExactAtZero) {
  double sine = 1.0, cosine = 0.0;
  sine_cosine(0.0, &sine, &cosine);
  EXPECT_EQ(sine, 0.0);
  EXPECT_EQ(cosine, 1.0);
}

}  // namespace
}  // namespace tanor
