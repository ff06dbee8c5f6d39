#include "statics/standing_corner.hpp"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "motion/corner_scenes.hpp"

namespace tanor {
namespace {

/// A corner is near as the points are placed, wherever they started.
TEST(StandingCorner, IsNearByTheGivenPositions) {
  for (const double start : {1e-6, 1.0, 1e6}) {
    System system = make_bead_on_v();
    system.positions = {start, 0.0, start};
    const std::vector<double> beside{1e-4, 0.0, 1e-4}, in{1e-10, 0.0, 1e-10, 1.0, 0.0, 0.0};
    EXPECT_EQ(detail::find_standing_corner(system, 0.0, beside, beside), "") << start;
    EXPECT_EQ(detail::find_standing_corner(system, 0.0, in, in), "the corner of abs(x1) in wire") << start;
  }
}

}  // namespace
}  // namespace tanor
