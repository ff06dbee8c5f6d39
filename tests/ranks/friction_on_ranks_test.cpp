/// Friction on one rank alone: contacts stick and slide there, and other ranks take the same steps.

#include <cmath>

#include <gtest/gtest.h>
#include <tanor/motion.hpp>

#include "ranks/on_ranks.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

/// Makes a bead on a rough floor that a growing pull sets sliding at t = 0.39 s, and a chain of rods that swings.
System make_bead_and_chain() {
  System system = scenes::make_chain(4);
  const Index bead = scenes::add_point({0, 0, -5}, &system);
  system.masses.back() = 0.1;
  system.constraints.push_back(Planes{.name = "floor", .points = {bead}, .normal = {0, 0, 1}, .offset = -5.0});
  system.friction = {Coulomb{.name = "rust", .at = {"floor"}, .coefficient = 0.2}};
  system.forces.push_back(
      ConstantForce{.name = "pull", .points = {bead}, .force = {ScalarFunction::formula("0.5*t"), 0.0, 0.0}});
  return system;
}

/// The bead is that of one rank, the chain that of the other one.
std::vector<int> part_the_bead(const System& system, int rank_of_bead) {
  std::vector<int> owner(system.num_points(), 1 - rank_of_bead);
  owner.back() = rank_of_bead;
  return owner;
}

TEST(FrictionOnRanks, OneRankAloneMayHaveIt) {
  const System system = make_bead_and_chain();
  for (const MotionOptions& options :
       {options_of(Method::Auto), options_of(Method::Dop853), options_of(Method::Rattle, 1e-3)}) {
    const Ending one = run_whole(system, options, 0.6);
    ASSERT_TRUE(one.outcome.ok()) << one.outcome.what;
    for (const int rank_of_bead : {0, 1}) {
      const Ending two = run_on_ranks(system, part_the_bead(system, rank_of_bead), 2, options, 0.6);
      ASSERT_TRUE(two.outcome.ok()) << two.outcome.what;
      EXPECT_EQ(two.report.method, one.report.method);
      EXPECT_EQ(two.report.steps, one.report.steps) << name_of(options.method);
      EXPECT_EQ(two.report.rejected, one.report.rejected);
      EXPECT_EQ(two.report.events, one.report.events);
      EXPECT_LE(difference(two.positions, one.positions), 1e-9);
      EXPECT_LE(difference(two.velocities, one.velocities), 1e-9);
      EXPECT_NEAR(two.report.energy.work_of_friction, one.report.energy.work_of_friction,
                  1e-9 * one.report.energy.scale);
    }
  }
}

/// A motion that is restored from its points alone begins anew on all ranks, and an observer asks for friction there.
TEST(FrictionOnRanks, SavedMotionGoesOnAndTellsItsFriction) {
  const System system = make_bead_and_chain();
  const MotionOptions options = options_of(Method::Dop853);
  const Ending straight = run_whole(system, options, 0.6);
  ThreadWorld(2).run([&](Ranks& ranks) {
    const RankSystem own = take_part(system, part_the_bead(system, 1), ranks);
    Simulation first(own.system, own.part, options, one_thread()), second(own.system, own.part, options, one_thread());
    ASSERT_TRUE(first.advance_to(0.3).ok());
    second.restore_progress(first.save_progress(), first.positions(), first.velocities());
    EXPECT_EQ(second.time(), 0.3);
    double largest = 0.0;
    const Outcome outcome = second.advance_to(0.6, [&](const MotionReport&) {
      for (const double each : second.friction_forces()) largest = std::max(largest, std::abs(each));
      return true;
    });
    ASSERT_TRUE(outcome.ok()) << outcome.what;
    EXPECT_NEAR(largest, ranks.rank() == 1 ? 0.2 * 0.1 * scenes::g : 0.0, 1e-12);
    for (std::size_t i = 0; i < own.num_owned; ++i)
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(second.positions()[3 * i + c], straight.positions[3 * static_cast<std::size_t>(own.points[i]) + c],
                    1e-8);
  });
}

/// The chain has no friction, but is cut.
TEST(FrictionOnRanks, KeepsAllIslandsWhole) {
  const System system = make_bead_and_chain();
  ThreadWorld(2).run([&](Ranks& ranks) {
    try {
      (void)take_part(system, deal(system, 2), ranks);
      ADD_FAILURE();
    } catch (const InputError& error) {
      EXPECT_EQ(error.where(), "/friction");
      EXPECT_NE(std::string(error.what()).find("all islands lie whole"), std::string::npos) << error.what();
    }
  });
}

}  // namespace
}  // namespace tanor
