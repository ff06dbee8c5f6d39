/// Flat nets are released at rest. Their cells flatten on the way, where K loses rank or comes near to it.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <tanor/motion.hpp>

#include "long_tests.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

enum class Hold { OppositeCorners, AdjacentCorners, OneCorner };

System make_flat_net(int side, Hold hold) {
  if (hold == Hold::OppositeCorners) return scenes::make_net(side, side);
  if (hold == Hold::AdjacentCorners) return scenes::make_hung_net(side);
  return scenes::hang(scenes::make_grid({side, side, 1}), {0});
}

/// A method and its tolerance or step.
struct TriedMethod {
  Method method;
  double accuracy;  // rtol, or the step
};

MotionOptions options_of(const TriedMethod& tried) {
  if (has_fixed_steps(tried.method)) return {.method = tried.method, .step = tried.accuracy};
  return {.method = tried.method, .rtol = tried.accuracy, .atol = 0.01 * tried.accuracy};
}

/// Returns how far the energy may drift, relative. With fixed steps the drift is as large as the order of the method
/// leaves it where cells swing round. Positions hold to 1e-13 of a rod, which near singular configurations is 1e-10 of
/// the energy.
double largest_drift(const TriedMethod& tried) {
  switch (tried.method) {
    case Method::Rattle:
    case Method::GeneralizedAlpha:
      return 0.05;
    case Method::Rk4:
      return 0.01;
    default:
      return std::max(10.0 * tried.accuracy, 1e-9);
  }
}

constexpr double times[] = {0.2, 0.4, 0.6, 0.8};

/// Returns the positions at `times`, or fewer if the run does not arrive.
std::vector<std::vector<double>> run(const System& system, const TriedMethod& tried) {
  SCOPED_TRACE(name_of(tried.method));
  SCOPED_TRACE(tried.accuracy);
  std::vector<std::vector<double>> places;
  Simulation simulation(system, options_of(tried));
  for (const double t : times) {
    const Outcome outcome = simulation.advance_to(t);
    EXPECT_TRUE(outcome.ok()) << outcome.what;
    if (!outcome.ok()) return places;
    places.emplace_back(simulation.positions().begin(), simulation.positions().end());
  }
  EXPECT_LE(simulation.report().violation.position, 1e-12);
  EXPECT_LE(std::abs(simulation.report().energy.drift_relative()), largest_drift(tried));
  return places;
}

/// Returns by how much the end moves over the distance by which the start is moved, 1e-12 m out of the plane (rods
/// allow it, but not where they are taut between two corners).
std::vector<double> measure_sensitivity(const System& system, const TriedMethod& tried,
                                        const std::vector<std::vector<double>>& places) {
  constexpr double move = 1e-12;
  System moved = system;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto side = static_cast<std::size_t>(std::lround(std::sqrt(system.num_points())));
  for (std::size_t i = side; i + 1 < system.num_points(); ++i) moved.positions[3 * i + 2] += move * normal(random);
  const auto others = run(moved, tried);
  std::vector<double> result;
  for (std::size_t k = 0; k < std::min(places.size(), others.size()); ++k)
    result.push_back(largest_difference(places[k], others[k]) / move);
  return result;
}

/// Expects that all methods arrive, and agree as far as errors of their tolerance, made anywhere on the way, let the
/// motion agree.
void expect_same_motion(Index side, Hold hold, const std::vector<TriedMethod>& tried_methods) {
  SCOPED_TRACE(side);
  SCOPED_TRACE(static_cast<int>(hold));
  const System system = make_flat_net(side, hold);
  const TriedMethod reference{Method::Taylor, 1e-12};
  const auto places = run(system, reference);
  const std::vector<double> sensitivity = measure_sensitivity(system, reference, places);
  double most = 1.0;
  ASSERT_EQ(sensitivity.size(), std::size(times));
  std::vector<double> allowed;
  for (const double each : sensitivity) allowed.push_back(most = std::max(most, each));
  for (const TriedMethod& tried : tried_methods) {
    const auto others = run(system, tried);
    ASSERT_EQ(others.size(), std::size(times)) << name_of(tried.method) << " " << tried.accuracy;
    if (has_fixed_steps(tried.method)) continue;  // they have no tolerance to compare with
    for (std::size_t k = 0; k < others.size(); ++k) {
      EXPECT_LE(largest_difference(others[k], places[k]), 100.0 * tried.accuracy * allowed[k])
          << name_of(tried.method) << " " << tried.accuracy << " at t = " << times[k];
    }
  }
}

constexpr Hold holds[] = {Hold::OppositeCorners, Hold::AdjacentCorners, Hold::OneCorner};

const std::vector<TriedMethod> explicit_methods{
    {Method::Taylor, 1e-6}, {Method::Taylor, 1e-9},  {Method::Dop853, 1e-6},
    {Method::Dop853, 1e-8}, {Method::Dop853, 1e-10}, {Method::Dop853, 1e-12},
    {Method::Dopri5, 1e-6}, {Method::Dopri5, 1e-8},  {Method::Auto, 1e-8}};
const std::vector<TriedMethod> all_methods = [] {
  std::vector<TriedMethod> tried_methods = explicit_methods;
  tried_methods.insert(tried_methods.end(), {{Method::Dopri5, 1e-10},
                                             {Method::Radau5, 1e-6},
                                             {Method::Rk4, 2e-4},
                                             {Method::Rattle, 2e-4},
                                             {Method::GeneralizedAlpha, 5e-4}});
  return tried_methods;
}();

class FlatNet : public testing::TestWithParam<Hold> {};

/// Returns two sides, or all sides up to TANOR_LARGEST_NET where that is given (30 takes hours).
std::vector<Index> choose_sides() {
  const char* const largest = std::getenv("TANOR_LARGEST_NET");
  if (largest == nullptr) return {3, 6};
  std::vector<Index> sides;
  for (Index side = 3; side <= std::atoi(largest); ++side) sides.push_back(side);
  return sides;
}

TEST_P(FlatNet, ArrivesByEveryMethod) {
  const std::vector<Index> sides = choose_sides();
  ASSERT_FALSE(sides.empty());
  for (const Index side : sides) expect_same_motion(side, GetParam(), all_methods);
}

TEST_P(FlatNet, ArrivesWhereCellsFlattenTogether) {
  for (const Index side : {8, 14})
    if (side == 8 || tests_are_long()) expect_same_motion(side, GetParam(), explicit_methods);
}

INSTANTIATE_TEST_SUITE_P(Holds, FlatNet, testing::ValuesIn(holds));

/// At t = 0.3688 two cells at the free corners of the net of README's picture flatten at once.
TEST(FlatNet, ArrivesInTheMotionOfTheReadme) {
  std::vector<TriedMethod> tried_methods{{Method::Dop853, 1e-8}, {Method::Taylor, 1e-10}};
  if (tests_are_long()) tried_methods.insert(tried_methods.end(), {{Method::Dopri5, 1e-6}, {Method::Taylor, 1e-8}});
  expect_same_motion(20, Hold::OppositeCorners, tried_methods);
}

}  // namespace
}  // namespace tanor
