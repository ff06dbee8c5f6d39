#include "base/pack.hpp"

#include <array>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

namespace {

using namespace tanor;
using namespace tanor::detail;

std::array<double, 24> numbers_in_turn() {
  std::array<double, 24> result;
  std::iota(result.begin(), result.end(), 1.0);
  return result;
}

TEST(Pack, LoadsPointsThatFollowOneAnother) {
  const std::array<double, 24> numbers = numbers_in_turn();
  Pack<> x, y, z;
  load_points(numbers.data(), &x, &y, &z);
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    EXPECT_EQ(x[lane], numbers[3 * lane]);
    EXPECT_EQ(y[lane], numbers[3 * lane + 1]);
    EXPECT_EQ(z[lane], numbers[3 * lane + 2]);
  }
}

TEST(Pack, StoresPointsOneAfterTheOther) {
  const std::array<double, 24> numbers = numbers_in_turn();
  Pack<> x, y, z;
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    x[lane] = numbers[3 * lane];
    y[lane] = numbers[3 * lane + 1];
    z[lane] = numbers[3 * lane + 2];
  }
  std::array<double, 26> stored{};
  store_points(x, y, z, stored.data() + 1);  // at any address
  EXPECT_TRUE(std::equal(numbers.begin(), numbers.end(), stored.begin() + 1));
  EXPECT_EQ(stored.front(), 0.0);
  EXPECT_EQ(stored.back(), 0.0);
}

TEST(Pack, LargestIsNanWhereAnyNumberWasNan) {
  Largest largest;
  largest.value[3] = 5.0;
  EXPECT_EQ(largest.read(), 5.0);
  largest.zero[6] = std::nan("");
  EXPECT_TRUE(std::isnan(largest.read()));
}

/// Computes what a kernel may do with eight numbers, at addresses that are aligned to single numbers only.
template <std::size_t width>
std::array<double, 9> compute() {
  std::array<double, 9> a, b, c;
  for (std::size_t k = 0; k < 9; ++k) {
    a[k] = std::sin(1.0 + static_cast<double>(k));
    b[k] = std::exp(0.3 * static_cast<double>(k));
    c[k] = 0.0;
  }
  using Lanes = PackIn<width>;
  Lanes x = Lanes::at(&a[1]) + 0.5 * Lanes::at(&b[1]);
  x += Lanes::at(&a[1]) * Lanes::at(&b[1]);
  x -= Lanes::at(&b[1]);
  x.write(&c[1]);
  c[0] = x.sum();
  return c;
}

TEST(PackIn, GivesTheSameNumbersInRegistersOfAnyWidth) {
  const std::array<double, 9> of_two = compute<2>();
  for (std::size_t k = 1; k < 9; ++k) {
    const double a = std::sin(1.0 + static_cast<double>(k)), b = std::exp(0.3 * static_cast<double>(k));
    EXPECT_NEAR(of_two[k], a + 0.5 * b + a * b - b, 1e-14 * b);
  }
  EXPECT_EQ(of_two[0],
            ((of_two[1] + of_two[2]) + (of_two[3] + of_two[4])) + ((of_two[5] + of_two[6]) + (of_two[7] + of_two[8])));
  EXPECT_EQ(of_two, compute<4>());
  EXPECT_EQ(of_two, compute<8>());
}

/// Puts numbers into lanes one by one, into one lane, and into those from the sixth on.
template <std::size_t width>
std::array<double, 24> put_into_lanes() {
  using Lanes = PackIn<width>;
  const std::array<double, 8> others{-1.0, -2.0, -3.0, -4.0, -5.0, -6.0, -7.0, -8.0};
  std::array<double, 24> result{};
  const Lanes counted = Lanes::of([](auto lane) { return 1.0 + static_cast<double>(lane); });
  counted.write(&result[0]);
  counted.template with<3>(0.5).write(&result[8]);
  counted.blended_with(Lanes::at(others.data()), [](std::size_t lane) { return lane >= 5; }).write(&result[16]);
  return result;
}

TEST(PackIn, PutsNumbersIntoTheirLanes) {
  const std::array<double, 24> wanted{1, 2, 3, 4, 5, 6, 7, 8, 1, 2, 3, 0.5, 5, 6, 7, 8, 1, 2, 3, 4, 5, -6, -7, -8};
  EXPECT_EQ(put_into_lanes<2>(), wanted);
  EXPECT_EQ(put_into_lanes<4>(), wanted);
  EXPECT_EQ(put_into_lanes<8>(), wanted);
}

TEST(PackIn, LimitsItsRegistersSoThatTheFactorsOfAProductFitBeside) {
  EXPECT_EQ(PackIn<8>::most_in_registers, 28U);
  EXPECT_EQ(PackIn<4>::most_in_registers, 6U);
  EXPECT_EQ(PackIn<2>::most_in_registers, 3U);
}

}  // namespace
