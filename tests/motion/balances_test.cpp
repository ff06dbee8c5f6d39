#include <gtest/gtest.h>

#include "scenes.hpp"

#include "base/parallel.hpp"

namespace tanor {
using namespace detail;
namespace {

// ---- momentum ----

/// The momenta are sum m v and sum m r x v.
struct Momenta {
  Vector3 linear{}, angular{};
};

Momenta measure_momenta(const Simulation& simulation) {
  Momenta result;
  const std::span<const double> r = simulation.positions(), v = simulation.velocities();
  for (std::size_t i = 0; i < r.size() / 3; ++i) {
    for (std::size_t x = 0; x < 3; ++x) {
      const std::size_t y = (x + 1) % 3, z = (x + 2) % 3;
      result.linear[x] += scenes::mass * v[3 * i + x];
      result.angular[x] += scenes::mass * (r[3 * i + y] * v[3 * i + z] - r[3 * i + z] * v[3 * i + y]);
    }
  }
  return result;
}

struct Losses {
  double linear = 0.0, angular = 0.0;  // relative
};

/// Returns the losses of four free clusters in 0.5 s, on which no force acts.
Losses measure_losses(MotionOptions options) {
  options.start = StartMode::Project;
  Simulation simulation(scenes::make_clusters(4), options);
  const Momenta before = measure_momenta(simulation);
  const Outcome outcome = simulation.advance_to(0.5);
  EXPECT_TRUE(outcome.ok()) << outcome.what;
  const Momenta after = measure_momenta(simulation);
  return {largest_difference(before.linear, after.linear) / largest(before.linear),
          largest_difference(before.angular, after.angular) / largest(before.angular)};
}

/// Since r1 x v1/2 = r0 x v1/2 and rods pull along themselves, RATTLE keeps both momenta for any step.
TEST(MomentumTest, RattleKeepsLinearAndAngularMomentumToRounding) {
  const Losses losses = measure_losses({.method = Method::Rattle, .step = 1e-3});

  EXPECT_LT(losses.linear, 1e-13);
  EXPECT_LT(losses.angular, 1e-13);
}

TEST(MomentumTest, Rk4KeepsLinearMomentumToRoundingAndAngularToItsOrder) {
  const Losses coarse = measure_losses({.method = Method::Rk4, .step = 4e-3});
  const Losses fine = measure_losses({.method = Method::Rk4, .step = 2e-3});

  EXPECT_LT(coarse.linear, 1e-13);
  EXPECT_LT(fine.linear, 1e-13);
  EXPECT_GT(std::log2(coarse.angular / fine.angular), 3.6);
}

TEST(MomentumTest, Dopri5KeepsLinearMomentumToRoundingAndAngularToItsTolerance) {
  const Losses loose = measure_losses({.method = Method::Dopri5, .rtol = 1e-6, .atol = 1e-8});
  const Losses tight = measure_losses({.method = Method::Dopri5, .rtol = 1e-10, .atol = 1e-12});

  EXPECT_LT(loose.linear, 1e-13);
  EXPECT_LT(tight.linear, 1e-13);
  EXPECT_LT(tight.angular, 1e-9);
  EXPECT_LT(tight.angular, 1e-2 * loose.angular);
}

// ---- energy ----

struct EnergyScene {
  std::string name;
  System (*build)();

