/// Points are copied between an array and lanes.

#include "schur/lane_points.hpp"

#include <numeric>
#include <random>

#include <gtest/gtest.h>

namespace tanor {
using namespace detail;
namespace {

/// Draws lanes of `length` points: some are consecutive in the array, some are not, and some slots have no point.
template <std::size_t width>
std::vector<Index> draw_points(std::size_t length, std::mt19937* random) {
  std::vector<Index> places(width * length);
  std::iota(places.begin(), places.end(), 0);
  std::vector<Index> points(width * length, -1);
  for (std::size_t lane = 0; lane < width; ++lane) {
    const auto first = places.begin() + static_cast<std::ptrdiff_t>(lane * length);
    const auto kind = (*random)() % 4;
    if (kind == 1) std::shuffle(first, first + static_cast<std::ptrdiff_t>(length), *random);
    if (kind == 2) std::reverse(first, first + static_cast<std::ptrdiff_t>(length));
    const std::size_t there = kind == 3 ? length - (*random)() % length : length;
    for (std::size_t i = 0; i < there; ++i) points[i * width + lane] = places[lane * length + i];
  }
  return points;
}

template <std::size_t width>
void expect_round_trip(std::size_t length, std::mt19937* random) {
  const std::vector<Index> points = draw_points<width>(length, random);
  const LanePoints<width> lane_points(points);
  std::vector<double> from(3 * width * length), to(from.size(), -1.0);
  std::iota(from.begin(), from.end(), 1.0);
  std::vector<Pack3<width>> lanes(length);
  const auto at = [&](std::size_t i) -> auto& {
    return lanes[i];
  };

  lane_points.load_from(from.data(), at);
  for (std::size_t i = length; i-- > 0;) lane_points.store_inner(i, to.data(), at);
  lane_points.store_ends(to.data(), at);

  for (std::size_t k = 0; k < points.size(); ++k) {
    const auto lane = k % width, point = static_cast<std::size_t>(points[k]);
    const Pack3<width>& r = lanes[k / width];
    if (points[k] < 0) {
      EXPECT_EQ(r.x[lane] + r.y[lane] + r.z[lane], 0.0);
      continue;
    }
    EXPECT_EQ(r.x[lane], from[3 * point]);
    EXPECT_EQ(r.y[lane], from[3 * point + 1]);
    EXPECT_EQ(r.z[lane], from[3 * point + 2]);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(to[3 * point + c], from[3 * point + c]);
    to[3 * point] = -1.0;  // each belongs to one lane
  }
  for (std::size_t i = 0; i < to.size(); i += 3) EXPECT_EQ(to[i], -1.0);  // nobody else's
}

TEST(LanePoints, ComeBackFromLanesAsTheyWere) {
  std::mt19937 random(21);
  for (std::size_t length = 1; length <= 40; ++length) {
    expect_round_trip<8>(length, &random);
    expect_round_trip<2>(length, &random);
  }
}

}  // namespace
}  // namespace tanor
