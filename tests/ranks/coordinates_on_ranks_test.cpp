/// Mechanisms in coordinates on several ranks: each of them lies whole on one, and all ranks step in the same form.

#include <numeric>

#include <gtest/gtest.h>
#include <tanor/motion.hpp>

#include "ranks/on_ranks.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

/// The points of scenes::make_coordinates are the anchor, a chain of three, a body of four, two pairs that springs
/// join, one on a ring and one of a formula.
std::vector<int> give_mechanisms(int num_ranks) {
  if (num_ranks == 2) return {0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 1, 1, 1, 1};
  return {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 1, 1, 2, 1};
}

/// Starts from the nearest velocities that the coordinates allow.
MotionOptions projecting(Method method, double step = 0.0) {
  MotionOptions options = options_of(method, step);
  options.start = StartMode::Project;
  return options;
}

void expect_same(const Ending& many, const Ending& one, double allowed) {
  expect_same_ending(many, one, allowed);
  EXPECT_LE(difference(many.reactions, one.reactions), 10.0 * allowed);
}

TEST(CoordinatesOnRanks, MoveAsOnOneRank) {
  const System system = scenes::make_coordinates();
  for (const MotionOptions& options :
       {projecting(Method::Auto), projecting(Method::Dopri5), projecting(Method::Rk4, 2e-3)}) {
    const Ending one = run_whole(system, options, 0.3);
    ASSERT_TRUE(one.outcome.ok()) << one.outcome.what;
    for (const int num_ranks : {2, 3})
      expect_same(run_on_ranks(system, give_mechanisms(num_ranks), num_ranks, options, 0.3), one, 1e-10);
  }
}

/// Makes a pendulum of two rods, a tetrahedron of six, and a free point: constraints and coordinates say the same.
System make_twofold() {
  System system = scenes::make_chain(2);
  const double a = scenes::spacing;
  RigidBody body{"body", {}};
  for (const Vector3& place : {Vector3{1, 0, 0}, Vector3{1 + a, 0, 0}, Vector3{1, a, 0}, Vector3{1, 0, a}})
    body.points.push_back(scenes::add_point(place, &system));
  Rods edges{"edges", {}, {}, {}};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < i; ++j) edges.pairs.push_back({body.points[i], body.points[j]});
  system.constraints.push_back(edges);
  const Index free = scenes::add_point({2, 0, 0}, &system);
  system.coordinates = {ChainAngles{"chain", {1, 2}, 0, {}, {}}, body, FreeCoordinates{"free", {free}}};
  system.velocities.assign(3 * system.num_points(), 0.0);
  system.velocities[3 * 3 + 1] = 0.2;  // it makes the body's corner and so the body turn
  return system;
}

/// On one rank the flops of the whole decide on the form; those of a part alone might ask for the other one.
TEST(CoordinatesOnRanks, AllRanksStepInTheFormOfOneRank) {
  const System system = make_twofold();
  std::vector<int> owner(system.num_points(), 1);
  owner[1] = owner[2] = 0;
  for (const auto& [owners, form] :
       {std::pair(owner, Form::Auto), std::pair(part_the_last(system, 1), Form::Auto),
        std::pair(part_the_last(system, 1), Form::Normal), std::pair(owner, Form::Normal),
        std::pair(owner, Form::Tangent), std::pair(part_the_last(system, 1), Form::Both)}) {
    SolverOptions solver = one_thread();
    solver.form = form;
    const MotionOptions options = projecting(Method::Dop853);
    Simulation whole(system, options, solver);
    ASSERT_TRUE(whole.advance_to(0.1).ok());
    ThreadWorld(2).run([&](Ranks& ranks) {
      const RankSystem own = take_part(system, owners, ranks);
      Simulation simulation(own.system, own.part, options, solver);
      ASSERT_TRUE(simulation.advance_to(0.1).ok()) << simulation.outcome().what;
      EXPECT_EQ(simulation.plan().form, whole.plan().form);
      EXPECT_EQ(simulation.report().steps, whole.report().steps);
      for (std::size_t i = 0; i < own.num_owned; ++i)
        for (std::size_t c = 0; c < 3; ++c)
          EXPECT_NEAR(simulation.positions()[3 * i + c],
                      whole.positions()[3 * static_cast<std::size_t>(own.points[i]) + c], 1e-10);
    });
  }
}

/// Methods that project step in the normal form, also on a rank that has no constraint.
TEST(CoordinatesOnRanks, MethodsThatProjectStepByConstraints) {
  const System system = make_twofold();
  for (MotionOptions options : {projecting(Method::Rattle, 1e-3), projecting(Method::Radau5)}) {
    options.rtol = 1e-7;
    const Ending one = run_whole(system, options, 0.05);
    const Ending two = run_on_ranks(system, part_the_last(system, 1), 2, options, 0.05);
    expect_same(two, one, 1e-9);
  }
}

