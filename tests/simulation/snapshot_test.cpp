#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "motion/saved.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

System make_system() {
  return scenes::make_shaken_chain_in_air(0.0);
}

void expect_same_bits(std::span<const double> a, std::span<const double> b) {
  EXPECT_EQ(std::vector(a.begin(), a.end()), std::vector(b.begin(), b.end()));
}

void expect_same_bits(const Simulation& a, const Simulation& b) {
  EXPECT_EQ(a.time(), b.time());
  expect_same_bits(a.positions(), b.positions());
  expect_same_bits(a.velocities(), b.velocities());
  expect_same_bits(a.accelerations(), b.accelerations());
  expect_same_bits(a.multipliers(), b.multipliers());
  expect_same_bits(a.support_forces(), b.support_forces());
}

void expect_same_history(const MotionReport& a, const MotionReport& b) {
  EXPECT_EQ(a.steps, b.steps);
  EXPECT_EQ(a.rejected, b.rejected);
  EXPECT_EQ(a.last_step, b.last_step);
  EXPECT_EQ(a.violation.position, b.violation.position);
  EXPECT_EQ(a.violation.velocity, b.violation.velocity);
  EXPECT_EQ(a.violation.acceleration, b.violation.acceleration);
  EXPECT_EQ(a.nearest_to_singular.reciprocal_condition, b.nearest_to_singular.reciprocal_condition);
  EXPECT_EQ(a.rank_changes.start, b.rank_changes.start);
  EXPECT_EQ(a.rank_changes.now, b.rank_changes.now);
  EXPECT_EQ(a.rank_changes.count, b.rank_changes.count);
  EXPECT_EQ(a.singular_passages.count, b.singular_passages.count);
  EXPECT_EQ(a.energy.start, b.energy.start);
  EXPECT_EQ(a.energy.now, b.energy.now);
  EXPECT_EQ(a.energy.scale, b.energy.scale);
  EXPECT_EQ(a.energy.work_of_supports, b.energy.work_of_supports);
  EXPECT_EQ(a.energy.work_of_forces, b.energy.work_of_forces);
}

class SnapshotTest : public testing::TestWithParam<MotionOptions> {};

TEST_P(SnapshotTest, ARestoredRunGoesOnBitByBit) {
  Simulation whole(make_system(), GetParam()), first(make_system(), GetParam()), second(make_system(), GetParam());

  ASSERT_TRUE(whole.advance_to(0.3).ok());
  ASSERT_TRUE(first.advance_to(0.3).ok());
  second.restore(first.save());

  ASSERT_TRUE(second.outcome().ok());
  expect_same_bits(second, whole);
  expect_same_history(second.report(), whole.report());
  ASSERT_TRUE(whole.advance_to(0.7).ok());
  ASSERT_TRUE(second.advance_to(0.7).ok());
  expect_same_bits(second, whole);
  expect_same_history(second.report(), whole.report());
}

/// Neighbour lists of pair forces are rebuilt at other times than in the whole run.
TEST_P(SnapshotTest, ARestoredMeltGoesOnBitByBit) {
  MotionOptions options = GetParam();
  options.start = StartMode::Project;
  Simulation whole(scenes::make_melt(8), options), first(scenes::make_melt(8), options),
      second(scenes::make_melt(8), options);

  ASSERT_TRUE(whole.advance_to(0.1).ok());
  ASSERT_TRUE(first.advance_to(0.1).ok());
  second.restore(first.save());
  ASSERT_TRUE(whole.advance_to(0.2).ok());
  ASSERT_TRUE(second.advance_to(0.2).ok());

  EXPECT_GT(largest_difference(whole.positions(), whole.system().positions), 0.02) << "lists were made anew";
  expect_same_bits(second, whole);
  expect_same_history(second.report(), whole.report());
}

/// The observer stops the second advance and takes the snapshot: the steps that were left are taken elsewhere.
TEST_P(SnapshotTest, ARunStoppedOnItsWayTakesTheStepsThatWereLeft) {
  Simulation whole(make_system(), GetParam()), first(make_system(), GetParam()), second(make_system(), GetParam());
  ASSERT_TRUE(whole.advance_to(0.1).ok());
  ASSERT_TRUE(first.advance_to(0.1).ok());
  std::vector<std::byte> saved;
  const auto stop_at_the_seventh_step = [&, left = 7](const MotionReport&) mutable {
    if (--left == 0) saved = first.save();
    return left > 0;
  };

  ASSERT_TRUE(first.advance_to(0.7, stop_at_the_seventh_step).ok());
  ASSERT_LT(first.time(), 0.7);
  const Snapshot inside = unpack(saved, fingerprint_of(first.system()));
  EXPECT_EQ(inside.time, first.time());
  expect_same_bits(inside.positions, first.positions());
  second.restore(saved);
  ASSERT_TRUE(whole.advance_to(0.7).ok());
  ASSERT_TRUE(first.advance_to(0.7).ok());
  ASSERT_TRUE(second.advance_to(0.7).ok());

  expect_same_bits(first, whole);
  expect_same_bits(second, whole);
  expect_same_history(second.report(), whole.report());
}

INSTANTIATE_TEST_SUITE_P(Methods, SnapshotTest,
                         testing::Values(MotionOptions{.method = Method::Rk4, .step = 0.003},
                                         MotionOptions{.method = Method::Dopri5, .rtol = 1e-8, .atol = 1e-10},
                                         MotionOptions{.method = Method::Dopri5,
                                                       .step = 0.1,
                                                       .rtol = 1e-6,
                                                       .atol = 1e-8,
                                                       .stabilisation = Stabilisation::None}),
                         [](const auto& instance) {
                           return std::string(name_of(instance.param.method)) +
                                  (instance.param.stabilisation == Stabilisation::None ? "_drifting" : "");
                         });

