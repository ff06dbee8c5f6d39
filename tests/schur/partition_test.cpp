/// Parts consist of whole islands and have similar sizes.

#include "schur/gram_solver.hpp"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace tanor {
using namespace detail;
namespace {

std::vector<Index> any_islands(int most_islands, int most_rows) {
  const int islands = *rc::gen::inRange(1, most_islands).as("islands");
  std::mt19937 generator(*rc::gen::arbitrary<std::uint32_t>().as("seed"));
  std::vector<Index> start{0};
  for (int k = 0; k < islands; ++k) {
    start.push_back(start.back() + std::uniform_int_distribution<Index>(1, most_rows)(generator));
  }
  return start;
}

RC_GTEST_PROP(Partition, PartsCoverAllRowsByWholeIslands, ()) {
  const std::vector<Index> islands = any_islands(400, 300);

  const std::vector<Index> parts = partition_islands(islands);

  RC_ASSERT(parts.front() == 0 && parts.back() == islands.back());
  RC_ASSERT(parts.size() <= 17U);
  RC_ASSERT(std::adjacent_find(parts.begin(), parts.end(), std::greater_equal<>()) == parts.end());
  RC_ASSERT(std::includes(islands.begin(), islands.end(), parts.begin(), parts.end()));
}

RC_GTEST_PROP(Partition, NoPartIsMuchLargerThanAnEqualShare, ()) {
  const std::vector<Index> islands = any_islands(400, 300);

  const std::vector<Index> parts = partition_islands(islands);

  // Each cut is at most one island late.
  const Index share = islands.back() / static_cast<Index>(parts.size() - 1);
  for (std::size_t p = 0; p + 1 < parts.size(); ++p) RC_ASSERT(parts[p + 1] - parts[p] <= share + 300 + 1);
}

TEST(Partition, SmallSystemsStayWhole) {
  const std::vector<Index> islands = {0, 100, 200, 500};

  EXPECT_EQ(partition_islands(islands), (std::vector<Index>{0, 500}));
}

TEST(Partition, OneIslandIsOnePartHoweverLarge) {
  const std::vector<Index> islands = {0, 1000000};

  EXPECT_EQ(partition_islands(islands), (std::vector<Index>{0, 1000000}));
}

TEST(Partition, EqualIslandsGiveSixteenEqualParts) {
  std::vector<Index> islands;
  for (Index k = 0; k <= 320; ++k) islands.push_back(99 * k);

  const std::vector<Index> parts = partition_islands(islands);

  ASSERT_EQ(parts.size(), 17U);
  for (Index p = 0; p <= 16; ++p) EXPECT_EQ(parts[static_cast<std::size_t>(p)], 20 * 99 * p);
}

/// Sixteen equal parts on more threads than parts, or on as many.
TEST(RunsAlone, OnlyWhereThreadsOfItsOwnMakeAPartFaster) {
  for (const int threads : {2, 16, 17, 64}) {
    EXPECT_FALSE(runs_alone(1.0, 16.0, threads, false)) << threads;
    EXPECT_EQ(runs_alone(1.0, 16.0, threads, true), threads > 16) << threads;
  }
  EXPECT_FALSE(runs_alone(1.1, 2.1, 2, false));
  EXPECT_TRUE(runs_alone(1.1, 2.1, 2, true));
  EXPECT_FALSE(runs_alone(1.0, 1.0, 1, true));
}

TEST(Partition, NoRowsGiveNoParts) {
  const std::vector<Index> islands = {0};

  EXPECT_EQ(partition_islands(islands), (std::vector<Index>{0}));
}

}  // namespace
}  // namespace tanor
