/// Tolerances below the rounding of forces: steps are held where rounding begins, and the report says what they meet.

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "base/parallel.hpp"
#include "methods.hpp"
#include "motion/noise_scenes.hpp"
#include "scenes.hpp"

namespace tanor {
using namespace detail;
namespace {

struct Result {
  double error = 0.0;  // m, the largest of all points
  double steps = 0.0;  // including those that were rejected
  std::string warning;
};

/// Runs at rtol 1e-5, 1e-6 … 1e-14.
std::vector<Result> run_all(const noise::StiffChain& chain, Method method) {
  const System system = noise::make_system(chain);
  const std::vector<long double> right = noise::find_end(system, chain.t_end);
  std::vector<Result> runs;
  for (int digits = 5; digits <= 14; ++digits) {
    const double rtol = std::pow(10.0, -digits);
    Simulation simulation(system, {.method = method, .rtol = rtol, .atol = 1e-2 * rtol});
    std::size_t steps = 0;
    // A run that chases rounding never ends.
    const Outcome outcome = simulation.advance_to(chain.t_end, [&](const MotionReport&) { return ++steps < 40'000; });
    EXPECT_TRUE(outcome.ok()) << outcome.what;
    EXPECT_EQ(simulation.time(), chain.t_end) << "rtol " << rtol;
    Result run;
    for (std::size_t i = 0; i < right.size(); ++i)
      run.error = larger(run.error, static_cast<double>(std::abs(right[i] - simulation.positions()[i])));
    run.steps = static_cast<double>(simulation.report().steps + simulation.report().rejected);
    run.warning = simulation.report().accuracy_warning;
    runs.push_back(run);
  }
  return runs;
}

class HeldSteps : public testing::TestWithParam<Method> {};

/// The points of these chains do not move apart by themselves, so that nothing but rounding makes errors grow.
TEST_P(HeldSteps, TolerancesBelowRoundingTakeNoSmallerSteps) {
  std::vector<std::pair<noise::StiffChain, double>> chains{{noise::make_uneven_chain(), 0.0}};
  for (const unsigned seed : {0U, 2U, 3U, 4U, 7U, 9U}) chains.emplace_back(noise::draw_chain(seed), 0.0);
  for (const unsigned seed : {1U, 2U, 3U, 7U}) chains.emplace_back(noise::draw_chain(seed, 1e6), 1e6);
  for (const auto& [chain, distance] : chains) {
    SCOPED_TRACE(testing::Message() << chain.masses.size() << " points, " << chain.stiffness << " N/m, " << distance
                                    << " m away");
    const std::vector<Result> runs = run_all(chain, GetParam());

    const auto best = std::ranges::min_element(runs, {}, &Result::error);
    // The least of ten errors may be luck: positions round in every step, and these roundings add up as a random walk.
    const double size = largest(noise::make_system(chain).positions);
    const double reachable = std::max(best->error, 4.0 * 2.2e-16 * size * std::sqrt(best->steps));
    const auto pays = std::ranges::find_if(runs, [&](const Result& run) { return run.error <= reachable; });
    for (auto run = pays; run != runs.end(); ++run) {
      SCOPED_TRACE(testing::Message() << "rtol 1e-" << 5 + (run - runs.begin()));
      EXPECT_LE(run->error, 10.0 * reachable);
      // radau5, whose estimate is of order 4, needs the most steps for what it still gains in velocities: 1.8 times as
      // many for each decade. Positions happen to be right to rounding up to three decades before (1426 steps of 6200).
      const double most = GetParam() == Method::Radau5 ? 5.0 : 3.0;
      EXPECT_LE(run->steps, most * std::max(best->steps, pays->steps) + 20.0);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(AdaptiveMethods, HeldSteps, testing::ValuesIn(list_adaptive_methods()));

TEST(Warning, NamesTheToleranceThatStepsMeet) {
  const noise::StiffChain chain = noise::make_uneven_chain();
  const auto warning_at = [&](double rtol) {
    Simulation simulation(noise::make_system(chain), {.method = Method::Dop853, .rtol = rtol, .atol = 1e-2 * rtol});
    EXPECT_TRUE(simulation.advance_to(chain.t_end).ok());
    return simulation.report().accuracy_warning;
  };

  EXPECT_EQ(warning_at(1e-8), "");
  const std::string warning = warning_at(1e-14);
  ASSERT_TRUE(warning.starts_with("forces round to more than the tolerance from t = ")) << warning;
  ASSERT_TRUE(warning.ends_with(", not 1e-14")) << warning;
  const double met = std::stod(warning.substr(warning.find("rtol ") + 5));
  EXPECT_GT(met, 1e-12);
  EXPECT_LT(met, 1e-8);
}

/// Smooth motions get no warning, however small the tolerance.
TEST(Warning, IsNotGivenForAPlainChain) {
  for (const Method method : list_explicit_adaptive_methods()) {
    Simulation simulation(scenes::make_chain(5), {.method = method, .rtol = 1e-13, .atol = 1e-13});
    ASSERT_TRUE(simulation.advance_to(0.2).ok());
    EXPECT_EQ(simulation.report().accuracy_warning, "") << name_of(method);
  }
}

/// A neighbour that rounds by much does not loosen the tolerance of others. A pendulum ends at the same place.
TEST(Rounding, IsMeasuredForEachGroupByItself) {
  const auto end_of_pendulum = [](const System& system) {
    Simulation simulation(system, {.method = Method::Dopri5, .rtol = 1e-11, .atol = 1e-13});
    EXPECT_TRUE(simulation.advance_to(0.3).ok());
    return std::array{simulation.positions()[3], simulation.positions()[5]};
  };
  const System pendulum = scenes::make_pendulum();
  System both = pendulum;
  // Two points at rest a million metres away, on a spring of 1e4 N/m, round by 1e-6 m/s^2 and more.
  const Index a = scenes::add_point({1e6, 0, 0}, &both), b = scenes::add_point({1e6, 1.0, 0}, &both);
  both.forces.push_back(Springs{"far", {{a, b}}, 1e4, 0.0, 1.0});

  const auto alone = end_of_pendulum(pendulum), beside = end_of_pendulum(both);

  EXPECT_NEAR(alone[0], beside[0], 1e-11);
  EXPECT_NEAR(alone[1], beside[1], 1e-11);
}

/// A point of 1e-13 kg on rods from three points of 1e-2 kg is pulled by 20 N. The force cancels to 1e-11 of itself in
/// the light point of this rigid body. All of it moves as the heavy points do, its center by F t^2/(2 m).
TEST(NextToNoMass, ALightPointMovesWithTheBodyItIsFixedTo) {
  System system;
  const auto add = [&](const Vector3& place, double mass) {
    const Index i = scenes::add_point(place, &system);
    system.masses.back() = mass;
    return i;
  };
  add({0, 0, 0}, 1e-2);
  add({1, 0, 0}, 1e-2);
  add({0, 1, 0}, 1e-2);
  const Index light = add({0.3, 0.4, 0.3}, 1e-13);
  system.constraints = {Rods{"rods", {{0, 1}, {1, 2}, {0, 2}, {0, light}, {1, light}, {2, light}}, {}, {}}};
  system.forces = {ConstantForce{"pull", {light}, Vector3{20, 5, 3}}};
  for (const Method method : list_adaptive_methods()) {
    Simulation simulation(system, {.method = method});

    ASSERT_TRUE(simulation.advance_to(1.0).ok()) << name_of(method) << ": " << simulation.outcome().what;

    EXPECT_LT(simulation.report().steps + simulation.report().rejected, 3000U) << name_of(method);
    const auto r = simulation.positions();
    const std::array force{20.0, 5.0, 3.0}, begin{1.0 / 3.0, 1.0 / 3.0, 0.0};
    for (std::size_t q = 0; q < 3; ++q) {
      const double center = (r[q] + r[3 + q] + r[6 + q]) / 3.0;
      EXPECT_NEAR(center, begin[q] + 0.5 * force[q] / 3e-2, 3e-8 * 333.0) << name_of(method);
    }
  }
}

/// A snapshot holds the rounding that was measured.
TEST(Rounding, ARestoredRunGoesOnBitByBit) {
  const noise::StiffChain chain = noise::make_uneven_chain();
  const System system = noise::make_system(chain);
  for (const Method method : list_explicit_adaptive_methods()) {
    const MotionOptions options{.method = method, .rtol = 1e-13, .atol = 1e-15};
    Simulation straight(system, options), restored(system, options);
    std::vector<std::byte> saved;
    int steps = 0;
    ASSERT_TRUE(straight
                    .advance_to(chain.t_end,
                                [&](const MotionReport&) {
                                  if (++steps == 20) saved = straight.save();
                                  return true;
                                })
                    .ok());

    restored.restore(saved);
    ASSERT_TRUE(restored.advance_to(chain.t_end).ok());

    EXPECT_TRUE(std::ranges::equal(straight.positions(), restored.positions())) << name_of(method);
    EXPECT_EQ(straight.report().accuracy_warning, restored.report().accuracy_warning);
    EXPECT_EQ(straight.report().steps, restored.report().steps);
  }
}

/// Steps meet rounding, 1e-15 of the scales, where both tolerances are far below it. Free flight and a spring have
/// closed forms.
TEST(TolerancesBelowRounding, HoldAtRounding) {
  System flight;
  flight.positions = {0.0, 0.0, 0.0};
  flight.velocities = {1.0, 2.0, 3.0};
  flight.masses = {1.0};
  flight.add_gravity({0.0, 0.0, -9.81});
  System spring;
  spring.positions = {0.0, 0.0, 0.0, 1.2, 0.0, 0.0};
  spring.masses = {1.0, 1.0};
  spring.supports = {{"", {0}, {}}};
  spring.forces = {Springs{.name = "", .pairs = {{0, 1}}, .stiffness = 100.0, .rest_length = 1.0}};
  const double t = 0.2;
  for (const Method method : list_adaptive_methods()) {
    const auto run = [&](const System& system, double tolerance) {
      Simulation simulation(system, {.method = method, .rtol = tolerance, .atol = tolerance});
      std::size_t steps = 0;
      const Outcome outcome = simulation.advance_to(t, [&](const MotionReport&) { return ++steps < 20'000; });
      EXPECT_TRUE(outcome.ok()) << name_of(method) << ": " << outcome.what;
      EXPECT_EQ(simulation.time(), t) << name_of(method);
      return std::pair(simulation.positions().back() + simulation.positions()[simulation.positions().size() - 3],
                       static_cast<double>(simulation.report().steps + simulation.report().rejected));
    };
    EXPECT_NEAR(run(flight, 1e-30).first, 4.0 * t - 0.5 * 9.81 * t * t, 1e-13) << name_of(method);
    const auto [x, steps] = run(spring, 1e-30);
    EXPECT_NEAR(x, 1.0 + 0.2 * std::cos(10.0 * t), 1e-11) << name_of(method);
    EXPECT_LE(steps, 2.0 * run(spring, 1e-15).second + 20.0) << name_of(method);
    (void)run(scenes::make_pendulum(), 1e-30);
  }
}

}  // namespace
}  // namespace tanor
