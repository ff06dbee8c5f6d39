/// Motions of ropes and one-sided guides as users run them: resumed, on threads, with what moves and what goes.

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <tanor/motion.hpp>

#include "measures.hpp"
#include "scene/scene.hpp"

namespace tanor {
namespace {

/// A chain of eight ropes of 1 m falls on a floor 2 m below its support.
scene::Scene falling_ropes() {
  return scene::parse_scene(R"({"tanor_scene": 1, "points": {"masses": 1.2,
    "positions": [[0, 0, 0], [0.9, 0, -0.2], [1.8, 0.1, 0], [2.7, 0, -0.1], [3.6, 0.1, -0.2], [4.5, 0, 0]],
    "velocities": [[0, 0, 0], [0.3, 0.4, 0.2], [-0.1, 0.2, 0.2], [0.9, -0.3, 0.2], [0.2, 0.7, 0.1], [-0.8, 0.4, 0.1]]},
    "supports": [{"points": [0]}],
    "constraints": [
      {"name": "ropes", "kind": "rope", "paths": [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5]], "length": 1},
      {"name": "floor", "kind": "plane", "points": [1, 2, 3, 4, 5], "normal": [0, 0, 1], "offset": -2,
       "side": "at_least"}],
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}], "motion": {"t_end": 2}})",
                            "ropes.json");
}

scene::Scene scene_of(const std::string& points, const std::string& rest) {
  return scene::parse_scene(R"({"tanor_scene": 1, "points": {"masses": 2, )" + points + "}, " + rest +
                                R"(, "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
                                "motion": {"t_end": 1}})",
                            "scene.json");
}

std::vector<double> copy(std::span<const double> numbers) {
  return {numbers.begin(), numbers.end()};
}

/// Expects that no gap is negative by more than rounding.
void expect_gaps(Simulation& simulation, double length) {
  const Certificate certificate = simulation.certify();
  EXPECT_TRUE(certificate.passed()) << certificate.line();
  for (std::size_t i = 2; i < simulation.positions().size(); i += 3)
    EXPECT_GT(simulation.positions()[i], -2.0 - 1e-12 * length) << i;
}

TEST(OneSidedMotion, AChainOfRopesComesToLieOnAFloorWhateverTheMethod) {
  const scene::Scene scene = falling_ropes();
  for (const MotionOptions& motion : {MotionOptions{.method = Method::Taylor}, MotionOptions{.method = Method::Dop853},
                                      MotionOptions{.method = Method::Rattle, .step = 1e-3}}) {
    Simulation simulation(scene.system, motion, {.threads = 1});
    const Outcome outcome = simulation.advance_to(2.0);
    ASSERT_TRUE(outcome.ok()) << name_of(motion.method) << ": " << outcome.what;
    EXPECT_GT(simulation.report().contact_events.size(), 10u);
    expect_gaps(simulation, 5.0);
  }
}

TEST(OneSidedMotion, ThreadsAndResumesLeaveTheBitsAsTheyAre) {
  const scene::Scene scene = falling_ropes();
  std::vector<std::vector<double>> ends;
  for (const int threads : {1, 2, 3}) {
    Simulation simulation(scene.system, {}, {.threads = threads});
    for (const double t : {0.3, 0.7, 1.2}) ASSERT_TRUE(simulation.advance_to(t).ok());
    ends.push_back(copy(simulation.positions()));
  }
  for (const double middle : {0.3, 0.7}) {
    Simulation first(scene.system, {}, {.threads = 1}), second(scene.system, {}, {.threads = 1});
    for (const double t : {0.3, 0.7})
      if (t <= middle) ASSERT_TRUE(first.advance_to(t).ok());
    second.restore(first.save());
    EXPECT_EQ(second.report().contact_events.size(), first.report().contact_events.size());
    for (const double t : {0.7, 1.2})
      if (t > middle) ASSERT_TRUE(second.advance_to(t).ok());
    ends.push_back(copy(second.positions()));
  }
  for (const std::vector<double>& end : ends) EXPECT_EQ(end, ends[0]);
}