TEST(CoordinatesOnRanks, RanksThatAskForDifferentFormsAreRefused) {
  const System system = make_twofold();
  ThreadWorld(2).run([&](Ranks& ranks) {
    const RankSystem own = take_part(system, part_the_last(system, 1), ranks);
    SolverOptions solver = one_thread();
    solver.form = ranks.rank() == 0 ? Form::Normal : Form::Tangent;
    EXPECT_THROW(Simulation(own.system, own.part, projecting(Method::Dop853), solver), InputError);
  });
}

TEST(CoordinatesOnRanks, CompletenessIsCheckedOnAllRanks) {
  System system = make_twofold();
  std::get<Rods>(system.constraints.back()).pairs.pop_back();  // the body could bend, its coordinates do not
  EXPECT_THROW(run_whole(system, projecting(Method::Dop853), 0.0), InputError);
  std::vector<int> owner(system.num_points(), 1);
  owner[1] = owner[2] = 0;
  int refusals = 0;
  ThreadWorld(2).run([&](Ranks& ranks) {
    const RankSystem own = take_part(system, owner, ranks);
    try {
      Simulation simulation(own.system, own.part, projecting(Method::Dop853), one_thread());
    } catch (const InputError&) {
      if (ranks.rank() == 0) ++refusals;  // the pendulum is as it should be
    }
  });
  EXPECT_EQ(refusals, 1);
}

TEST(CoordinatesOnRanks, WhatTheyTieTogetherStaysWhole) {
  const System system = scenes::make_coordinates();
  const auto refusal = [&](const System& whole, std::vector<int> owner) -> std::string {
    try {
      ThreadWorld(2).run([&](Ranks& ranks) { (void)take_part(whole, owner, ranks); });
    } catch (const InputError& error) {
      return error.where() + ": " + error.what();
    }
    return {};
  };
  std::vector<int> owner = give_mechanisms(2);
  owner[2] = 1;
  EXPECT_EQ(refusal(system, owner), "/coordinates/0: chain: its points lie on several ranks");
  owner = give_mechanisms(2);
  owner[5] = 0;
  EXPECT_EQ(refusal(system, owner), "/coordinates/1: body: its points lie on several ranks");
  owner = give_mechanisms(2);
  owner[9] = 1;  // at one end of a spring
  EXPECT_EQ(refusal(system, owner).substr(0, 13), "/coordinates:");
  System pairs = system;
  std::get<UserCoordinates>(pairs.coordinates.back()) = UserCoordinates{
      "formula",
      {{12, 13}},
      formula_coordinates(std::vector<std::string>{"a"}, std::vector<std::string>{"6", "a", "0", "7", "a", "0"}),
      {0.0},
      {1.0}};
  std::erase_if(pairs.coordinates,
                [](const Coordinates& each) { return std::holds_alternative<CircleCoordinates>(each); });
  owner = give_mechanisms(2);
  owner[13] = 0;
  EXPECT_EQ(refusal(pairs, owner), "/coordinates/6: formula: its points lie on several ranks");
}

/// A motion that two ranks saved goes on on one and on three.
TEST(CoordinatesOnRanks, SavedMotionGoesOnOnAnyNumberOfRanks) {
  const System system = scenes::make_coordinates();
  const MotionOptions options = projecting(Method::Dop853);
  std::vector<std::byte> progress;
  ThreadWorld(2).run([&](Ranks& ranks) {
    const RankSystem own = take_part(system, give_mechanisms(2), ranks);
    Simulation simulation(own.system, own.part, options, one_thread());
    ASSERT_TRUE(simulation.advance_to(0.1).ok());
    if (ranks.rank() == 0) progress = simulation.save_progress();
  });
  const Ending half = run_on_ranks(system, give_mechanisms(2), 2, options, 0.1),
               straight = run_whole(system, options, 0.2);
  ThreadWorld(3).run([&](Ranks& ranks) {
    const RankSystem own = take_part(system, give_mechanisms(3), ranks);
    Simulation simulation(own.system, own.part, options, one_thread());
    const auto pick = [&](const std::vector<double>& from) {
      std::vector<double> result;
      for (const Index point : own.points)
        result.insert(result.end(), from.begin() + 3 * point, from.begin() + 3 * point + 3);
      return result;
    };
    simulation.restore_progress(progress, pick(half.positions), pick(half.velocities));
    ASSERT_TRUE(simulation.advance_to(0.2).ok());
    const std::vector<double> end(simulation.positions().begin(), simulation.positions().end());
    EXPECT_LE(difference(end, pick(straight.positions)), 1e-8);
  });
}

}  // namespace
}  // namespace tanor
