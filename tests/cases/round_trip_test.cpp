/// The two problems are inverse to each other, so that a motion made by forces asks for no other force.

#include <gtest/gtest.h>
#include <tanor/inverse_dynamics.hpp>
#include <tanor/motion.hpp>

#include "cases/reference_motion.hpp"

namespace tanor::cases {
namespace {

class RoundTripTest : public testing::TestWithParam<std::string> {};

TEST_P(RoundTripTest, MotionOfTheForcesNeedsNoControlAndHasTheReactionsOfTheCase) {
  const CaseScene& scene = *std::find_if(moving_cases().begin(), moving_cases().end(),
                                         [](const CaseScene& candidate) { return candidate.name == GetParam(); });
  const std::vector<Instant> trajectory = read_trajectory(scene.reference);
  const System system = scene.build(trajectory.front());
  Simulation simulation(system, {.method = Method::Dopri5, .rtol = 1e-12, .atol = 1e-14});
  InverseDynamics problem(system);
  const auto copy = [](std::span<const double> array) { return std::vector<double>(array.begin(), array.end()); };
  const auto masses = [&](const std::vector<double>& all) { return std::span(all).subspan(3 * scene.num_supports); };

  double scale = 0.0;
  for (const Instant& instant : trajectory) scale = std::max(scale, largest(scene.reactions(instant)));
  for (const Instant& instant : trajectory) {
    if (instant.t > 0.0) {
      ASSERT_TRUE(simulation.advance_to(instant.t).ok()) << simulation.outcome().what;
    }

    const MotionForces forces = problem.evaluate(
        instant.t, {copy(simulation.positions()), copy(simulation.velocities()), copy(simulation.accelerations())});

    ASSERT_TRUE(forces.outcome.ok()) << forces.outcome.what;
    EXPECT_LE(forces.largest_control, 1e-12 * scale) << "t = " << instant.t;
    EXPECT_LE(forces.position.largest, 1e-12);
    EXPECT_LE(forces.acceleration.largest, 1e-12 * std::max(1.0, largest(instant.w)));
    EXPECT_LT(largest_difference(masses(forces.reactions), scene.reactions(instant)), 1e-10 * scale)
        << "t = " << instant.t;
    EXPECT_LT(largest_difference(forces.multipliers, scene.multipliers(instant)), 1e-10 * scale) << "t = " << instant.t;
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, RoundTripTest, testing::Values("07_chain2", "11_variable_length"),
                         [](const auto& instance) { return instance.param; });

}  // namespace
}  // namespace tanor::cases
