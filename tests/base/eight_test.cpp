#include "base/eight.hpp"

#include <array>
#include <numeric>

#include <gtest/gtest.h>

namespace {

using namespace tanor;

std::array<double, 24> numbers_in_turn() {
  std::array<double, 24> result;
  std::iota(result.begin(), result.end(), 1.0);
  return result;
}

TEST(Eight, LoadsPointsThatFollowOneAnother) {
  const std::array<double, 24> numbers = numbers_in_turn();
  Eight x, y, z;
  load_points(numbers.data(), &x, &y, &z);
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    EXPECT_EQ(x[lane], numbers[3 * lane]);
    EXPECT_EQ(y[lane], numbers[3 * lane + 1]);
    EXPECT_EQ(z[lane], numbers[3 * lane + 2]);
  }
}

TEST(Eight, StoresPointsOneAfterTheOther) {
  const std::array<double, 24> numbers = numbers_in_turn();
  Eight x, y, z;
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

TEST(Eight, TheLargestIsNoNumberWhereAnyWasNone) {
  Largest largest;
  largest.value[3] = 5.0;
  EXPECT_EQ(largest.read(), 5.0);
  largest.zero[6] = std::nan("");
  EXPECT_TRUE(std::isnan(largest.read()));
}

}  // namespace
