/// Rods and ropes that break at a tension: closed forms, the same as by an event, and what is refused.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <tanor/constrainer.hpp>
#include <tanor/motion.hpp>
#include <tanor/ranks.hpp>

#include "errors.hpp"
#include "measures.hpp"
#include "observe/cable.hpp"

namespace tanor {
namespace {

constexpr MotionOptions accurate{.rtol = 1e-12, .atol = 1e-13};

/// A bob of 1 kg on a rod or a rope of 1 m, let go where the rope is level; its tension is 3 m g (depth).
template <class Group>
System make_pendulum(Group line, double g = 10.0) {
  System system;
  system.positions = {0, 0, 0, 1, 0, 0};
  system.masses = {1, 1};
  system.supports = {{.name = "hook", .points = {0}}};
  system.constraints = {std::move(line)};
  system.add_gravity({0.0, 0.0, -g});
  return system;
}

/// Three pendulums side by side, each with its own strength.
template <class Group>
System make_three(Group group) {
  System system;
  for (int k = 0; k < 3; ++k) {
    for (const double x : {0.0, 1.0}) system.positions.insert(system.positions.end(), {x, 1.0 * k, 0.0});
    system.masses.insert(system.masses.end(), 2, 1.0);
    system.supports.push_back({.points = {2 * k}});
  }
  system.constraints = {std::move(group)};
  system.add_gravity({0.0, 0.0, -10.0});
  return system;
}

/// At 3 m g d = strength the bob is let go with v^2 = 2 g d along its circle, and flies.
template <class Group>
void expect_flight(Group line, double strength) {
  line.breaks_at = {strength};
  Simulation simulation(make_pendulum(line), accurate, {.threads = 1});
  const Outcome outcome = simulation.advance_to(1.0);
  ASSERT_TRUE(outcome.ok()) << outcome.what;
  ASSERT_EQ(simulation.passages().size(), 1u);
  const Passage& passage = simulation.passages()[0];
  EXPECT_EQ(passage.name, "breaks_at of line");
  EXPECT_EQ(passage.member, "line[0]");
  EXPECT_EQ(passage.action, EventAction::Break);
  EXPECT_EQ(passage.taken, "constraints/0/0");
  EXPECT_EQ(passage.rest, "point 1 is without constraints");
  const double depth = strength / 30.0, v = std::sqrt(20.0 * depth), x = std::sqrt(1.0 - depth * depth);
  const double t = 1.0 - passage.time;
  EXPECT_NEAR(simulation.positions()[3], x - v * depth * t, 1e-9);
  EXPECT_NEAR(simulation.positions()[5], -depth - v * x * t - 5.0 * t * t, 1e-9);
  EXPECT_TRUE(std::isnan(simulation.multipliers()[0]));
  EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), 1e-10);
  EXPECT_TRUE(simulation.certify().passed()) << simulation.certify().line();
}

TEST(BreaksAt, ABobFliesFromWhereItsRodOrRopeBreaks) {
  expect_flight(Rods{.name = "line", .pairs = {{0, 1}}}, 20.0);
  expect_flight(Ropes{.name = "line", .paths = {{0, 1}}}, 20.0);
  expect_flight(Ropes{.name = "line", .paths = {{0, 1}}}, 7.5);
}

TEST(BreaksAt, EachMemberHasItsOwnStrength) {
  for (const bool is_rope : {false, true}) {
    Rods rods{.name = "lines", .pairs = {{0, 1}, {2, 3}, {4, 5}}, .breaks_at = {25.0, 60.0, 12.0}};
    Ropes ropes{.name = "lines", .paths = {{0, 1}, {2, 3}, {4, 5}}, .breaks_at = {25.0, 60.0, 12.0}};
    Simulation simulation(is_rope ? make_three(ropes) : make_three(rods), accurate, {.threads = 1});
    ASSERT_TRUE(simulation.advance_to(1.0).ok());
    std::vector<std::string> members;
    for (const Passage& passage : simulation.passages()) members.push_back(passage.member);
    EXPECT_EQ(members, (std::vector<std::string>{"lines[2]", "lines[0]"})) << "60 N are never reached";
  }
}

