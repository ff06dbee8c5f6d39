#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "scenes.hpp"

namespace tanor {
namespace {

// ---- output times ----

/// Options under which each method is exact to about `accuracy` over half a second of a short chain.
struct MethodAndAccuracy {
  MotionOptions options;
  double accuracy;
};

void PrintTo(const MethodAndAccuracy& method, std::ostream* out) {
  PrintTo(method.options.method, out);
}

class AdvanceTest : public testing::TestWithParam<MethodAndAccuracy> {};

TEST_P(AdvanceTest, ManyOutputTimesAreMetExactlyAndGiveTheSameMotion) {
  const auto& [options, accuracy] = GetParam();
  Simulation once(scenes::make_chain(5), options);
  Simulation often(scenes::make_chain(5), options);

  ASSERT_TRUE(once.advance_to(0.5).ok());
  for (int k = 1; k <= 37; ++k) {
    const double t = k < 37 ? k / 74.0 : 0.5;
    ASSERT_TRUE(often.advance_to(t).ok());
    ASSERT_EQ(often.time(), t);
    ASSERT_EQ(often.report().time, t);
  }

  EXPECT_LT(largest_difference(once.positions(), often.positions()), accuracy);
  EXPECT_LT(largest_difference(once.velocities(), often.velocities()), 100 * accuracy);
}

INSTANTIATE_TEST_SUITE_P(Methods, AdvanceTest,
                         testing::Values(MethodAndAccuracy{{.method = Method::Rk4, .step = 1.0 / 2000}, 1e-8},
                                         MethodAndAccuracy{{.method = Method::Dopri5, .rtol = 1e-10, .atol = 1e-12},
                                                           1e-9},
                                         MethodAndAccuracy{{.method = Method::Rattle, .step = 1.0 / 2000}, 1e-4}),
                         [](const auto& instance) { return std::string(name_of(instance.param.options.method)); });

/// An interval of 0.35 with the step 0.1 is divided into 4 equal steps of 0.0875.
TEST(OutputTimesTest, FixedStepsAreEqualAndNeverLongerThanAsked) {
  Simulation simulation(scenes::make_pendulum(), {.method = Method::Rk4, .step = 0.1});
  std::vector<double> times{0.0};

  ASSERT_TRUE(simulation
                  .advance_to(0.35,
                              [&](const MotionReport& report) {
                                times.push_back(report.time);
                                return true;
                              })
                  .ok());

  ASSERT_EQ(times.size(), 5u);
  for (std::size_t k = 1; k < times.size(); ++k) EXPECT_NEAR(times[k] - times[k - 1], 0.0875, 1e-15);
  EXPECT_EQ(times.back(), 0.35);
  EXPECT_NEAR(simulation.report().last_step, 0.0875, 1e-15);
}

/// An end that lies above a whole number of steps by rounding alone, as 3 * 0.1 above 0.3, takes no further step.
TEST(OutputTimesTest, AWholeNumberOfStepsStaysThatNumber) {
  Simulation simulation(scenes::make_pendulum(), {.method = Method::Rattle, .step = 1e-3});
  for (int k = 1; k <= 100; ++k) {
    ASSERT_TRUE(simulation.advance_to(k * 3e-3).ok());

    EXPECT_EQ(simulation.report().steps, 3u * static_cast<unsigned>(k));
  }
}

TEST(OutputTimesTest, AnObserverStopsARunThatCanGoOn) {
  for (const Method method : sampled_methods) {
    MotionOptions options{.method = method, .rtol = 1e-10, .atol = 1e-12};
    if (has_fixed_steps(method)) options.step = 1e-3;
    Simulation stopped(scenes::make_chain(3), options), straight(scenes::make_chain(3), options);

    EXPECT_TRUE(stopped.advance_to(0.2, scenes::stop_after(5)).ok());
    EXPECT_EQ(stopped.report().steps, 5u);
    EXPECT_LT(stopped.time(), 0.2);
    EXPECT_TRUE(stopped.advance_to(0.2).ok());
    EXPECT_TRUE(straight.advance_to(0.2).ok());

    EXPECT_EQ(stopped.time(), 0.2);
    EXPECT_LT(largest_difference(stopped.positions(), straight.positions()), 1e-9);
  }
}

/// A fresh solve at the state of the simulation gives the same accelerations and multipliers.
TEST(OutputTimesTest, AccelerationsAndMultipliersBelongToTheState) {
  for (const Method method : sampled_methods) {
    MotionOptions options{.method = method};
    if (has_fixed_steps(method)) options.step = 1e-3;
    Simulation simulation(scenes::make_shaken_chain(), options);
    ASSERT_TRUE(simulation.advance_to(0.3).ok());
    Dynamics dynamics(scenes::make_shaken_chain());
    std::vector<double> w(dynamics.num_points() * 3), lambda(dynamics.num_equations()), eta(w.size());

    ASSERT_TRUE(
        dynamics
            .solve(
                {.time = simulation.time(), .positions = simulation.positions(), .velocities = simulation.velocities()},
                {.accelerations = w, .multipliers = lambda, .reactions = eta})
            .outcome.ok());

    EXPECT_LT(largest_difference(simulation.accelerations(), w), 1e-10);
    EXPECT_LT(largest_difference(simulation.multipliers(), lambda), 1e-11);
    EXPECT_LT(largest_difference(simulation.reactions(), eta), 1e-11);
  }
}

TEST(OutputTimesTest, AMotionMayStartAtAnyTime) {
  System system = scenes::make_breathing_chain();
  const double t_start = 2.5, length = 0.1 * (1 + 0.2 * std::pow(std::sin(5.0), 2));
  for (std::size_t i = 0; i < system.num_points(); ++i) system.positions[3 * i] *= length / 0.1;
  Simulation simulation(system, {.start = StartMode::Project}, {}, t_start);

  EXPECT_EQ(simulation.time(), t_start);
  EXPECT_LT(simulation.report().start.position_correction, 1e-13);
  ASSERT_TRUE(simulation.advance_to(2.75).ok());

  const double now = 0.1 * (1 + 0.2 * std::pow(std::sin(5.5), 2));
  const std::span<const double> r = simulation.positions();
  EXPECT_NEAR(std::hypot(r[3] - r[0], r[4] - r[1], r[5] - r[2]), now, 1e-13);
}

// ---- options ----

TEST(MethodTest, AutoIsTaylorWithTolerancesAndRattleWithAStep) {
  EXPECT_EQ(Simulation(scenes::make_pendulum(), {}).report().method, Method::Taylor);
  EXPECT_EQ(Simulation(scenes::make_pendulum(), {.step = 1e-3}).report().method, Method::Rattle);
}

TEST(MethodTest, NamesGoBothWaysAndAnUnknownOneListsTheKnown) {
  for (const MethodTraits& each : methods()) {
    EXPECT_EQ(method_from_name(each.name), each.method);
    EXPECT_EQ(name_of(each.method), each.name);
  }
  try {
    method_from_name("euler");
    FAIL() << "euler is no method";
  } catch (const InputError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("\"euler\""), std::string::npos) << what;
    for (const MethodTraits& each : methods()) EXPECT_NE(what.find(each.name), std::string::npos) << what;
  }
}

/// Returns the place that the error about these options names.
std::string place_of_error(const MotionOptions& options) {
  try {
    Simulation simulation(scenes::make_pendulum(), options);
  } catch (const InputError& error) {
    return error.where();
  }
  return "none";
}

TEST(OptionsTest, WrongOptionsAreNamedByTheirPlace) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double infinity = std::numeric_limits<double>::infinity();

