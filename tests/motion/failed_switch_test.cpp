#include <gtest/gtest.h>

#include <cmath>
#include <tanor/tanor.hpp>

#include "rough_scenes.hpp"

/// \file A step that fails where contacts switch leaves the state as it was.
namespace tanor {
namespace {

/// Makes a telescope none of whose motions obeys the law of friction where D < 0.3 and F > 2 g D (modes_test.cpp). On
/// the way there two motions that obey it meet, and which one is found depends on where iterations begin.
System make_jamming_telescope() {
  return scenes::make_telescope("1 + 0.5*t^2");
}

std::vector<double> copy(std::span<const double> x) {
  return {x.begin(), x.end()};
}

/// The motions meet at t = 2.62297. A step of 0.05 s from just before that time fails, as do its parts down to 1/256.
TEST(FailedSwitch, LeavesAccelerationsAndForcesAsTheyWere) {
  for (const double before : {2.6228, 2.6229, 2.62295, 2.62296}) {
    SCOPED_TRACE(before);
    Simulation simulation(make_jamming_telescope(), {.method = Method::Rk4, .step = 0.05});
    ASSERT_TRUE(simulation.advance_to(2.5).ok()) << simulation.outcome().what;
    ASSERT_TRUE(simulation.advance_to(before).ok()) << simulation.outcome().what;
    const std::vector<double> r = copy(simulation.positions()), v = copy(simulation.velocities()),
                              w = copy(simulation.accelerations()), lambda = copy(simulation.multipliers()),
                              eta = copy(simulation.reactions());

    ASSERT_FALSE(simulation.advance_to(2.5 + 1.0).ok());

    ASSERT_EQ(simulation.time(), before);
    EXPECT_EQ(copy(simulation.positions()), r);
    EXPECT_EQ(copy(simulation.velocities()), v);
    EXPECT_EQ(copy(simulation.accelerations()), w);
    EXPECT_EQ(copy(simulation.multipliers()), lambda);
    EXPECT_EQ(copy(simulation.reactions()), eta);
  }
}

}  // namespace
}  // namespace tanor