/// Snapshots of the instants of all contact events, and of steps between them, go on in a new motion with the bits of
/// one that was not interrupted.
TEST(OneSidedMotion, SnapshotsOfAllEventsLeaveTheBitsAsTheyAre) {
  const scene::Scene ball = scene_of(
      R"("positions": [[0, 0, 1], [2, 0, 0.5]], "velocities": [[0.3, 0, 0], [0, 0.2, 1]])",
      R"("constraints": [{"kind": "plane", "points": [0], "normal": [0.1, 0, 1], "side": "at_least", "restitution": 0.6},
                         {"kind": "sphere", "points": [1], "center": [2, 0, 0.2], "radius": 0.4, "side": "at_most"}])");
  const scene::Scene grazing =
      scene_of(R"("positions": [[0, 0, 0]], "velocities": [[1, 0, 2]])",
               R"("constraints": [{"kind": "plane", "points": [0], "normal": [0, 0, 1], "offset": 0.203873,
                                   "side": "at_most"}])");
  // It swings over its support, where the string is slack from rest, and comes back into it.
  const scene::Scene string =
      scene_of(R"("positions": [[0, 0, 0], [0.3, 0, -0.4]], "velocities": [[0, 0, 0], [1.5, 0, 3.6]])",
               R"("supports": [{"points": [0]}], "constraints": [{"kind": "rope", "paths": [[0, 1]], "length": 1}])");
  constexpr std::size_t every = 11;  // steps
  for (const auto& [scene, t_end] : {std::pair(falling_ropes(), 1.5), {ball, 1.5}, {grazing, 1.0}, {string, 2.2}}) {
    for (const MotionOptions& motion :
         {MotionOptions{.method = Method::Taylor}, MotionOptions{.method = Method::Dop853},
          MotionOptions{.method = Method::Rattle, .step = 1e-3}}) {
      Simulation whole(scene.system, motion, {.threads = 1});
      std::vector<std::vector<std::byte>> saved;
      std::size_t events = 0;
      const bool is_fixed = motion.method == Method::Rattle;
      const Outcome outcome = whole.advance_to(t_end, [&](const MotionReport& report) {
        if (report.contact_events.size() > events || report.steps % (is_fixed ? 29 * every : every) == 0)
          saved.push_back(whole.save());
        events = report.contact_events.size();
        return true;
      });
      ASSERT_TRUE(outcome.ok()) << name_of(motion.method) << ": " << outcome.what;
      EXPECT_GE(events, 1u);
      for (const std::vector<std::byte>& each : saved) {
        Simulation fresh(scene.system, motion, {.threads = 1});
        fresh.restore(each);
        const double from = fresh.time();
        if (from < t_end) ASSERT_TRUE(fresh.advance_to(t_end).ok());
        EXPECT_EQ(copy(fresh.positions()), copy(whole.positions())) << name_of(motion.method) << " from t = " << from;
        EXPECT_EQ(copy(fresh.velocities()), copy(whole.velocities())) << name_of(motion.method) << " from t = " << from;
        EXPECT_EQ(fresh.report().contact_events.size(), whole.report().contact_events.size());
      }
    }
  }
}

/// A support that swings makes a rope slack and taut again; the energy is that of the works.
TEST(OneSidedMotion, ASwingingSupportSnapsItsRope) {
  const scene::Scene scene =
      scene_of(R"("positions": [[0, 0, 0], [0, 0, -0.9]])",
               R"json("supports": [{"points": [0], "motion": {"formula": ["0.3*sin(3*t)", "0", "0.4*sin(5*t)"]}}],
             "constraints": [{"kind": "rope", "paths": [[0, 1]], "length": 1}])json");
  for (const Method method : {Method::Taylor, Method::Dop853}) {
    Simulation simulation(scene.system, {.method = method, .rtol = 1e-11, .atol = 1e-12}, {.threads = 1});
    const Outcome outcome = simulation.advance_to(5.0);
    ASSERT_TRUE(outcome.ok()) << outcome.what;
    EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), 1e-9);
    EXPECT_LT(simulation.report().energy.work_of_impacts, 0.0);
  }
}