/// One number for all is the event that users write by hand: instants, members and the rest of the motion.
TEST(BreaksAt, IsTheEventOnTheTension) {
  const auto swing = [](bool by_hand) {
    System system = make_cable(12);
    for (std::size_t k = 1; k <= 12; ++k) {
      system.positions[3 * k] = 0.1 * static_cast<double>(k);
      system.positions[3 * k + 2] = 0.0;
    }
    if (!by_hand) std::get<Rods>(system.constraints[0]).breaks_at = {60.0};
    Simulation simulation(system, accurate, {.threads = 1});
    if (by_hand) simulation.add_event({.when = "any tension(links) > 60", .action = EventAction::Break});
    EXPECT_EQ(simulation.add_event({.when = "t > 0.1"}), 1u) << "events of users come behind";
    const Outcome outcome = simulation.advance_to(1.0);
    EXPECT_TRUE(outcome.ok()) << outcome.what;
    return simulation;
  };
  const Simulation own = swing(false), event = swing(true);
  ASSERT_EQ(own.passages().size(), event.passages().size());
  ASSERT_GE(own.passages().size(), 2u);
  for (std::size_t k = 0; k < own.passages().size(); ++k) {
    EXPECT_NEAR(own.passages()[k].time, event.passages()[k].time, 1e-11);
    EXPECT_EQ(own.passages()[k].member, event.passages()[k].member);
  }
  EXPECT_LT(largest_difference(own.positions(), event.positions()), 1e-8);
}

/// Two rods share a load of 10 N. What is left of them breaks at the same instant, and a third one stays.
TEST(BreaksAt, WhatCarriesMoreThenBreaksAtTheSameInstant) {
  System system = make_pendulum(Rods{.name = "line", .pairs = {{0, 1}, {0, 1}}, .breaks_at = {4.0, 8.0}});
  system.positions = {0, 0, 0, 0, 0, -1};
  system.constraints.push_back(Ropes{.name = "spare", .paths = {{0, 1}}, .length = 1.5, .breaks_at = {1e3}});
  Simulation simulation(system, accurate, {.threads = 1});
  ASSERT_TRUE(simulation.advance_to(1.0).ok());
  ASSERT_EQ(simulation.passages().size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(simulation.passages()[k].time, 0.0);
    EXPECT_EQ(simulation.passages()[k].member, "line[" + std::to_string(k) + "]");
  }
  EXPECT_NEAR(simulation.positions()[5], -1.5, 1e-12);
}

/// An impulse breaks nothing; the tension right behind it does.
TEST(BreaksAt, ARopeBreaksRightBehindItsSnapByItsTensionAlone) {
  for (const double strength : {5.0, 40.0}) {  // N; it pulls with 8.72 after the impulse of 1.13 N s, 14.72 below
    System system = make_pendulum(Ropes{.name = "line", .paths = {{0, 1}}, .length = 1.0, .breaks_at = {strength}});
    system.positions = {0, 0, 0, 0.6, 0, -0.7};
    Simulation simulation(system, accurate, {.threads = 1});
    ASSERT_TRUE(simulation.advance_to(0.5).ok());
    ASSERT_EQ(simulation.report().contact_events.size(), 1u);
    EXPECT_NEAR(simulation.report().contact_events[0].impulses[0], std::sqrt(2.0) * 0.8, 1e-10);
    ASSERT_EQ(simulation.passages().size(), strength < 10.0 ? 1u : 0u);
    if (strength < 10.0)
      EXPECT_NEAR(simulation.passages()[0].time, simulation.report().contact_events[0].time, 1e-14);
    else
      EXPECT_NEAR(std::hypot(simulation.positions()[3], simulation.positions()[5]), 1.0, 1e-12);
  }
}