  friend std::ostream& operator<<(std::ostream& out, const EnergyScene& scene) { return out << scene.name; }
};

const EnergyScene closed_scenes[]{{"chain", [] { return scenes::make_chain(5); }},
                                  {"ring", [] { return scenes::make_ring(8); }},
                                  {"springs", [] {
                                     System system = scenes::make_damped_chain();
                                     std::get<Springs>(system.forces[1]).damping = 0.0;
                                     return system;
                                   }}};

// Energy goes in or out in these scenes, and the report has to say how much.
const EnergyScene open_scenes[]{{"shaken_support", [] { return scenes::make_shaken_chain(); }},
                                {"breathing_rods", [] { return scenes::make_breathing_chain(); }},
                                {"drag", [] { return scenes::make_chain_in_air(); }},
                                {"damped_springs", [] { return scenes::make_damped_chain(); }},
                                {"driven_bead", [] { return scenes::make_driven_chain(); }},
                                {"guides_springs_and_air", [] { return scenes::make_beads(3); }},
                                {"shaken_damped_springs", [] {
                                   System system = scenes::make_damped_chain();
                                   system.supports = scenes::make_shaken_chain().supports;
                                   return system;
                                 }}};

EnergyReport run(const EnergyScene& scene, MotionOptions options, double t_end = 0.3) {
  options.start = StartMode::Project;
  Simulation simulation(scene.build(), options);
  const Outcome outcome = simulation.advance_to(t_end);
  EXPECT_TRUE(outcome.ok()) << outcome.what;
  return simulation.report().energy;
}

class ClosedEnergyTest : public testing::TestWithParam<EnergyScene> {};

TEST_P(ClosedEnergyTest, IsKeptWithoutAnyWork) {
  const EnergyReport energy = run(GetParam(), {.method = Method::Dopri5, .rtol = 1e-11, .atol = 1e-13});

  EXPECT_EQ(energy.work_of_supports, 0.0);
  EXPECT_EQ(energy.work_of_forces, 0.0);
  EXPECT_GT(energy.scale, 0.0);
  EXPECT_LT(std::abs(energy.drift_relative()), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Scenes, ClosedEnergyTest, testing::ValuesIn(closed_scenes),
                         [](const auto& instance) { return instance.param.name; });

class OpenEnergyTest : public testing::TestWithParam<EnergyScene> {};

TEST_P(OpenEnergyTest, ChangesByTheReportedWorks) {
  const EnergyReport energy = run(GetParam(), {.method = Method::Dopri5, .rtol = 1e-11, .atol = 1e-13});

  const double works = std::abs(energy.work_of_supports) + std::abs(energy.work_of_forces);
  EXPECT_GT(works, 1e-4 * energy.scale) << "a scene without work proves nothing";
  EXPECT_LT(std::abs(energy.drift_relative()), 1e-9);
}

TEST_P(OpenEnergyTest, DriftFallsWithTheOrderOfRk4) {
  const double coarse = run(GetParam(), {.method = Method::Rk4, .step = 1.0 / 500}).drift_relative();
  const double fine = run(GetParam(), {.method = Method::Rk4, .step = 1.0 / 1000}).drift_relative();

  EXPECT_GT(std::log2(std::abs(coarse / fine)), 3.5) << coarse << " and " << fine;
}

TEST_P(OpenEnergyTest, DriftFallsWithTheOrderOfRattle) {
  const double coarse = run(GetParam(), {.method = Method::Rattle, .step = 1.0 / 1000}).drift_relative();
  const double fine = run(GetParam(), {.method = Method::Rattle, .step = 1.0 / 2000}).drift_relative();

  EXPECT_NEAR(std::log2(std::abs(coarse / fine)), 2.0, 0.2) << coarse << " and " << fine;
}

INSTANTIATE_TEST_SUITE_P(Scenes, OpenEnergyTest, testing::ValuesIn(open_scenes),
                         [](const auto& instance) { return instance.param.name; });

/// A free bead in linear drag, m v' = -c v, loses half its energy by t = m ln 2/(2 c), all of it to the drag.
TEST(EnergyTest, WorkOfDragIsTheLostKineticEnergy) {
  System system;
  scenes::add_point({0, 0, 0}, &system);
  system.velocities = {2, 0, 0};
  system.forces = {Drag{"air", {0}, 0.05, 0.0}};
  Simulation simulation(system, {.method = Method::Dopri5, .rtol = 1e-12, .atol = 1e-14});

  ASSERT_TRUE(simulation.advance_to(std::log(2.0)).ok());

  const EnergyReport& energy = simulation.report().energy;
  EXPECT_NEAR(energy.start, 0.2, 1e-15);
  EXPECT_NEAR(energy.now, 0.1, 1e-12);
  EXPECT_NEAR(energy.work_of_forces, -0.1, 1e-12);
}

/// A support stretches a spring of rest length 0 from 0.1 m to 0.4 m. The bead at its other end stays on a line
/// orthogonal to the spring and takes none of the work k (l1^2 - l0^2)/2.
TEST(EnergyTest, WorkOfAMovingSupportGoesIntoTheSpring) {
  System system;
  scenes::add_point({0, 0, 0}, &system);
  scenes::add_point({0, 0, 0.1}, &system);
  system.supports = {{"puller", {1}, {0.0, 0.0, ScalarFunction::formula("0.3*t")}}};
  system.constraints = {Lines{"rail", {0}, Vector3{0, 0, 0}, Vector3{1, 0, 0}}};
  system.forces = {Springs{"spring", {{0, 1}}, 7.0, 0.0, 0.0}};
  Simulation simulation(system, {.method = Method::Rk4, .step = 0.01});

  ASSERT_TRUE(simulation.advance_to(1.0).ok());

  EXPECT_NEAR(simulation.report().energy.work_of_supports, 0.5 * 7.0 * (0.4 * 0.4 - 0.1 * 0.1), 1e-13);
  EXPECT_NEAR(simulation.report().energy.drift_relative(), 0.0, 1e-13);
}

// ---- RATTLE over long times ----

struct LongRun {
  double first = 0.0, last = 0.0;  // mean energy of the first and the last tenth
  double swing = 0.0;              // largest distance from the start's energy
};

/// Runs 1e5 steps.
LongRun run_long(const System& system, double step) {
  constexpr std::size_t steps = 100'000;
  Simulation simulation(system, {.method = Method::Rattle, .step = step});
  LongRun result;
  const Outcome outcome = simulation.advance_to(step * steps, [&](const MotionReport& report) {
    const double change = report.energy.now - report.energy.start;
    result.swing = larger(result.swing, std::abs(change));
    if (report.steps <= steps / 10) result.first += change / (steps / 10);
    if (report.steps > steps - steps / 10) result.last += change / (steps / 10);
    return true;
  });
  EXPECT_TRUE(outcome.ok()) << outcome.what;
  EXPECT_EQ(simulation.report().steps, steps);
  return result;
}

TEST(RattleTest, EnergyOfAPendulumSwingsButDoesNotDriftOver1e5Steps) {
  const LongRun energy = run_long(scenes::make_pendulum(), 0.005);

  const double scale = scenes::mass * 9.81 * scenes::spacing;
  EXPECT_LT(energy.swing, 1e-2 * scale);
  EXPECT_GT(energy.swing, 1e-6 * scale) << "a step that makes no error proves nothing";
  EXPECT_LT(std::abs(energy.last - energy.first), 1e-2 * energy.swing);
}

TEST(RattleTest, EnergyOfARingSwingsButDoesNotDriftOver1e5Steps) {
  const LongRun energy = run_long(scenes::make_ring(8), 0.005);

  EXPECT_GT(energy.swing, 0.0);
  EXPECT_LT(std::abs(energy.last - energy.first), 1e-2 * energy.swing);
}

/// Returns the energies after 0.1 s, in which beads meet and part; `swing`: largest distance from the start's energy.
EnergyReport run_melt(double step, double* swing) {
  Simulation simulation(scenes::make_melt(8), {.method = Method::Rattle, .step = step, .start = StartMode::Project});
  const Outcome outcome = simulation.advance_to(0.1, [&](const MotionReport& report) {
    *swing = std::max(*swing, std::abs(report.energy.now - report.energy.start));
    return true;
  });
  EXPECT_TRUE(outcome.ok()) << outcome.what;
  return simulation.report().energy;
}

TEST(RattleTest, EnergyOfAMeltSwingsWithTheSquareOfTheStep) {
  double coarse = 0.0, fine = 0.0;

  const EnergyReport energy = run_melt(4e-4, &coarse);
  run_melt(2e-4, &fine);

  EXPECT_LT(coarse, 1e-3 * energy.scale);
  EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.3) << coarse << " and " << fine;
}

TEST(MomentumTest, BeadsThatMeetKeepLinearMomentum) {
  Simulation simulation(scenes::make_melt(8), {.method = Method::Rattle, .step = 1e-3, .start = StartMode::Project});
  const Momenta before = measure_momenta(simulation);

  ASSERT_TRUE(simulation.advance_to(0.3).ok());

  const Momenta after = measure_momenta(simulation);
  EXPECT_LT(largest_difference(before.linear, after.linear), 1e-13 * scenes::mass * 512);
}

/// The method is symmetric, so that the same steps lead back once v is reversed.
TEST(RattleTest, RunsBackToItsStart) {
  System system = scenes::make_damped_chain();
  std::get<Springs>(system.forces[1]).damping = 0.0;
  const MotionOptions options{.method = Method::Rattle, .step = 1e-3};

  Simulation forward(system, options);
  ASSERT_TRUE(forward.advance_to(0.3).ok());
  System turned = system;
  turned.positions.assign(forward.positions().begin(), forward.positions().end());
  for (std::size_t i = 0; i < turned.velocities.size(); ++i) turned.velocities[i] = -forward.velocities()[i];
  Simulation backward(turned, options);
  ASSERT_TRUE(backward.advance_to(0.3).ok());

  EXPECT_GT(largest_difference(forward.positions(), system.positions), 0.1);
  EXPECT_LT(largest_difference(backward.positions(), system.positions), 1e-11);
  EXPECT_LT(largest(backward.velocities()), 1e-10);
}

}  // namespace
}  // namespace tanor