  EXPECT_EQ(place_of_error({.method = Method::Rattle}), "/motion/step");
  EXPECT_EQ(place_of_error({.method = Method::Rk4}), "/motion/step");
  for (const double step : {-0.1, nan, infinity}) EXPECT_EQ(place_of_error({.step = step}), "/motion/step") << step;
  for (const double tolerance : {0.0, -1e-8, nan, infinity}) {
    EXPECT_EQ(place_of_error({.rtol = tolerance}), "/motion/rtol") << tolerance;
    if (tolerance == 0.0) continue;  // not given
    EXPECT_EQ(place_of_error({.atol = tolerance}), "/motion/atol") << tolerance;
  }
  EXPECT_EQ(place_of_error({}), "none");
}

TEST(OptionsTest, AnEndBeforeTheTimeReachedIsWrongInput) {
  Simulation simulation(scenes::make_pendulum());
  ASSERT_TRUE(simulation.advance_to(0.1).ok());

  const std::size_t steps = simulation.report().steps;
  EXPECT_TRUE(simulation.advance_to(0.1).ok());
  EXPECT_EQ(simulation.report().steps, steps) << "it is there";
  for (const double t_end :
       {0.05, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW((void)simulation.advance_to(t_end), InputError) << t_end;
  }
  EXPECT_TRUE(simulation.advance_to(0.2).ok()) << "the simulation is unharmed";
}

}  // namespace
}  // namespace tanor