TEST(BreaksAt, AFreshMotionGoesOnFromASnapshotWithTheSameBits) {
  const auto make = [] {
    return Simulation(make_three(Ropes{.name = "lines", .paths = {{0, 1}, {2, 3}, {4, 5}}, .breaks_at = {25, 60, 12}}),
                      accurate, {.threads = 1});
  };
  Simulation whole = make(), first = make(), rest = make();
  for (const double t : {0.35, 1.0}) ASSERT_TRUE(whole.advance_to(t).ok());
  ASSERT_TRUE(first.advance_to(0.35).ok());
  ASSERT_EQ(first.passages().size(), 1u);
  rest.restore(first.save());
  ASSERT_TRUE(rest.advance_to(1.0).ok());
  ASSERT_EQ(rest.passages().size(), 2u);
  EXPECT_EQ(rest.passages()[1].time, whole.passages()[1].time);
  EXPECT_TRUE(std::ranges::equal(rest.positions(), whole.positions()));
}

TEST(BreaksAt, TheUtilisationIsTheTensionOverIt) {
  System system = make_three(Ropes{.name = "lines", .paths = {{0, 1}, {2, 3}, {4, 5}}, .breaks_at = {20, 50, 40}});
  system.positions = {0, 0, 0, 0, 0, -1, 0, 1, 0, 0, 1, -1, 0, 2, 0, 0, 2, -1};
  Simulation simulation(system);
  simulation.add_observable({.text = "utilisation(lines)"});
  EXPECT_LT(largest_difference(simulation.observe()[0].values, std::vector{0.5, 0.2, 0.25}), 1e-14);
  std::vector<std::string> texts;
  for (const Observable& each : default_observables(system)) texts.push_back(each.text);
  EXPECT_EQ(std::ranges::count(texts, "max utilisation(lines)"), 1);
  EXPECT_EQ(std::ranges::count(texts, "min utilisation(lines)"), 0);
  EXPECT_NE(error_of([&] { check_observable(make_cable(2), {.text = "utilisation(links)"}); }).find("has no breaks_at"),
            std::string::npos);
}

/// Two ranks of which this is the first.
struct TwoRanks final : Ranks {
  int rank() const override { return 0; }
  int size() const override { return 2; }
  void sum(std::span<double>) override {}
  void find_largest(std::span<double>) override {}
  void share(int, std::string*) override {}
  void exchange(std::span<const Message>) override {}
};

TEST(BreaksAt, WhatIsWrongHasItsPlace) {
  const auto error = [](std::vector<double> strength, SolverOptions solver = {}, bool has_coordinates = false) {
    System system = make_pendulum(Rods{.name = "line", .pairs = {{0, 1}}, .breaks_at = std::move(strength)});
    if (has_coordinates) {
      system.coordinates = {ChainAngles{.points = {1}, .anchor = 0}};
      solver.form = Form::Tangent;
    }
    return error_of([&] { Simulation(system, {}, solver); });
  };
  EXPECT_EQ(error({-3.0}), "/constraints/0/breaks_at: breaks_at -3 is not positive");
  EXPECT_EQ(error({0.0}), "/constraints/0/breaks_at: breaks_at 0 is not positive");
  EXPECT_EQ(error({1.0, 2.0}).find("/constraints/0/breaks_at: "), 0u) << error({1.0, 2.0});
  EXPECT_EQ(error({20.0}, {}, true),
            "/constraints/0/breaks_at: what coordinates place cannot be taken out; take solver.form normal");
  const Rods rods{.name = "line", .pairs = {{0, 1}}, .breaks_at = {20.0}};
  const std::vector<double> masses{1.0, 1.0}, places{0, 0, 0, 1, 0, 0};
  EXPECT_EQ(error_of([&] { (void)Constrainer(masses, {rods}, places); }),
            "/constraints/0/breaks_at: the members of a Constrainer go where its host removes them");
  TwoRanks ranks;
  EXPECT_EQ(error_of([&] {
              (void)take_part(make_pendulum(rods), std::vector<int>{0, 0}, ranks);
            }),
            "/constraints/0/breaks_at: members break on one rank alone; take one, or leave it out");
}

}  // namespace
}  // namespace tanor
