#include <gtest/gtest.h>

#include <cmath>

#include <tanor/motion.hpp>

#include "errors.hpp"

namespace tanor {
namespace {

constexpr double fall = 9.81;  // m/s^2

/// A pendulum of length 1 that starts at rest, horizontally. Its tension is 3 m g sin(theta), theta from the
/// horizontal.
System make_pendulum(double mass = 2.0) {
  System system;
  const Point hook = system.add_support({0.0, 0.0, 0.0}, {}, "hook");
  const Point bob = system.add_point({.position = {1.0, 0.0, 0.0}, .mass = mass});
  system.add_rods("rod").join(hook, bob);
  system.add_gravity({0.0, 0.0, -fall});
  return system;
}

class Conditions : public testing::TestWithParam<Method> {
 protected:
  MotionOptions options() const { return {.method = GetParam(), .step = step(), .rtol = 1e-12}; }
  double step() const { return has_fixed_steps(GetParam()) ? 1e-3 : 0.0; }
  double accuracy() const { return GetParam() == Method::Rk4 ? 1e-7 : 1e-9; }
};
INSTANTIATE_TEST_SUITE_P(Methods, Conditions,
                         testing::Values(Method::Taylor, Method::Dop853, Method::Dopri5, Method::Radau5, Method::Rk4));

/// It breaks where sin(theta) = 2/3, and flies on from there.
TEST_P(Conditions, ARodBreaksAtItsTensionAndItsPointFliesOn) {
  Simulation simulation(make_pendulum(), options());
  simulation.add_event({.name = "breaks", .when = "any tension(rod) > 39.24", .action = EventAction::Break});
  simulation.add_observable({.text = "max tension(rod)", .every_step = true});
  {
    const Outcome outcome = simulation.advance_to(0.6);
    ASSERT_TRUE(outcome.ok()) << outcome.what;
  }
  ASSERT_EQ(simulation.passages().size(), 1u);
  const Passage& passage = simulation.passages()[0];
  EXPECT_EQ(passage.name, "breaks");
  EXPECT_EQ(passage.member, "rod[0]");
  EXPECT_EQ(passage.rest, "point 1 is without constraints");
  EXPECT_NEAR(passage.energy_lost, 0.0, 1e-10);
  const double s = 2.0 / 3.0, c = std::sqrt(1.0 - s * s), speed = std::sqrt(2.0 * fall * s), dt = 0.6 - passage.time;
  EXPECT_NEAR(simulation.positions()[3], c - speed * s * dt, accuracy());
  EXPECT_NEAR(simulation.positions()[5], -s - speed * c * dt - 0.5 * fall * dt * dt, accuracy());
  EXPECT_TRUE(std::isnan(simulation.solution().multipliers[0]) && std::isnan(simulation.multipliers()[0]));
  EXPECT_TRUE(simulation.rank().dependences.empty());
  EXPECT_NEAR(simulation.observe()[0].largest[0].value, 39.24, 1e-6);
  EXPECT_NEAR(simulation.observe()[0].least[0].value, 0.0, 1e-9) << "it was so at the start, before the break";
  EXPECT_TRUE(simulation.certify().passed()) << simulation.certify().line();
  EXPECT_NEAR(simulation.report().energy.drift_relative(), 0.0, 1e-8);
}

TEST_P(Conditions, AHookLetsGoAtATime) {
  System system = make_pendulum();
  system.masses[0] = 2.0;
  Simulation simulation(system, options());
  simulation.add_event({.when = "t > 0.25", .action = EventAction::Release, .of = "hook"});
  {
    const Outcome outcome = simulation.advance_to(0.25);
    ASSERT_TRUE(outcome.ok()) << outcome.what;
  }
  const double middle = 0.5 * simulation.positions()[5], speed = 0.5 * simulation.velocities()[5];
  {
    const Outcome outcome = simulation.advance_to(0.5);
    ASSERT_TRUE(outcome.ok()) << outcome.what;
  }
  ASSERT_EQ(simulation.passages().size(), 1u);
  EXPECT_EQ(simulation.passages()[0].time, 0.25);
  EXPECT_EQ(simulation.passages()[0].member, "hook");
  // Both ends weigh the same, so that the middle falls freely.
  const double fallen = 0.5 * (simulation.positions()[2] + simulation.positions()[5]);
  EXPECT_NEAR(fallen, middle + 0.25 * speed - 0.5 * fall * 0.0625, accuracy());
  EXPECT_TRUE(simulation.certify().passed());
}

TEST(ConditionsOnGroups, ACableThatIsTooWeakBreaksAtTheStart) {
  System system;
  RodGroup rods = system.add_rods("links");
  Point last = system.add_support({0.0, 0.0, 0.0}, {}, "hook");
  for (int k = 1; k <= 4; ++k) {
    const Point next = system.add_point({.position = {0.0, 0.0, -1.0 * k}, .mass = 1.0});
    rods.join(last, next);
    last = next;
  }
  system.add_gravity({0.0, 0.0, -10.0});
  Simulation simulation(system);
  // Tensions are 40, 30, 20, 10; once the first is gone, all fall freely and nothing pulls.
  simulation.add_event({.when = "any tension(links) > 25", .action = EventAction::Break});
  {
    const Outcome outcome = simulation.advance_to(1.0);
    ASSERT_TRUE(outcome.ok()) << outcome.what;
  }
  ASSERT_EQ(simulation.passages().size(), 1u);
  EXPECT_EQ(simulation.passages()[0].member, "links[0]");
  EXPECT_EQ(simulation.passages()[0].time, 0.0);
  for (int k = 1; k <= 4; ++k) EXPECT_NEAR(simulation.positions()[3 * k + 2], -1.0 * k - 5.0, 1e-9);
  EXPECT_TRUE(std::isnan([&] {
    simulation.add_observable({.text = "tension(links[0])"});
    return simulation.observe()[0].values[0];
  }()));
}

TEST(ConditionsOnGroups, ASpringThatBreaksTellsItsEnergy) {
  System system;
  const Point wall = system.add_support({0.0, 0.0, 0.0});
  const Point block = system.add_point({.position = {1.0, 0.0, 0.0}, .velocity = {2.0, 0.0, 0.0}, .mass = 1.0});
  system.forces.push_back(
      Springs{.name = "spring", .pairs = {{wall.index, block.index}}, .stiffness = 16.0, .rest_length = 1.0});
  Simulation simulation(system, {.method = Method::Dop853, .rtol = 1e-12});
  simulation.add_event({.when = "tension(spring) > 4.8", .action = EventAction::Break});
  {
    const Outcome outcome = simulation.advance_to(1.0);
    ASSERT_TRUE(outcome.ok()) << outcome.what;
  }
  const Passage& passage = simulation.passages().front();
  // x - 1 = 0.5 sin(4 t) = 0.3
  const double t = std::asin(0.6) / 4.0;
  EXPECT_NEAR(passage.time, t, 1e-11);
  EXPECT_NEAR(passage.energy_lost, 0.5 * 16.0 * 0.09, 1e-10);
  EXPECT_NEAR(simulation.positions()[3], 1.3 + 1.6 * (1.0 - t), 1e-10);
  EXPECT_NEAR(simulation.report().energy.drift_relative(), 0.0, 1e-9);

  Simulation stopped(system, {.method = Method::Dop853, .rtol = 1e-12});
  stopped.add_event({.when = "tension(spring) > 4.8", .action = EventAction::Break});
  stopped.add_event({.when = "position(1).x > 1.3", .action = EventAction::Stop});
  const Outcome outcome = stopped.advance_to(1.0);
  ASSERT_TRUE(outcome.ok()) << outcome.what;
  EXPECT_NEAR(stopped.time(), t, 1e-9);
  EXPECT_NEAR(stopped.report().energy.drift_relative(), 0.0, 1e-9);
}

/// Springs of 0.32 J and 0.64 J break at one instant, by one condition or as one breaks after the other.
TEST(ConditionsOnGroups, EachThingTellsItsOwnEnergy) {
  System system;
  const Point wall = system.add_support({0.0, 0.0, 0.0});
  const Point block = system.add_point({.position = {1.0, 0.0, 0.0}, .velocity = {2.0, 0.0, 0.0}, .mass = 1.0});
  for (const auto& [name, stiffness] : {std::pair("a", 16.0), std::pair("b", 32.0)})
    system.forces.push_back(
        Springs{.name = name, .pairs = {{wall.index, block.index}}, .stiffness = stiffness, .rest_length = 1.0});
  const auto run = [&](const Event& first, const Event& second, double t_end) {
    Simulation simulation(system, {.method = Method::Dop853, .rtol = 1e-12});
    simulation.add_event(first);
    simulation.add_event(second);
    const Outcome outcome = simulation.advance_to(t_end);
    EXPECT_TRUE(outcome.ok()) << outcome.what;
    EXPECT_NEAR(simulation.report().energy.drift_relative(), 0.0, 1e-9);
    return std::vector(simulation.passages().begin(), simulation.passages().end());
  };
  using enum EventAction;
  const auto both = run({.when = "position(1).x > 1.2", .action = Break, .of = "a[0]"},
                        {.when = "position(1).x > 1.2", .action = Break, .of = "b[0]"}, 1.0);
  const auto cascade =
      run({.when = "tension(a) > 3.2", .action = Break}, {.when = "tension(b) > 6.4", .action = Break}, 1.0);
  for (const std::vector<Passage>& passages : {both, cascade}) {
    ASSERT_EQ(passages.size(), 2u);
    EXPECT_NEAR(passages[0].energy_lost, 0.32, 1e-9);
    EXPECT_NEAR(passages[1].energy_lost, 0.64, 1e-9);
    EXPECT_EQ(passages[1].rest, "") << "no constraint was there before";
  }
  const auto same = run({.when = "position(1).x > 1.2", .action = Break, .of = "a[0]"},
                        {.when = "position(1).x > 1.2", .action = Break, .of = "a[0]"}, 0.2);
  ASSERT_EQ(same.size(), 2u);
  EXPECT_NEAR(same[0].energy_lost, 0.32, 1e-9);
  EXPECT_EQ(same[1].energy_lost, 0.0);
}

/// The second of three springs breaks; the others stay at their own rest lengths.
TEST(ConditionsOnGroups, WhatIsLeftOfAGroupKeepsItsOwnNumbers) {
  System system;
  const Point wall = system.add_support({0.0, 0.0, 0.0});
  Springs springs{.name = "springs", .stiffness = 16.0, .rest_length = std::vector{1.0, 2.0, 3.0}};
  for (const double place : springs.rest_length.constants) {
    const Vector3 velocity{place == 2.0 ? 2.0 : 0.0, 0.0, 0.0};
    springs.pairs.push_back(
        {wall.index, system.add_point({.position = {place, 0.0, 0.0}, .velocity = velocity, .mass = 1.0}).index});
  }
  system.forces.push_back(springs);
  Simulation simulation(system, {.method = Method::Dop853, .rtol = 1e-12});
  simulation.add_event({.when = "any tension(springs) > 4.8", .action = EventAction::Break});

  const Outcome outcome = simulation.advance_to(1.0);

  ASSERT_TRUE(outcome.ok()) << outcome.what;
  ASSERT_EQ(simulation.passages().size(), 1u);
  EXPECT_EQ(simulation.passages()[0].member, "springs[1]");
  EXPECT_NEAR(simulation.positions()[3], 1.0, 1e-12);
  EXPECT_GT(simulation.positions()[6], 2.3);
  EXPECT_NEAR(simulation.positions()[9], 3.0, 1e-12);
}

/// Two rods in a line between supports hold their point by prestress, also once the oblique ones are gone.
TEST(ConditionsOnGroups, ARestThatPrestressHoldsStaysThere) {
  for (const Method method : {Method::Taylor, Method::Dop853}) {
    System system;
    RodGroup rods = system.add_rods("links");
    const Point left = system.add_support({0.0, 0.0, 0.0}), right = system.add_support({2.0, 0.0, 0.0});
    const Point above = system.add_support({1.3, 0.4, 0.8}), beside = system.add_support({0.9, -0.7, 0.9});
    const Point middle = system.add_point({.position = {1.0, 0.0, 0.0}, .mass = 1.0});
    rods.join(left, middle);
    rods.join(middle, right);
    rods.join(middle, above);
    rods.join(middle, beside);
    system.add_gravity({0.0, 0.0, -10.0});
    Simulation simulation(system, {.method = method});
    for (const char* of : {"links[2]", "links[3]"})
      simulation.add_event({.when = "t > 0.1", .action = EventAction::Break, .of = of});
    const Outcome outcome = simulation.advance_to(0.3);
    EXPECT_TRUE(outcome.ok()) << outcome.what;
    EXPECT_EQ(simulation.positions()[14], 0.0);
    EXPECT_EQ(simulation.plan().prestress_rigid_points, std::vector<Index>{4});
    EXPECT_TRUE(std::isnan(simulation.multipliers()[0]));
  }
}

/// Two rods in a line between supports have tensions that no equation determines.
TEST(ConditionsOnGroups, ForcesThatPrestressLeavesOpenAreNotKnown) {
  System system;
  const Point left = system.add_support({0.0, 0.0, 0.0}, {}, "left"), right = system.add_support({2.0, 0.0, 0.0});
  const Point middle = system.add_point({.position = {1.0, 0.0, 0.0}, .mass = 1.0});
  const Point bob = system.add_point({.position = {0.0, 0.0, -1.0}, .mass = 2.0});
  RodGroup rods = system.add_rods("links");
  rods.join(left, middle);
  rods.join(middle, right);
  rods.join(left, bob);
  system.add_gravity({0.0, 0.0, -10.0});
  Simulation simulation(system);
  for (const char* text : {"tension(links)", "max tension(links)", "load(left)", "reaction(3)"})
    simulation.add_observable({.text = text});
  const std::span<const Observed> found = simulation.observe();
  EXPECT_TRUE(std::isnan(found[0].values[0]) && std::isnan(found[0].values[1]));
  EXPECT_NEAR(found[0].values[2], 20.0, 1e-12);
  EXPECT_TRUE(std::isnan(found[1].values[0])) << "one of the others may be larger";
  EXPECT_TRUE(std::isnan(found[2].values[0]));
  EXPECT_NEAR(found[3].values[2], 20.0, 1e-12);
  const char* const open = "left to a prestress";
  for (const auto& [k, reason] : {std::pair{0, open}, {1, open}, {2, open}, {3, ""}})
    EXPECT_EQ(found[static_cast<std::size_t>(k)].unknown, reason) << k;
  const std::vector<Observable> asked{{.text = "tension(links)"}, {.text = "load(left).x/tension(links[2])"}};
  for (const Observed& each : observe(system, asked, simulation.solution())) EXPECT_EQ(each.unknown, open);
}

/// Two points on a rod of which one hangs have 2 degrees of freedom, and 5 once it is let go.
TEST(ConditionsOnGroups, ASupportThatWasLetGoCountsForTheTemperature) {
  System system;
  const Point hook = system.add_support({0.0, 0.0, 0.0}, {}, "hook");
  const Point bob = system.add_point({.position = {1.0, 0.0, 0.0}, .velocity = {0.0, 2.0, 0.0}, .mass = 1.0});
  system.masses[0] = 1.0;
  system.add_rods("rod").join(hook, bob);
  for (const char* of : {"hook", "hook[0]"}) {
    Simulation simulation(system);
    simulation.add_observable({.text = "temperature()"});
    simulation.add_event({.when = "t > 0.3", .action = EventAction::Release, .of = of});
    EXPECT_NEAR(simulation.observe()[0].values[0], 2.0, 1e-12);
    const Outcome outcome = simulation.advance_to(1.0);
    ASSERT_TRUE(outcome.ok()) << outcome.what;
    EXPECT_NEAR(simulation.observe()[0].values[0], 0.8, 1e-9);
  }
}

/// An entry of which one point has gone lets go of the other one, and what has gone with its entry does not go again.
TEST(ConditionsOnGroups, AnEntryAndItsMembersGoOnce) {
  const auto run = [](const char* first, const char* second) {
    System system;
    system.add_point({.position = {0.0, 0.0, 0.0}, .mass = 1.0});
    system.add_point({.position = {1.0, 0.0, 0.0}, .mass = 1.0});
    system.supports.push_back({.name = "hooks", .points = {0, 1}});
    system.add_gravity({0.0, 0.0, -fall});
    Simulation simulation(system);
    simulation.add_event({.when = "t > 0.1", .action = EventAction::Release, .of = first});
    simulation.add_event({.when = "t > 0.2", .action = EventAction::Release, .of = second});
    const Outcome outcome = simulation.advance_to(0.4);
    EXPECT_TRUE(outcome.ok()) << outcome.what;
    return std::pair(simulation.passages().size(), simulation.positions()[5]);
  };
  const auto [both, other] = run("hooks[0]", "hooks");
  EXPECT_EQ(both, 2u);
  EXPECT_NEAR(other, -0.5 * fall * 0.04, 1e-9);
  const auto [once, same] = run("hooks", "hooks[1]");
  EXPECT_EQ(once, 1u);
  EXPECT_NEAR(same, -0.5 * fall * 0.09, 1e-9);
}

/// "20 < any tension(rod)" is "any tension(rod) > 20", and speaks of the same rod.
TEST(ConditionsOnGroups, TheNumberMayStandFirst) {
  for (const char* when : {"39.24 < any tension(rod)", "any tension(rod) > 39.24", "39.24 < tension(rod)",
                           "any tension(rod) > 2*19.62 + 0*t", "2*19.62 + 0*t < any tension(rod)"}) {
    Simulation simulation(make_pendulum(), {.method = Method::Dop853, .rtol = 1e-11});
    simulation.add_event({.when = when, .action = EventAction::Break});
    ASSERT_TRUE(simulation.advance_to(0.6).ok());
    ASSERT_EQ(simulation.passages().size(), 1u) << when;
    EXPECT_EQ(simulation.passages()[0].member, "rod[0]");
    const double speed = std::sqrt(2.0 * fall * 2.0 / 3.0);
    EXPECT_NEAR(std::hypot(simulation.velocities()[3],
                           simulation.velocities()[5] + fall * (0.6 - simulation.passages()[0].time)),
                speed, 1e-8);
  }
}

/// Three bonds of 10, 20 and 30 N/m are stretched by 0.2. Those that pull too much break at once, one after the other,
/// and the others keep their own numbers, whichever went.
TEST(ConditionsOnGroups, MembersBreakOneAfterTheOtherAndTheOthersStay) {
  System system;
  Bonds bonds{.name = "bonds", .stiffness = std::vector{10.0, 20.0, 30.0}, .rest_length = std::vector{1.0, 1.0, 1.0}};
  const Point wall = system.add_support({0.0, 0.0, 0.0});
  for (const Vector3& place : {Vector3{1.2, 0, 0}, Vector3{0, 1.2, 0}, Vector3{0, 0, 1.2}})
    bonds.pairs.push_back({wall.index, system.add_point({.position = place, .mass = 1.0}).index});
  system.forces.push_back(bonds);
  const auto run = [&](const std::vector<Event>& events) {
    Simulation simulation(system);
    for (const Event& event : events) simulation.add_event(event);
    const Outcome outcome = simulation.advance_to(1e-3);
    EXPECT_TRUE(outcome.ok()) << outcome.what;
    std::array<double, 3> pulls{};  // by what is left
    for (std::size_t k = 0; k < 3; ++k) pulls[k] = -simulation.accelerations()[3 * (k + 1) + k];
    return std::pair(std::vector(simulation.passages().begin(), simulation.passages().end()), pulls);
  };
  const auto [two, left] = run({{.when = "any tension(bonds) > 3", .action = EventAction::Break}});
  ASSERT_EQ(two.size(), 2u);
  EXPECT_EQ(two[0].member, "bonds[2]");
  EXPECT_NEAR(two[0].energy_lost, 0.6, 1e-12);
  EXPECT_EQ(two[1].member, "bonds[1]");
  EXPECT_NEAR(two[1].energy_lost, 0.4, 1e-12);
  EXPECT_NEAR(left[0], 2.0, 1e-3);
  EXPECT_EQ(left[1] + left[2], 0.0);
  const auto [named, last] = run({{.when = "t > -1", .action = EventAction::Break, .of = "bonds[0]"},
                                  {.when = "t > -1", .action = EventAction::Break, .of = "bonds[1]"}});
  EXPECT_EQ(named.size(), 2u);
  EXPECT_EQ(last[0] + last[1], 0.0);
  EXPECT_NEAR(last[2], 6.0, 1e-2);
  const auto [all, none] = run({{.when = "any tension(bonds) > 1", .action = EventAction::Break}});
  EXPECT_EQ(all.size(), 3u);
  EXPECT_EQ(none[0] + none[1] + none[2], 0.0);
}

/// A report at the instant of a break is told once, whatever rounding makes of it there.
TEST(ConditionsOnGroups, AReportAtTheInstantOfABreakIsToldOnce) {
  System system;
  const Point wall = system.add_support({0.0, 0.0, 0.0});
  const Point block = system.add_point({.position = {1.0, 0.0, 0.0}, .velocity = {2.0, 0.0, 0.0}, .mass = 1.0});
  system.forces.push_back(
      Springs{.name = "spring", .pairs = {{wall.index, block.index}}, .stiffness = 16.0, .rest_length = 1.0});
  for (int k = 1; k <= 20; ++k) {
    const std::string when = "position(1).x > 1 + 0.02*" + std::to_string(k);
    Simulation simulation(system, {.method = Method::Dop853, .rtol = 1e-12});
    simulation.add_event({.name = "there", .when = when});
    simulation.add_event({.when = when, .action = EventAction::Break, .of = "spring[0]"});
    ASSERT_TRUE(simulation.advance_to(1.0).ok());
    EXPECT_EQ(simulation.passages().size(), 2u) << k;
  }
}

/// A rod whose length changes with time is no longer asked for it.
TEST(ConditionsOnGroups, ARodThatGrowsBreaks) {
  System system = make_pendulum();
  std::get<Rods>(system.constraints[0]).length = ScalarFunction::formula("1 + 0.5*t");
  Simulation simulation(system, {.method = Method::Dop853, .rtol = 1e-10, .start = StartMode::Project});
  simulation.add_event({.when = "t > 0.2", .action = EventAction::Break, .of = "rod[0]"});
  const Outcome outcome = simulation.advance_to(0.5);
  ASSERT_TRUE(outcome.ok()) << outcome.what;
  EXPECT_EQ(simulation.accelerations()[5], -fall);
  EXPECT_TRUE(simulation.certify().passed()) << simulation.certify().line();
}

/// A condition on a tension that nothing determines is never known to be true.
TEST(ConditionsOnGroups, ForcesThatPrestressLeavesOpenMeetNoCondition) {
  System system;
  RodGroup rods = system.add_rods("links");
  const Point left = system.add_support({0.0, 0.0, 0.0}), right = system.add_support({2.0, 0.0, 0.0});
  const Point middle = system.add_point({.position = {1.0, 0.0, 0.0}, .mass = 1.0});
  rods.join(left, middle);
  rods.join(middle, right);
  system.add_point({.position = {5.0, 0.0, 0.0}, .mass = 1.0});
  system.add_gravity({1.0, 0.0, -10.0});
  Simulation simulation(system);
  try {
    simulation.add_event({.name = "open", .when = "max tension(links) > t - 1"});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()), "\"max tension(links) > t - 1\" is not known: left to a prestress");
  }
  simulation.add_event({.when = "any tension(links) > t - 1"});
  EXPECT_TRUE(simulation.advance_to(0.5).ok()) << simulation.outcome().what;
  EXPECT_TRUE(simulation.passages().empty());
}

