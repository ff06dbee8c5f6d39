/// Frames and nets that are singular where they hang or turn: a taut edge, two triangles on a hinge.

#include <cmath>

#include <gtest/gtest.h>
#include <tanor/motion.hpp>

#include "base/parallel.hpp"
#include "motion/method_options.hpp"
#include "scenes.hpp"

namespace tanor {
using namespace detail;
namespace {

/// Makes a flat net of 10 x 10 points that hangs from two adjacent corners, so that the edge between them is taut. Rods
/// are as long as drawn.
System make_net_on_adjacent_corners() {
  System system = scenes::make_hung_net(10);
  std::get<Rods>(system.constraints[0]).length = {};
  return system;
}

TEST(SingularNets, NetOnAdjacentCornersHangsFromItsTautEdge) {
  std::vector<std::vector<double>> ends;
  for (const Method method : sampled_methods) {
    Simulation simulation(make_net_on_adjacent_corners(), with(method, 2.5e-4));
    EXPECT_EQ(simulation.plan().prestress_rigid_points, (std::vector<Index>{1, 2, 3, 4, 5, 6, 7, 8}));
    EXPECT_EQ(simulation.rank().dependences.size(), 9U);
    EXPECT_EQ(
        simulation.rank().dependences[0].what.find("is held rigid by prestress between supports") != std::string::npos,
        true);

    ASSERT_TRUE(simulation.advance_to(0.1).ok()) << simulation.outcome().what;

    EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), 1e-6);
    for (std::size_t i = 0; i < 10; ++i) EXPECT_EQ(simulation.positions()[3 * i + 2], 0.0);
    EXPECT_LT(simulation.positions()[3 * 99 + 2], -0.01) << "the far edge falls";
    ends.emplace_back(simulation.positions().begin(), simulation.positions().end());
  }
  for (std::size_t i = 0; i < ends[0].size(); ++i) {
    EXPECT_NEAR(ends[0][i], ends[1][i], 1e-8);
    EXPECT_NEAR(ends[2][i], ends[1][i], 1e-5);
  }
}

TEST(SingularNets, DiamondOfFiveRodsKeepsItsEnergyForALongTime) {
  // Atoms 0, 1, 2 are a triangle and 3 is on the other side of 1-2, so that two triangles meet at a hinge.
  const double l01 = 0.4904, l02 = 0.6019, l12 = 0.2719, l31 = 0.7237, l32 = 0.5376;
  const double x2 = (l01 * l01 + l02 * l02 - l12 * l12) / (2 * l01), y2 = std::sqrt(l02 * l02 - x2 * x2);
  const double a = (l31 * l31 + l12 * l12 - l32 * l32) / (2 * l12), h = std::sqrt(l31 * l31 - a * a);
  const double ex = (x2 - l01) / l12, ey = y2 / l12;
  System system;
  system.positions = {0,
                      0,
                      0,
                      l01,
                      0,
                      0,
                      x2,
                      y2,
                      0,
                      l01 + a * ex + h * std::cos(2.0) * ey,
                      a * ey - h * std::cos(2.0) * ex,
                      h * std::sin(2.0)};
  system.velocities = {0.3, -1.0, 0.5, 0.2, 0.9, -0.4, -0.7, 0.1, 1.1, 0.6, -0.2, -0.8};
  system.masses = {12, 14, 12, 16};
  system.constraints = {
      Rods{"rods", {{0, 1}, {0, 2}, {1, 2}, {3, 1}, {3, 2}}, std::vector{l01, l02, l12, l31, l32}, {}}};
  // The motion is chaotic. The energy goes to and fro by some h^2, which depends on the last bits: up to 1e-5 with
  // steps of 1e-3.
  MotionOptions options = with(Method::Rattle, 5e-4);
  options.start = StartMode::Project;
  Simulation simulation(system, options);
  double largest = 0.0;

  const Outcome outcome = simulation.advance_to(50.0, [&](const MotionReport& report) {
    largest = larger(largest, std::abs(report.energy.drift_relative()));
    return true;
  });

  ASSERT_TRUE(outcome.ok()) << outcome.what;
  EXPECT_EQ(simulation.report().steps, 100'000U);
  EXPECT_LT(largest, 1e-5);
}

}  // namespace
}  // namespace tanor
