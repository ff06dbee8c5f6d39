/// Conditions that begin at their limits, that end a run at an instant of output, and the members that they name.

#include <gtest/gtest.h>

#include <cmath>

#include <tanor/motion.hpp>

#include "errors.hpp"

namespace tanor {
namespace {

/// A pendulum of length 1 that starts at rest, horizontally, and turns through the vertical at 0.59 s.
Simulation start_pendulum(Method method) {
  System system;
  const Point hook = system.add_support({0.0, 0.0, 0.0});
  system.add_rods("rod").join(hook, system.add_point({.position = {1.0, 0.0, 0.0}, .mass = 2.0}));
  system.add_gravity({0.0, 0.0, -9.81});
  return Simulation(system, {.method = method, .step = has_fixed_steps(method) ? 1e-3 : 0.0, .rtol = 1e-10});
}

/// Rods hang under one another with 4 N, 3.4 N, 2.4 N and 0.4 N in them, so that one alone is below 1 N.
System hang_cable() {
  System system;
  Point last = system.add_support({0.0, 0.0, 0.0}, {}, "hook");
  RodGroup rods = system.add_rods("links");
  for (const double mass : {0.06, 0.1, 0.2, 0.04}) {
    const Point next =
        system.add_point({.position = {0.0, 0.0, -static_cast<double>(system.num_points())}, .mass = mass});
    rods.join(last, next);
    last = next;
  }
  system.add_gravity({0.0, 0.0, -10.0});
  return system;
}

class ConditionsAtLimits : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Methods, ConditionsAtLimits,
                         testing::Values(Method::Taylor, Method::Dop853, Method::Dopri5, Method::Radau5, Method::Rk4,
                                         Method::Rattle));

/// The point is on its way up again at the end, where nobody looked in between.
TEST_P(ConditionsAtLimits, WhatBecomesTrueRightAfterTheStartIsToldThere) {
  for (const char* when : {"velocity(1).z < 0", "0 > position(1).z", "kinetic() > 0", "t > 0"}) {
    Simulation simulation = start_pendulum(GetParam());
    simulation.add_event({.when = when});
    const Outcome outcome = simulation.advance_to(1.0);
    ASSERT_TRUE(outcome.ok()) << outcome.what;
    ASSERT_EQ(simulation.passages().size(), 1u) << when;
    EXPECT_NEAR(simulation.passages()[0].time, 0.0, 1e-12) << when;

    Simulation stopped = start_pendulum(GetParam());
    stopped.add_event({.when = when, .action = EventAction::Stop});
    ASSERT_TRUE(stopped.advance_to(1.0).ok());
    EXPECT_NEAR(stopped.time(), 0.0, 1e-12) << when;
    ASSERT_TRUE(stopped.advance_to(1.0).ok());
    EXPECT_EQ(stopped.time(), 1.0) << when;
  }
}

/// Some touch their limits at the start, others are true before.
TEST_P(ConditionsAtLimits, WhatTouchesItsLimitAtTheStartIsNotTold) {
  for (const auto& [when, count] : {std::pair("position(1).x > 1", 0u),
                                    {"velocity(1).x > 0", 0u},
                                    {"position(1).y > 0", 0u},
                                    {"t > -1", 1u},
                                    {"velocity(1).z < 1e-17", 1u}}) {
    Simulation simulation = start_pendulum(GetParam());
    simulation.add_event({.when = when});
    for (const double t : {0.25, 0.5}) ASSERT_TRUE(simulation.advance_to(t).ok());
    EXPECT_EQ(simulation.passages().size(), count) << when;
  }
}

TEST(ConditionsOnMembers, MaxAndMinNameTheMemberThatBreaks) {
  for (const auto& [when, member] :
       {std::pair("max tension(links) > 3.5", "links[0]"), {"min tension(links) < 1", "links[3]"}}) {
    Simulation simulation(hang_cable());
    simulation.add_event({.when = when, .action = EventAction::Break});
    const Outcome outcome = simulation.advance_to(0.1);
    ASSERT_TRUE(outcome.ok()) << outcome.what;
    ASSERT_EQ(simulation.passages().size(), 1u) << when;
    EXPECT_EQ(simulation.passages()[0].member, member);
    EXPECT_EQ(simulation.passages()[0].time, 0.0);
  }
  EXPECT_NE(error_of([] {
              check_event(hang_cable(), {.when = "sum tension(links) > 20", .action = EventAction::Break});
            }).find("speaks of no single thing"),
            std::string::npos);
}

TEST(ConditionsOnMembers, AnyOverPointsNamesThePoint) {
  for (const char* when : {"any position(all).z < -3.5", "min position([2, 3, 4]).z < -3.5"}) {
    Simulation simulation(hang_cable());
    simulation.add_event({.when = when});
    ASSERT_TRUE(simulation.advance_to(0.1).ok());
    ASSERT_EQ(simulation.passages().size(), 1u);
    EXPECT_EQ(simulation.passages()[0].member, "point 4") << when;
  }
}

/// A run tells from it that the advance ended there, although that is where it should end.
TEST(ConditionsOnMembers, AFunctionThatStopsTellsSo) {
  Simulation simulation(hang_cable());
  const auto function = [](double t, std::span<const double>, std::span<const double>) { return t - 0.1; };
  simulation.add_event({.value = function, .stops = true});
  simulation.add_event({.value = function});
  ASSERT_TRUE(simulation.advance_to(0.1).ok());
  ASSERT_EQ(simulation.passages().size(), 2u);
  EXPECT_EQ(simulation.passages()[0].action, EventAction::Stop);
  EXPECT_EQ(simulation.passages()[1].action, EventAction::Report);
}

}  // namespace
}  // namespace tanor