TEST(ConditionsOnGroups, PointsThatWereFreeBeforeAreNotNamed) {
  System system = make_pendulum();
  system.add_point({.position = {5.0, 5.0, 5.0}, .mass = 1.0});
  Simulation simulation(system);
  simulation.add_event({.when = "t > 0.1", .action = EventAction::Break, .of = "rod[0]"});
  const Outcome outcome = simulation.advance_to(0.2);
  ASSERT_TRUE(outcome.ok()) << outcome.what;
  EXPECT_EQ(simulation.passages()[0].rest, "point 1 is without constraints");
}

/// A condition that was true when the motion was saved does not become true there once more.
TEST(ConditionsOnGroups, ASavedMotionKnowsWhichConditionsAreTrue) {
  const auto make = [] {
    Simulation simulation(make_pendulum(), {.method = Method::Dop853, .rtol = 1e-11});
    simulation.add_event({.name = "low", .when = "position(1).z < -0.5"});
    return simulation;
  };
  Simulation first = make(), second = make();
  ASSERT_TRUE(first.advance_to(0.5).ok());
  second.restore(first.save());
  ASSERT_TRUE(second.advance_to(0.6).ok());
  ASSERT_EQ(second.passages().size(), 1u);
  EXPECT_EQ(second.passages()[0].time, first.passages()[0].time);
}