TEST(SnapshotOfRattleTest, RestoringTwiceGivesTheSameMotion) {
  Simulation simulation(make_system(), {.method = Method::Rattle, .step = 0.001});
  ASSERT_TRUE(simulation.advance_to(0.1).ok());
  const std::vector<std::byte> saved = simulation.save();

  simulation.restore(saved);
  ASSERT_TRUE(simulation.advance_to(0.2).ok());
  const std::vector<double> once(simulation.positions().begin(), simulation.positions().end());
  simulation.restore(saved);
  ASSERT_TRUE(simulation.advance_to(0.2).ok());

  expect_same_bits(simulation.positions(), once);
}

TEST(SnapshotReportTest, CountersAndTimesGoOn) {
  const MotionOptions options{.method = Method::Rk4, .step = 0.01};
  Simulation first(make_system(), options), second(make_system(), options);
  ASSERT_TRUE(first.advance_to(0.1).ok());
  Snapshot snapshot = open_saved(first);
  snapshot.report.times = {.evaluate = 100, .assemble = 200, .factor = 300, .solve = 400};

  restore(snapshot, &second);

  EXPECT_EQ(second.report().counters.factorizations, first.report().counters.factorizations);
  EXPECT_EQ(second.report().counters.evaluations, first.report().counters.evaluations);
  EXPECT_NEAR(second.report().times.evaluate, 100, 1);
  EXPECT_NEAR(second.report().times.solve, 400, 1);
}

/// The bead is half a rod too far out, and nothing is projected.
TEST(SnapshotStateTest, IsTakenAsItIs) {
  Simulation simulation(scenes::make_pendulum(), {.method = Method::Rk4, .step = 0.01});
  Snapshot snapshot = open_saved(simulation);
  snapshot.positions[3] = 0.15;
  snapshot.velocities[3] = 2.0;

  restore(snapshot, &simulation);

  EXPECT_EQ(simulation.positions()[3], 0.15);
  EXPECT_EQ(simulation.velocities()[3], 2.0);
  EXPECT_TRUE(simulation.outcome().ok());
}

/// Forces of the old position must not survive at the same time: rattle keeps them from step to step.
TEST(SnapshotStateTest, RestoringForgetsTheMotionBefore) {
  System system = scenes::make_pendulum();
  system.forces.push_back(Springs{"spring", {{0, 1}}, 5.0, 0.0, {}});
  const MotionOptions options{.method = Method::Rattle, .step = 0.01};
  Simulation moved(system, options), fresh(system, options);
  ASSERT_TRUE(moved.advance_to(0.1).ok());
  Snapshot snapshot = open_saved(moved);
  for (const std::size_t i : {3u, 4u, 5u}) snapshot.positions[i] = i == 4 ? 0.1 : 0.0;
  for (double& v : snapshot.velocities) v = 0.0;

  restore(snapshot, &moved);
  restore(snapshot, &fresh);
  ASSERT_TRUE(moved.advance_to(0.2).ok());
  ASSERT_TRUE(fresh.advance_to(0.2).ok());

  expect_same_bits(moved, fresh);
}

std::string error_of(const Snapshot& snapshot) {
  Simulation simulation(scenes::make_pendulum(), {.method = Method::Rk4, .step = 0.01});
  try {
    restore(snapshot, &simulation);
  } catch (const InputError& error) {
    EXPECT_EQ(simulation.time(), 0.0);
    EXPECT_EQ(simulation.positions()[3], 0.1) << "a bad snapshot changes nothing";
    return error.where() + ": " + error.what();
  }
  return "no error";
}

TEST(SnapshotErrorTest, NamesWhatDoesNotFit) {
  Simulation pendulum(scenes::make_pendulum(), {.method = Method::Rk4, .step = 0.01});
  const Snapshot good = open_saved(pendulum);
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const auto with = [&](const auto& change) {
    Snapshot snapshot = good;
    change(snapshot);
    return error_of(snapshot);
  };

  EXPECT_EQ(error_of(good), "no error");
  EXPECT_EQ(with([](Snapshot& s) { s.positions.pop_back(); }),
            "/snapshot/positions: holds 5 numbers, the system's points have 6");
  EXPECT_EQ(with([](Snapshot& s) { s.velocities.clear(); }),
            "/snapshot/velocities: holds 0 numbers, the system's points have 6");
  EXPECT_EQ(with([&](Snapshot& s) { s.positions[4] = nan; }), "/snapshot/positions: nan is not a finite number");
  EXPECT_EQ(with([&](Snapshot& s) { s.velocities[5] = infinity; }), "/snapshot/velocities: inf is not a finite number");
  EXPECT_EQ(with([&](Snapshot& s) { s.time = infinity; }), "/snapshot/time: inf is not a finite number");
  EXPECT_EQ(with([&](Snapshot& s) { s.report.energy.work_of_forces = nan; }),
            "/snapshot/report/energy: nan is not a finite number");
  EXPECT_EQ(with([&](Snapshot& s) { s.next_step = -1.0; }), "/snapshot/next_step: -1 is not 0 or a positive number");
  EXPECT_EQ(with([&](Snapshot& s) { s.last_error = nan; }), "/snapshot/last_error: nan is not 0 or a positive number");
}

}  // namespace
}  // namespace tanor
