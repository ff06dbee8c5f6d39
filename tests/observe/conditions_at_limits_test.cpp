/// Conditions that begin at their limits, that end a run at an instant of output, and the members that they name.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

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
  system.units = units_from_name("si");
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

/// One of two beads of 10 N and 20 N leaves the floor, which then carries the other one.
TEST(ConditionsOnMembers, AGroupThatLetGoOfAMemberHasTheForceOfTheRest) {
  System system;
  system.add_point({.position = {0.0, 0.0, 0.0}, .mass = 1.0});
  system.add_point({.position = {1.0, 0.0, 0.0}, .mass = 2.0});
  system.constraints.push_back(Planes{.name = "floor", .points = {0, 1}, .normal = Vector3{0, 0, 1}});
  system.add_gravity({0.0, 0.0, -10.0});
  Simulation simulation(system);
  simulation.add_event({.when = "t > 0.1", .action = EventAction::Release, .of = "floor[0]"});
  for (const char* text : {"force(floor).z", "moment(floor, y)", "multiplier(floor)", "force(floor[1]).z",
                           "sum multiplier(floor)", "min force(floor)", "each force(floor)", "max moment(floor, y)"})
    simulation.add_observable({.text = text});
  const auto values = [&](std::size_t k) { return simulation.observe()[k].values; };
  EXPECT_NEAR(values(0)[0], 30.0, 1e-12);
  EXPECT_NEAR(values(5)[0], 10.0, 1e-12);
  EXPECT_NEAR(values(6)[2], 10.0, 1e-12);
  EXPECT_NEAR(values(6)[5], 20.0, 1e-12);
  EXPECT_NEAR(values(7)[0], 0.0, 1e-12);
  EXPECT_EQ(simulation.observe()[5].member, "floor[0]");
  EXPECT_EQ(simulation.observe()[6].members[1], "floor[1]");
  const Outcome outcome = simulation.advance_to(0.3);
  ASSERT_TRUE(outcome.ok()) << outcome.what;
  (void)simulation.multipliers();  // which marks those that are gone
  EXPECT_NEAR(values(0)[0], 20.0, 1e-12);
  EXPECT_NEAR(values(1)[0], -20.0, 1e-12);
  EXPECT_TRUE(std::isnan(values(2)[0]));
  EXPECT_NEAR(values(2)[1], 20.0, 1e-12);
  EXPECT_NEAR(values(3)[0], 20.0, 1e-12);
  EXPECT_NEAR(values(4)[0], 20.0, 1e-12);
  EXPECT_NEAR(values(5)[0], 20.0, 1e-12);
  EXPECT_EQ(simulation.observe()[5].member, "floor[1]");
  EXPECT_TRUE(std::isnan(values(6)[2]));
  EXPECT_NEAR(values(7)[0], -20.0, 1e-12);
  EXPECT_EQ(simulation.observe()[7].member, "floor[1]");
}