TEST(ConditionsOnGroups, AMotionThatWasSavedAfterABreakGoesOn) {
  const auto make = [] {
    Simulation simulation(make_pendulum(), {.method = Method::Dop853, .rtol = 1e-11});
    simulation.add_event({.when = "any tension(rod) > 39.24", .action = EventAction::Break});
    return simulation;
  };
  Simulation first = make(), second = make();
  ASSERT_TRUE(first.advance_to(0.5).ok());
  const std::vector<std::byte> saved = first.save();
  ASSERT_TRUE(first.advance_to(0.8).ok());
  second.restore(saved);
  ASSERT_TRUE(second.advance_to(0.8).ok());
  for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(first.positions()[k], second.positions()[k]);
}

TEST(ConditionsOnGroups, AStopEndsThereAndAReportGoesOn) {
  Simulation simulation(make_pendulum(), {.method = Method::Dop853, .rtol = 1e-12});
  simulation.add_event({.name = "half", .when = "position(1).z < -0.5"});
  simulation.add_event({.name = "low", .when = "position(1).z < -0.9", .action = EventAction::Stop});
  {
    const Outcome outcome = simulation.advance_to(2.0);
    ASSERT_TRUE(outcome.ok()) << outcome.what;
  }
  EXPECT_NEAR(simulation.positions()[5], -0.9, 1e-10);
  EXPECT_LT(simulation.time(), 1.0);
  ASSERT_EQ(simulation.passages().size(), 2u);
  EXPECT_EQ(simulation.passages()[0].name, "half");
  EXPECT_EQ(simulation.passages()[1].name, "low");
}

