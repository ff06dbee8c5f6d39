/// Positions off the constraints are put on them, however far, and the report tells how far and by which turn.

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "host/velocity_verlet.hpp"

namespace tanor::host {
namespace {

TEST(ProjectPositions, FindsTheNearestPositions) {
  const std::vector<double> drawn{0, 0, 0, 0, 0, -1};
  std::vector<double> r{0, 0, 0, 3, 0, -4};
  Constrainer constrainer(std::vector{infinity, 2.0}, {Rods{"rods", {{0, 1}}, {}, {}}}, drawn);

  const ConstraintReport report = constrainer.project_positions(r);

  ASSERT_TRUE(report.outcome.ok());
  EXPECT_NEAR(r[3], 0.6, 1e-14);
  EXPECT_NEAR(r[5], -0.8, 1e-14);
  EXPECT_NEAR(report.correction, 4.0, 1e-13);
}

/// A bob off the end of its rod comes straight back, so the rod turns by nothing; one that goes back to a plane turns
/// the rod that hangs on it.
TEST(ProjectPositions, TellsTheTurnOfARodWhoseBobLeavesAPlane) {
  const std::vector<double> drawn{0, 0, 0, 3, 0, 0};
  const Planes floor{"floor", {1}, Vector3{0, 0, 1}, 0.0};
  std::vector<double> straight{0, 0, 0, 0, 0, 7}, r{0, 0, 0, 3, 0, 0.4};

  Constrainer pendulum(std::vector{infinity, 2.0}, {Rods{"rods", {{0, 1}}, {}, {}}}, drawn);
  EXPECT_NEAR(pendulum.project_positions(straight).largest_turn, 0.0, 1e-15);

  Constrainer constrainer(std::vector{infinity, 2.0}, {Rods{"rods", {{0, 1}}, {}, {}}, floor}, drawn);
  const ConstraintReport report = constrainer.project_positions(r);
  ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
  EXPECT_NEAR(report.largest_turn, std::atan2(0.4, 3.0), 1e-13);
  EXPECT_EQ(report.virial, (std::array<double, 6>{}));
  EXPECT_EQ(report.work, 0.0);
}

/// Chains, rings and a support; some rods of length 1 start with 0.5 or 2, and some turn by more than a right angle.
TEST(ProjectPositions, TellsTheLargestTurnOfAllRodsAndMayDoSoInPlace) {
  constexpr std::size_t count = 12;
  std::vector<double> masses(count, 1.5), drawn, start;
  masses[4] = infinity;
  for (std::size_t i = 0; i < count; ++i) {
    const auto k = static_cast<double>(i);
    drawn.insert(drawn.end(), {0.8 * k, 0.6 * static_cast<double>(i % 2), 0.3 * std::sin(k)});
    start.insert(start.end(), {0.8 * k + 0.6 * std::sin(3.0 * k), 0.5 * std::cos(7.0 * k), 0.4 * std::sin(k * k)});
  }
  for (std::size_t d = 0; d < 3; ++d) start[12 + d] = drawn[12 + d];
  Rods rods = make_chain_of_rods(count);
  rods.pairs.push_back({0, 2});
  rods.pairs.push_back({9, 11});
  Constrainer constrainer(masses, {rods}, drawn);
  const std::vector<double> noise(5, 7.0);
  std::vector<double> packed = start, wide(noise);
  for (std::size_t i = 0; i < count; ++i) {
    wide.insert(wide.end(), start.begin() + static_cast<std::ptrdiff_t>(3 * i),
                start.begin() + static_cast<std::ptrdiff_t>(3 * i + 3));
    wide.push_back(7.0);
  }

  const ConstraintReport report = constrainer.project_positions(packed);
  const ConstraintReport of_wide =
      constrainer.project_positions({wide.data() + noise.size(), 4 * static_cast<std::ptrdiff_t>(sizeof(double))});

  ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
  double turn = 0.0;
  for (const std::array<Index, 2>& pair : rods.pairs) {
    const auto end = [&](const std::vector<double>& r, std::size_t k) {
      return Eigen::Map<const Eigen::Vector3d>(&r[3 * static_cast<std::size_t>(pair[k])]);
    };
    const Eigen::Vector3d before = end(start, 1) - end(start, 0), after = end(packed, 1) - end(packed, 0);
    turn = std::max(turn, std::atan2(before.cross(after).norm(), before.dot(after)));
  }
  EXPECT_NEAR(report.largest_turn, turn, 1e-12);
  EXPECT_GT(turn, 1.0);
  EXPECT_EQ(of_wide.largest_turn, report.largest_turn);
}

TEST(ProjectPositions, TellsNoTurnAfterAFailure) {
  const std::vector<double> drawn{0, 0, 0, 1, 0, 0};
  std::vector<double> r{0, 0, 0, 0, 0, 0};  // the rod has no direction
  Constrainer constrainer(std::vector{infinity, 2.0}, {Rods{"rods", {{0, 1}}, {}, {}}}, drawn);

  const ConstraintReport report = constrainer.project_positions(r);

  EXPECT_FALSE(report.outcome.ok());
  EXPECT_EQ(report.largest_turn, 0.0);
}

}  // namespace
}  // namespace tanor::host