/// Given digits leave a taut rope a speed below what can be seen; it stays taut.
TEST(OneSidedMotion, ATautRopeStartsWithVelocitiesOfFewDigits) {
  for (const char* speed : {"-1e-9", "-1e-11", "1e-9", "1e-12"}) {
    const scene::Scene scene = scene_of(
        std::string(R"("positions": [[0, 0, 0], [1, 0, 0]], "velocities": [[0, 0, 0], [)") + speed + ", 0, -1]]",
        R"("supports": [{"points": [0]}], "constraints": [{"kind": "rope", "paths": [[0, 1]], "length": 1}])");
    Simulation simulation(scene.system, {}, {.threads = 1});
    const Outcome outcome = simulation.advance_to(0.5);
    ASSERT_TRUE(outcome.ok()) << speed << ": " << outcome.what;
    EXPECT_LT(simulation.multipliers()[0], -1.0) << speed;
  }
}

TEST(OneSidedMotion, ABrokenRopeAndAGuideThatLetsGoAreGone) {
  const scene::Scene scene = scene_of(R"("positions": [[0, 0, 0], [1, 0, 0], [3, 0, 0]])",
                                      R"("supports": [{"points": [0]}],
         "constraints": [{"name": "rope", "kind": "rope", "paths": [[0, 1]], "length": 1},
                         {"name": "floor", "kind": "plane", "points": [2], "normal": [0, 0, 1], "side": "at_least"}])");
  Simulation simulation(scene.system, {}, {.threads = 1});
  simulation.add_event({.when = "tension(rope) > 40", .action = EventAction::Break});
  simulation.add_event({.when = "t > 0.5", .action = EventAction::Release, .of = "floor"});
  const Outcome outcome = simulation.advance_to(1.0);
  ASSERT_TRUE(outcome.ok()) << outcome.what;
  EXPECT_EQ(simulation.passages().size(), 2u);
  EXPECT_NEAR(simulation.positions()[8], -0.5 * 9.81 * 0.25, 1e-8);  // free since 0.5 s
  EXPECT_LT(simulation.positions()[5], -1.0);                        // below its circle
}

/// A weight hangs below another one. Where the upper rope breaks the upper weight falls faster than the lower one,
/// which is pushed up: the rope between them is slack from that instant on.
TEST(OneSidedMotion, WhatABreakCausesIsListed) {
  scene::Scene scene = scene_of(R"("positions": [[0, 0, 0], [0, 0, -1], [0, 0, -2]])", R"("supports": [{"points": [0]}],
         "constraints": [{"name": "ropes", "kind": "rope", "paths": [[0, 1], [1, 2]]}])");
  scene.system.forces.push_back(ConstantForce{.points = {2}, .force = Vector3{0.0, 0.0, 6.0}});
  Simulation simulation(scene.system, {}, {.threads = 1});
  simulation.add_event({.when = "t > 0.25", .action = EventAction::Break, .of = "ropes[0]"});
  const Outcome outcome = simulation.advance_to(0.5);
  ASSERT_TRUE(outcome.ok()) << outcome.what;
  ASSERT_EQ(simulation.report().contact_events.size(), 1u);
  const ContactEvent& event = simulation.report().contact_events[0];
  EXPECT_EQ(event.change, ContactChange::Slack);
  EXPECT_EQ(event.time, simulation.passages()[0].time);
  EXPECT_EQ(event.equations, std::vector<std::size_t>{1});
  EXPECT_NEAR(simulation.positions()[8] - simulation.positions()[5], -1.0 + 0.5 * 3.0 * 0.0625, 1e-9);
}

