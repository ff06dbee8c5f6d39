#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <tanor/tanor.hpp>

#include "motion/rough_guides.hpp"

/// \file Dozens of contacts and more that rods couple, and that hold more than can move.
namespace tanor {
namespace {

TEST(Many, AChainThatIsDraggedOverAFloorComesOffBeadByBead) {
  System system;
  Rods rods{"rods", {}, {}, {}};
  Planes floor{"floor", {}, Vector3{0.0, 0.0, 1.0}, 0.0};
  for (Index k = 0; k <= 60; ++k) {
    system.positions.insert(system.positions.end(), {0.05 * k, 0.0, 0.0});
    system.masses.push_back(0.02);
    floor.points.push_back(k);
    if (k > 0) rods.pairs.push_back({k - 1, k});
  }
  system.constraints = {rods, floor};
  const VectorFunction pull{ScalarFunction::formula("2*t"), ScalarFunction::formula("0.5*t"), 0.0};
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}, ConstantForce{"pull", {60}, pull}};
  system.friction = {Coulomb{.name = "", .at = {"floor"}, .coefficient = 0.3, .static_coefficient = 0.35}};
  Simulation simulation(system, {.rtol = 1e-6, .atol = 1e-8});
  // Rods along x hold nothing across it: the last bead comes off where 0.5 t, and what it holds along x, are its limit.
  const std::vector<double> events = advance_and_list_events(&simulation, 1.2);
  ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
  ASSERT_FALSE(events.empty());
  const double limit = 0.35 * 0.02 * 9.81;
  EXPECT_NEAR(events[0], limit / std::hypot(2.0 / 61.0, 0.5), 1e-6);
  EXPECT_GT(simulation.velocities()[3 * 60 + 1], 0.01);
  for (std::size_t k = 0; k < 3 * 45; ++k) EXPECT_NEAR(simulation.velocities()[k], 0.0, 1e-13) << k;
  EXPECT_LE(std::abs(simulation.report().energy.drift_relative()), 1e-5);
}

TEST(Many, AThousandBeadsThatRodsCoupleComeToRest) {
  constexpr std::size_t count = 1000, group = 5;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> angle(-0.01, 0.01), mass(0.5, 1.5), speed(0.7, 1.3);
  System system;
  Rods rods{"rods", {}, {}, {}};
  std::vector<std::string> wires;
  double u = 1.0, last = 0.0;
  for (std::size_t k = 0; k < count; ++k) {
    const double a = angle(random), x = k % 2 == 0 ? 0.0 : 0.05, y = 0.1 * static_cast<double>(k);
    if (k % group == 0) {
      u = speed(random);
    } else {
      // The rod keeps its length: (dx, dy).(u d - u_last d_last) = 0
      const double dx = k % 2 == 0 ? -0.05 : 0.05, dy = 0.1;
      u *= (dx * std::cos(last) + dy * std::sin(last)) / (dx * std::cos(a) + dy * std::sin(a));
      rods.pairs.push_back({static_cast<Index>(k) - 1, static_cast<Index>(k)});
    }
    last = a;
    system.positions.insert(system.positions.end(), {x, y, 0.0});
    system.velocities.insert(system.velocities.end(), {u * std::cos(a), u * std::sin(a), 0.0});
    system.masses.push_back(mass(random));
    wires.push_back("wire" + std::to_string(k));
    system.constraints.push_back(
        Lines{wires.back(), {static_cast<Index>(k)}, Vector3{x, y, 0.0}, Vector3{std::cos(a), std::sin(a), 0.0}});
  }
  system.constraints.push_back(rods);
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  system.friction = {Coulomb{.name = "", .at = wires, .coefficient = 0.3}};
  Simulation simulation(system, {.rtol = 1e-6, .atol = 1e-8});
  const std::vector<double> events = advance_and_list_events(&simulation, 1.0);
  ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
  EXPECT_EQ(events.size(), count / group);
  for (const double v : simulation.velocities()) EXPECT_NEAR(v, 0.0, 1e-15);
  EXPECT_EQ(simulation.snapshot().discrete_state, std::vector<int>(count, 1));
  EXPECT_LE(std::abs(simulation.report().energy.drift_relative()), 1e-7);
}

}  // namespace
}  // namespace tanor