TEST(ConditionsOnGroups, WhatCannotBreakIsRefused) {
  System system = make_pendulum();
  system.masses[0] = 0.0;
  system.constraints.push_back(Planes{.name = "wall", .points = {1}, .normal = Vector3{0, 1, 0}});
  const auto refuse = [&](const Event& event) { return error_of([&] { check_event(system, event); }); };
  using enum EventAction;
  EXPECT_EQ(refuse({.when = "t > 1", .action = Break, .of = "wall"}),
            "/do: 'wall[0]' is a plane and does not break; rods, ropes, pulleys, springs and bonds do, and release "
            "lets go of it");
  EXPECT_EQ(refuse({.when = "t > 1", .action = Break}),
            "/of: what the event breaks is not said: the condition \"t > 1\" speaks of no single thing");
  EXPECT_EQ(refuse({.when = "t > 1", .action = Release, .of = "hook"}),
            "point 0 is a support without mass and cannot be let go");
  EXPECT_EQ(refuse({.when = "t > 1", .action = Release, .of = "hok"}).substr(0, 83),
            "/of: no constraints or supports or forces are named 'hok' (did you mean hook?); the");
  EXPECT_EQ(refuse({.when = "t >= 0.3"}), "formula \"t >= 0.3\": found >=, wanted >, which passes at the same instant");
  EXPECT_NE(refuse({.when = "tension(rod)"}).find("a condition compares"), std::string::npos);
  EXPECT_NE(refuse({.when = "position(all) > 2"}).find("single numbers"), std::string::npos);
}

/// It is refused before the motion, not when the rod breaks.
TEST(ConditionsOnGroups, CoordinatesKeepWhatTheyPlace) {
  System system = make_pendulum();
  system.coordinates = {ChainAngles{"angles", {1}, 0, 1.0, {}}};
  Simulation simulation(system, {}, {.form = Form::Tangent});
  EXPECT_EQ(error_of([&] { simulation.add_event({.when = "tension(rod) > 1", .action = EventAction::Break}); }),
            "/event: what coordinates place cannot be taken out; take solver.form normal");
}

}  // namespace
}  // namespace tanor