TEST(OneSidedMotion, GapsThatNothingHoldsAreRefused) {
  const scene::Scene scene = falling_ropes();
  MotionOptions options{.method = Method::Rk4, .step = 0.01};
  options.stabilisation = Stabilisation::None;
  try {
    const Simulation simulation(scene.system, options, {.threads = 1});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.where(), "/motion/stabilisation");
  }
}

/// A net of ropes falls and is caught at two corners: ropes that become taut make others slack, ever faster, and events
/// follow one another within rounding. It is complementary at every output.
TEST(OneSidedMotion, ANetIsCaughtWithoutEnd) {
  constexpr int side = 8;
  constexpr double spacing = 0.1;
  System system;
  Ropes ropes{.name = "ropes", .length = 1.02 * spacing};
  for (int i = 0; i < side * side; ++i) {
    system.add_point({{spacing * (i % side), spacing * (i / side), 0.0}});
    if (i % side > 0) ropes.paths.push_back({i - 1, i});
    if (i >= side) ropes.paths.push_back({i - side, i});
  }
  system.supports = {{.points = {0, side * side - 1}}};
  system.constraints = {ropes};
  system.add_gravity({0.0, 0.0, -9.81});
  Simulation simulation(system, {.rtol = 1e-8, .atol = 1e-9}, {.threads = 1});
  for (int k = 1; k <= 16; ++k) {
    const Outcome outcome = simulation.advance_to(0.015 * k);
    ASSERT_TRUE(outcome.ok()) << outcome.what;
    expect_gaps(simulation, spacing);
  }
  EXPECT_GT(simulation.report().contact_events.size(), 50u);
}

/// A ball from below lifts a bob that hangs at rest: its rope is slack from the impact on, without an impulse.
TEST(OneSidedMotion, ARopeThatAnImpactOpensIsListed) {
  scene::Scene scene = scene_of(R"("positions": [[0, 0, 0], [0, 0, -1], [0, 0, -3]],
         "velocities": [[0, 0, 0], [0, 0, 0], [0, 0, 9]])",
                                R"("supports": [{"points": [0]}],
         "constraints": [{"name": "rope", "kind": "rope", "paths": [[0, 1]]},
                         {"name": "balls", "kind": "rod", "pairs": [[1, 2]], "length": 0.5, "side": "at_least",
                          "restitution": 1}])");
  Simulation simulation(scene.system, {}, {.threads = 1});
  const Outcome outcome = simulation.advance_to(0.25);
  ASSERT_TRUE(outcome.ok()) << outcome.what;
  const std::vector<ContactEvent>& events = simulation.report().contact_events;
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].change, ContactChange::Touch);
  EXPECT_EQ(events[1].change, ContactChange::Slack);
  EXPECT_EQ(events[1].time, events[0].time);
  EXPECT_EQ(events[1].equations, std::vector<std::size_t>{0});
}

/// The first one of three balls in a row hits the second, which then hits the third, that was on its way: two impacts
/// at one instant.
TEST(OneSidedMotion, MoreImpactsAtOneInstantThanAllowedAreTold) {
  const scene::Scene scene =
      scene_of(R"("positions": [[0, 0, 0], [1, 0, 0], [2, 0, 0]], "velocities": [[2, 0, 0], [0, 0, 0], [0.1, 0, 0]])",
               R"("constraints": [{"kind": "rod", "pairs": [[0, 1], [1, 2]], "side": "at_least", "restitution": 1}])");
  for (const int allowed : {1, 2}) {
    Simulation simulation(scene.system, {}, {.threads = 1, .contact = {.max_at_one_instant = allowed}});
    EXPECT_EQ(simulation.outcome().ok(), allowed == 2) << simulation.outcome().what;
    if (allowed == 2)
      EXPECT_NEAR(simulation.velocities()[6], 2.0, 1e-12);
    else
      EXPECT_EQ(
          simulation.outcome().what,
          "more impacts follow one another at t = 0 than solver.contact.max_at_one_instant allows, 1, the last one at "
          "rod0[1]");
  }
}