/// The second one of two beads, of two hooks, carries 20 N and goes, and the first one stays with its 10 N.
TEST(ConditionsOnMembers, AnyNamesTheGuideOrTheSupport) {
  System system;
  RodGroup rods = system.add_rods("rods");
  for (const double x : {1.0, 2.0}) {
    const Point top = system.add_point({.position = {x, 0.0, 0.0}, .mass = 1.0});
    rods.join(top, system.add_point({.position = {x, 0.0, -1.0}, .mass = x}));
    system.add_point({.position = {x, 5.0, 0.0}, .mass = x});
  }
  system.supports.push_back({.name = "hooks", .points = {0, 3}});
  system.constraints.push_back(Planes{.name = "floor", .points = {2, 5}, .normal = Vector3{0, 0, 1}});
  system.add_gravity({0.0, 0.0, -10.0});
  for (const auto& [when, member] : {std::pair("any force(floor).z > 15", "floor[1]"),
                                     {"any moment(floor, y) < -15", "floor[1]"},
                                     {"any moment(hooks, y) < -15", "hooks[1]"},
                                     {"15 < max load(hooks)", "hooks[1]"}}) {
    Simulation simulation(system);
    simulation.add_event({.when = when, .action = EventAction::Release});
    const Outcome outcome = simulation.advance_to(0.1);
    ASSERT_TRUE(outcome.ok()) << outcome.what;
    ASSERT_EQ(simulation.passages().size(), 1u) << when;
    EXPECT_EQ(simulation.passages()[0].member, member) << when;
  }
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

/// A rod is as long as it is up to rounding, which passes its length in every second step. The run says so and goes on.
TEST(ConditionsOnNoise, ReportsOfNoiseAreGivenUpAndToldSo) {
  for (const auto& [method, when, most] : {std::tuple(Method::Rattle, "distance(0, 1) > 1", 900u),
                                           {Method::Dopri5, "sin(1e5*t) > 0", 100u}}) {  // of 39,789
    Simulation simulation = start_pendulum(method), resumed = start_pendulum(method);
    for (Simulation* const each : {&simulation, &resumed}) {
      each->add_event({.name = "noise", .when = when});
      each->add_event({.name = "low", .when = "position(1).z < -0.9"});
    }
    ASSERT_TRUE(simulation.advance_to(2.5).ok());
    const auto count = [](const Simulation& of) {
      return static_cast<std::size_t>(std::ranges::count(of.passages(), "noise", &Passage::name));
    };
    EXPECT_GT(count(simulation), 2u) << when;
    EXPECT_LT(count(simulation), most) << when;
    const std::string& warning = simulation.report().accuracy_warning;
    EXPECT_TRUE(warning.starts_with("event \"noise\" changes too often, ")) << warning;
    EXPECT_NE(warning.find(" s, and is not followed further"), std::string::npos) << warning;
    EXPECT_EQ(simulation.passages().size() - count(simulation), 2u) << "the other one is told at each swing";
    const std::size_t before = count(simulation);
    resumed.restore(simulation.save());
    ASSERT_TRUE(resumed.advance_to(2.6).ok());
    EXPECT_EQ(count(resumed), before) << when;
  }
}

/// A rod that turns 1000 times passes its limit once in a turn, and is told each time.
TEST(ConditionsOnNoise, ReportsThatAreFrequentAreTold) {
  for (const Method method : {Method::Taylor, Method::Dop853}) {
    System system;
    const Point hook = system.add_support({0.0, 0.0, 0.0});
    const double turn = 2.0 * std::numbers::pi;
    system.add_rods("rod").join(
        hook, system.add_point({.position = {1.0, 0.0, 0.0}, .velocity = {0.0, turn, 0.0}, .mass = 2.0}));
    Simulation simulation(system, {.method = method, .rtol = 1e-10});
    simulation.add_event({.when = "position(1).x < 0"});
    ASSERT_TRUE(simulation.advance_to(1000.0).ok());
    ASSERT_EQ(simulation.passages().size(), 1000u) << name_of(method);
    EXPECT_NEAR(simulation.passages().back().time, 999.25, 1e-5);
    EXPECT_EQ(simulation.report().accuracy_warning, "");
  }
}

TEST(ConditionsOnMembers, WhatIsGoneBreaksNoSecondTime) {
  Simulation simulation(hang_cable());
  for (const char* when : {"any tension(links) > 3.5", "max tension(links) > 3.8"})
    simulation.add_event({.when = when, .action = EventAction::Break});
  ASSERT_TRUE(simulation.advance_to(0.1).ok());
  ASSERT_EQ(simulation.passages().size(), 2u);
  for (const Passage& passage : simulation.passages()) EXPECT_EQ(passage.member, "links[0]");
  EXPECT_EQ(simulation.passages()[0].action, EventAction::Break);
  EXPECT_EQ(simulation.passages()[1].action, EventAction::Report);
}

TEST(ConditionsOnMembers, AnObserverStopsAMotionWithConditions) {
  Simulation simulation = start_pendulum(Method::Rattle);
  simulation.add_event({.when = "t > 0.5"});
  ASSERT_TRUE(simulation.advance_to(1.0, [](const MotionReport&) { return false; }).ok());
  EXPECT_NEAR(simulation.time(), 1e-3, 1e-12);
}

/// A rod and a spring break in a periodic cell. The pair that the rod kept apart has pair forces then.
TEST(ConditionsOnMembers, EnergiesAndPressureAreThoseOfWhatIsLeft) {
  System system;
  const double edge = 10.0, stiffness = 8.0;
  system.cell = Cell{.xx = edge, .yy = edge, .zz = edge};
  RodGroup rods = system.add_rods("rods");
  Springs springs{.name = "springs", .stiffness = stiffness, .rest_length = 1.0};
  for (const double y : {1.0, 4.0, 6.0, 8.0}) {
    const Point a = system.add_point({.position = {2.0, y, 5.0}, .velocity = {0.0, 0.0, 0.4}});
    const Point b = system.add_point({.position = {3.3, y, 5.0}, .velocity = {0.0, 0.0, -0.6}});
    if (y < 5.0)
      rods.join(a, b);
    else
      springs.pairs.push_back({a.index, b.index});
  }
  PairForces pairs{.name = "pairs", .law = PairLaw::Lj, .sigma = 1.0, .cutoff = 2.5};
  pairs.points = {0, 1, 2, 3};
  pairs.box = {edge, edge, edge};
  pairs.exclude_rods = true;
  system.forces = {springs, pairs};
  Simulation simulation(system, {.method = Method::Dop853, .rtol = 1e-11});
  for (const char* const of : {"rods[0]", "springs[0]"})
    simulation.add_event({.when = "t > 0.1", .action = EventAction::Break, .of = of});
  for (const char* text :
       {"potential()", "potential(springs)", "potential(pairs)", "pressure()", "virial()", "each tension(rods)"})
    simulation.add_observable({.text = text});
  const Outcome outcome = simulation.advance_to(0.3);
  ASSERT_TRUE(outcome.ok()) << outcome.what;

  const auto length = [&](std::size_t i) {
    const double* const r = simulation.positions().data() + 3 * i;
    return std::hypot(r[3] - r[0], r[4] - r[1], r[5] - r[2]);
  };
  double twice_kinetic = 0.0;
  for (const double v : simulation.velocities().first(3 * 8)) twice_kinetic += v * v;
  const double stretch = length(6) - 1.0, s6 = std::pow(length(0), -6.0);
  const double virial =
      24.0 * s6 * (2.0 * s6 - 1.0) + simulation.multipliers()[1] * length(2) - stiffness * stretch * length(6);
  const std::span<const Observed> found = simulation.observe();
  EXPECT_NEAR(found[1].values[0], 0.5 * stiffness * stretch * stretch, 1e-12);
  EXPECT_NEAR(found[0].values[0], found[1].values[0] + found[2].values[0], 1e-12);
  EXPECT_LT(found[2].values[0], -0.01);
  EXPECT_NEAR(found[3].values[0], (twice_kinetic + virial) / (3.0 * edge * edge * edge), 1e-13);
  EXPECT_NEAR(found[4].values[0] + found[4].values[1] + found[4].values[2], virial, 1e-11);
  EXPECT_TRUE(std::isnan(found[5].values[0]));
  EXPECT_TRUE(std::isnan(simulation.solution().multipliers[0]));
  EXPECT_EQ(simulation.solution().multipliers[1], simulation.multipliers()[1]);
  EXPECT_TRUE(simulation.certify().passed()) << simulation.certify().line();
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
