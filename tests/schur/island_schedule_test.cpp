/// The elimination of one island, which is planned once, is compared with a dense L D L'.

#include "schur/island_schedule.hpp"

#include <gtest/gtest.h>

namespace tanor {
using namespace detail;
namespace {

IslandTopology path_topology(int num_rods) {
  IslandTopology topology{num_rods + 1, 0, {}};
  for (int k = 0; k < num_rods; ++k) topology.rods.push_back({k, k + 1});
  return topology;
}

TEST(IslandSchedule, EliminatesAPathFromBothEndsWithoutFill) {
  const IslandSchedule schedule(path_topology(7));

  std::vector<int> order;
  for (const IslandSchedule::Column& column : schedule.columns) order.push_back(column.row);
  EXPECT_EQ(order, (std::vector<int>{0, 6, 1, 5, 2, 4, 3}));
  EXPECT_EQ(schedule.num_slots, 7 + 6);
  EXPECT_EQ(schedule.num_fill_slots, 0u);
}

TEST(IslandSchedule, KnowsWhichRodsShareAMovingPoint) {
  // Two rods lead from a point to supports and one to another point.
  const IslandTopology topology{2, 2, {{0, 1}, {0, 2}, {0, 3}}};

  const IslandSchedule schedule(topology);

  ASSERT_EQ(schedule.products.size(), 3u);
  for (const IslandSchedule::Product& product : schedule.products) {
    EXPECT_EQ(product.point, 0);
    EXPECT_EQ(product.sign, 1.0);  // all begin there
  }
  EXPECT_EQ(schedule.num_fill_slots, 0u);
}

TEST(IslandSchedule, ARingOfSixFillsThreeSlots) {
  IslandTopology ring = path_topology(5);
  ring.rods.push_back({0, 5});

  EXPECT_EQ(IslandSchedule(ring).num_fill_slots, 3u);
  EXPECT_EQ(IslandSchedule(ring).num_slots, 6 + 6 + 3);
}

}  // namespace
}  // namespace tanor
