/// Energy over many steps.

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "motion/elliptic.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

/// A pendulum is released horizontally and takes more than 300 steps a swing.
TEST(LongRunTest, EnergyOfRattleSwingsAMillionStepsWithoutTrend) {
  constexpr std::size_t steps = 1'000'000, parts = 10;
  Simulation simulation(scenes::make_pendulum(), {.method = Method::Rattle, .step = 2e-3}, {.threads = 1});
  std::array<double, parts> means{};
  double least = 0.0, most = 0.0;
  std::size_t k = 0;

  const Outcome outcome = simulation.advance_to(2e-3 * steps, [&](const MotionReport& report) {
    const double error = report.energy.now - report.energy.start;
    least = std::min(least, error);
    most = std::max(most, error);
    means[parts * k++ / steps] += error / (steps / parts);
    return true;
  });

  ASSERT_TRUE(outcome.ok()) << outcome.what;
  ASSERT_EQ(k, steps);
  for (const double mean : means) EXPECT_NEAR(mean, means[0], 1e-3 * (most - least));
  EXPECT_LT(most - least, 2e-4 * simulation.report().energy.scale);
}

/// After 400 s, more than 500 periods, rattle4 and rattle6 still know where the pendulum is.
TEST(LongRunTest, CompositionsKeepThePhase) {
  const double frequency = std::sqrt(9.81 / scenes::spacing), amplitude = 0.5 * M_PI;
  const double period = 4.0 * elliptic::quarter_period(amplitude, frequency);
  const double angle = elliptic::swing(amplitude, frequency, std::fmod(400.0, period)).angle;
  for (const auto& [method, error] : {std::pair{Method::Rattle4, 2e-6}, std::pair{Method::Rattle6, 5e-9}}) {
    Simulation simulation(scenes::make_pendulum(), {.method = method, .step = 2e-3}, {.threads = 1});

    ASSERT_TRUE(simulation.advance_to(400.0).ok()) << simulation.outcome().what;

    EXPECT_NEAR(simulation.positions()[3], 0.1 * std::sin(angle), error) << name_of(method);
    EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), error) << name_of(method);
  }
}

}  // namespace
}  // namespace tanor