TEST(OneSidedMotion, ARunEndsWhereItHasAsManyEventsAsAllowed) {
  const scene::Scene scene =
      scene_of(R"("positions": [[0, 0, 1]])",
               R"("constraints": [{"name": "floor", "kind": "plane", "points": [0], "normal": [0, 0, 1],
                  "side": "at_least", "restitution": 0.9}], "solver": {"contact": {"max_events": 5}})");
  EXPECT_EQ(scene.solver.contact.max_events, 5);
  EXPECT_EQ(scene.solver.contact.max_at_one_instant, 100);
  Simulation whole(scene.system, {}, scene.solver), resumed(scene.system, {}, scene.solver);
  ASSERT_TRUE(resumed.advance_to(1.5).ok());
  resumed.restore(resumed.save());
  for (Simulation* const simulation : {&whole, &resumed}) {
    const Outcome outcome = simulation->advance_to(10.0);
    EXPECT_EQ(outcome.status, Status::NotConverged);
    EXPECT_EQ(outcome.what.find("the contact events are as many as solver.contact.max_events allows, 5, at t = "), 0u)
        << outcome.what;
    EXPECT_EQ(simulation->report().contact_events.size(), 5u);
    EXPECT_EQ(simulation->report().contact_events.back().time, simulation->time());
  }
  EXPECT_FALSE(whole.advance_to(20.0).ok());
  for (const ContactOptions& wrong : {ContactOptions{.max_at_one_instant = 0}, ContactOptions{.max_events = -1}})
    EXPECT_THROW(Simulation(scene.system, {}, {.contact = wrong}), InputError);
}

/// A projection onto a floor would leave the point beyond its rope.
TEST(OneSidedMotion, AStartThatProjectsObeysAllSides) {
  const scene::Scene scene = scene_of(R"("positions": [[0, 0, 0], [0, 0, -1.05]])",
                                      R"("supports": [{"points": [0]}],
         "constraints": [{"kind": "plane", "points": [1], "normal": [1, 0, 0], "offset": 0.5, "side": "at_least"},
                         {"kind": "rope", "paths": [[0, 1]], "length": 1.1}])");
  Simulation simulation(scene.system, {.start = StartMode::Project}, {.threads = 1});
  ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
  EXPECT_GT(simulation.positions()[3], 0.5 - 1e-12);
  EXPECT_LT(std::hypot(simulation.positions()[3], simulation.positions()[5]), 1.1 + 1e-12);
  EXPECT_TRUE(simulation.advance_to(0.5).ok());
}

/// A ball is thrown so that it just touches a ceiling, also after a resume on the way.
TEST(OneSidedMotion, AGrazedCeilingIsFoundInsideAStep) {
  for (const double above : {1e-6, -1e-6}) {
    const std::string height = std::to_string(0.5 * 4.0 / 9.81 + above);
    const scene::Scene scene =
        scene_of(R"("positions": [[0, 0, 0]], "velocities": [[1, 0, 2]])",
                 R"("constraints": [{"kind": "plane", "points": [0], "normal": [0, 0, 1], "offset": )" + height +
                     R"(, "side": "at_most"}])");
    Simulation whole(scene.system, {}, {.threads = 1}), half(scene.system, {}, {.threads = 1});
    ASSERT_TRUE(half.advance_to(0.1).ok());
    half.restore(half.save());
    for (Simulation* simulation : {&whole, &half}) {
      ASSERT_TRUE(simulation->advance_to(0.6).ok());
      EXPECT_EQ(simulation->report().contact_events.size(), above > 0.0 ? 0u : 1u) << above;
    }
  }
}

}  // namespace
}  // namespace tanor
