/// The tests check to which system the bytes of a simulation belong, and what happens to incomplete ones.

#include <cmath>

#include <gtest/gtest.h>
#include <tanor/tanor.hpp>

#include "scenes.hpp"
#include "simulation/saved_state.hpp"

namespace tanor {
using namespace detail;
namespace {

using Bytes = std::vector<std::byte>;

System make_pendulum(double length = 0.1) {
  return scenes::make_pendulum({length, 0.0, 0.0}, 0.5);
}

const MotionOptions options{.method = Method::Dop853, .rtol = 1e-10};

std::string error_of(const System& system, const Bytes& bytes) {
  Simulation simulation(system, options);
  try {
    simulation.restore(bytes);
  } catch (const InputError& error) {
    EXPECT_EQ(error.where(), "/snapshot");
    EXPECT_EQ(simulation.time(), 0.0) << "bad bytes change nothing";
    return error.what();
  }
  return "no error";
}

Bytes make_bytes() {
  Simulation simulation(make_pendulum(), options);
  EXPECT_TRUE(simulation.advance_to(0.3).ok());
  return simulation.save();
}

TEST(SavedState, GoesOnInAnEqualSystemBitByBit) {
  Simulation whole(make_pendulum(), options), second(make_pendulum(), options);
  ASSERT_TRUE(whole.advance_to(0.3).ok());
  const Bytes bytes = whole.save();
  EXPECT_EQ(whole.save(), bytes) << "saving changes nothing that is saved";

  second.restore(bytes);
  ASSERT_TRUE(whole.advance_to(0.7).ok());
  ASSERT_TRUE(second.advance_to(0.7).ok());

  EXPECT_EQ(whole.solution().positions, second.solution().positions);
  EXPECT_EQ(whole.solution().multipliers, second.solution().multipliers);
}

/// Makes a snapshot with a different number in every place.
Snapshot make_snapshot() {
  Snapshot snapshot;
  snapshot.time = 0.1 + 0.2;
  snapshot.positions = {0.1, 0.2, 0.3, -0.0, 1e-300, 6.0};
  snapshot.velocities = {1.0, 2.0, 3.0, 4.0, 5.0, 6.0};
  snapshot.next_step = 1.0 / 3.0;
  snapshot.last_error = 2.0 / 3.0;
  snapshot.advance_begin = 0.1;
  snapshot.advance_end = 0.7;
  snapshot.report.method = Method::Rk4;
  snapshot.report.steps = 42;
  snapshot.report.events = 5;
  snapshot.report.last_event = 0.29;
  snapshot.discrete_state = {-1, 0, 1};
  snapshot.event_slopes = {-1.0 / 7.0, 1e-300};
  snapshot.memory = {4.0, 1.0 / 3.0};
  snapshot.singular_memory = {1.0, 0.25, HUGE_VAL};
  snapshot.state_before = {0.0, 0.5};
  snapshot.report.accuracy_warning = "steps may be too long";
  snapshot.report.rank_changes = {.start = 8, .now = 9, .first = {{0.1, 7}, {1.0 / 3.0, 9}}, .count = 102};
  snapshot.report.singular_passages = {.first = {{0.1 + 0.2, 1e-17}}, .count = 101};
  snapshot.report.energy = {.start = -1.5,
                            .now = -1.25,
                            .work_of_supports = 0.1,
                            .work_of_forces = 0.2,
                            .work_of_potentials = 0.4,
                            .work_of_friction = -0.3,
                            .scale = 3.0};
  snapshot.report.violation.velocity = std::nan("");
  snapshot.report.last_violation = {.position = 1e-13, .velocity = 1.0 / 7.0, .acceleration = 3e-9};
  snapshot.report.last_reciprocal_condition = 0.3;
  snapshot.report.counters = {.evaluations = 1,
                              .factorizations = 2,
                              .solves = 3,
                              .iterations = 4,
                              .friction_solves = 5,
                              .friction_iterations = 6};
  snapshot.report.times = {.evaluate = 0.1, .assemble = 0.2, .factor = 0.3, .solve = 0.4, .friction = 0.5};
  snapshot.report.friction = {.solves = 8,
                              .iterations_mean = 2.5,
                              .iterations_max = 9,
                              .contraction_max = 0.75,
                              .error_bound = 1e-9,
                              .uniqueness = Uniqueness::Several,
                              .method_used = FrictionMethod::Newton,
                              .residual_max = 1e-13};
  snapshot.extremes = {{0.25, 0.1 + 0.2, "links[3]"}, {std::nan(""), 0.5, ""}};
  snapshot.passages = {{.event = 2,
                        .time = 1.0 / 3.0,
                        .rises = true,
                        .name = "worn",
                        .member = "a\nb",
                        .energy_lost = 0.7,
                        .rest = "point 4 is without constraints",
                        .action = EventAction::Break}};
  snapshot.truths = {{.is_true = true, .is_given_up = true, .last_passage = 1.0 / 7.0, .looks = 5.0}, {}};
  return snapshot;
}

TEST(SavedState, ExtremesAndPassagesReadBack) {
  const Snapshot read = unpack(pack(make_snapshot(), 7), 7);

  ASSERT_EQ(read.extremes.size(), 2u);
  EXPECT_EQ(read.extremes[0].value, 0.25);
  EXPECT_EQ(read.extremes[0].time, 0.1 + 0.2);
  EXPECT_EQ(read.extremes[0].member, "links[3]");
  EXPECT_TRUE(std::isnan(read.extremes[1].value));
  EXPECT_EQ(read.extremes[1].time, 0.5);
  ASSERT_EQ(read.passages.size(), 1u);
  const Passage& passage = read.passages[0];
  EXPECT_EQ(passage.event, 2u);
  EXPECT_EQ(passage.time, 1.0 / 3.0);
  EXPECT_TRUE(passage.rises);
  EXPECT_EQ(passage.name, "worn");
  EXPECT_EQ(passage.member, "a\nb");
  EXPECT_EQ(passage.energy_lost, 0.7);
  EXPECT_EQ(passage.rest, "point 4 is without constraints");
  EXPECT_EQ(passage.action, EventAction::Break);
  ASSERT_EQ(read.truths.size(), 2u);
  EXPECT_TRUE(read.truths[0].is_true);
  EXPECT_TRUE(read.truths[0].is_given_up);
  EXPECT_EQ(read.truths[0].last_passage, 1.0 / 7.0);
  EXPECT_EQ(read.truths[0].looks, 5.0);
  EXPECT_FALSE(read.truths[1].is_true);
}

TEST(SavedState, EveryNumberReadsBackBitByBit) {
  const Snapshot written = make_snapshot();

  const Snapshot read = unpack(pack(written, 7), 7);

  EXPECT_EQ(read.time, 0.1 + 0.2);
  EXPECT_EQ(read.positions, written.positions);
  EXPECT_EQ(read.velocities, written.velocities);
  EXPECT_EQ(read.next_step, 1.0 / 3.0);
  EXPECT_EQ(read.last_error, 2.0 / 3.0);
  EXPECT_EQ(read.advance_begin, 0.1);
  EXPECT_EQ(read.advance_end, 0.7);
  EXPECT_EQ(read.report.method, Method::Rk4);
  EXPECT_EQ(read.report.steps, 42u);
  EXPECT_EQ(read.report.events, 5u);
  EXPECT_EQ(read.report.last_event, 0.29);
  EXPECT_EQ(read.discrete_state, written.discrete_state);
  EXPECT_EQ(read.event_slopes, written.event_slopes);
  EXPECT_EQ(read.memory, written.memory);
  EXPECT_EQ(read.singular_memory, written.singular_memory);
  EXPECT_EQ(read.state_before, written.state_before);
  EXPECT_EQ(read.report.accuracy_warning, written.report.accuracy_warning);
  EXPECT_EQ(read.report.rank_changes.start, 8u);
  EXPECT_EQ(read.report.rank_changes.now, 9u);
  EXPECT_EQ(read.report.rank_changes.count, 102u);
  ASSERT_EQ(read.report.rank_changes.first.size(), 2u);
  EXPECT_EQ(read.report.rank_changes.first[1].time, 1.0 / 3.0);
  EXPECT_EQ(read.report.rank_changes.first[1].rank, 9u);
  EXPECT_EQ(read.report.singular_passages.count, 101u);
  ASSERT_EQ(read.report.singular_passages.first.size(), 1u);
  EXPECT_EQ(read.report.singular_passages.first[0].time, 0.1 + 0.2);
  EXPECT_EQ(read.report.singular_passages.first[0].reciprocal_condition, 1e-17);
  EXPECT_EQ(read.report.energy.work_of_forces, 0.2);
  EXPECT_EQ(read.report.energy.work_of_potentials, 0.4);
  EXPECT_TRUE(std::isnan(read.report.violation.velocity));
  EXPECT_EQ(read.report.last_violation.position, written.report.last_violation.position);
  EXPECT_EQ(read.report.last_violation.velocity, written.report.last_violation.velocity);
  EXPECT_EQ(read.report.last_violation.acceleration, written.report.last_violation.acceleration);
  EXPECT_EQ(read.report.last_reciprocal_condition, written.report.last_reciprocal_condition);
  EXPECT_EQ(read.report.counters.solves, 3u);
  EXPECT_EQ(read.report.times.solve, 0.4);
  EXPECT_EQ(read.report.times.friction, 0.5);
  EXPECT_EQ(read.report.energy.work_of_friction, -0.3);
  EXPECT_EQ(read.report.counters.friction_solves, 5u);
  EXPECT_EQ(read.report.counters.friction_iterations, 6u);
  const FrictionSummary& friction = read.report.friction;
  EXPECT_EQ(friction.solves, 8u);
  EXPECT_EQ(friction.iterations_mean, 2.5);
  EXPECT_EQ(friction.iterations_max, 9);
  EXPECT_EQ(friction.contraction_max, 0.75);
  EXPECT_EQ(friction.error_bound, 1e-9);
  EXPECT_EQ(friction.uniqueness, Uniqueness::Several);
  EXPECT_EQ(friction.method_used, FrictionMethod::Newton);
  EXPECT_EQ(friction.residual_max, 1e-13);
}

TEST(SavedState, ValuesOfNoEnumerationAreRefused) {
  Snapshot snapshot = make_snapshot();
  snapshot.report.friction.uniqueness = static_cast<Uniqueness>(9);
  EXPECT_THROW((void)unpack(pack(snapshot, 7), 7), InputError);
  snapshot = make_snapshot();
  snapshot.report.method = static_cast<Method>(77);
  EXPECT_THROW((void)unpack(pack(snapshot, 7), 7), InputError);
}

TEST(SavedState, ForeignBytesAreRefused) {
  Bytes bytes = make_bytes();
  EXPECT_EQ(error_of(make_pendulum(), {}), "these are no bytes that a Simulation saved");
  EXPECT_EQ(error_of(make_pendulum(), Bytes(1000, std::byte{7})), "these are no bytes that a Simulation saved");
  bytes[8] = std::byte{200};
  EXPECT_EQ(error_of(make_pendulum(), bytes), "its format is 200, this version of tanor reads 15");
}

TEST(SavedState, BytesOfAnotherSystemAreRefused) {
  const Bytes bytes = make_bytes();
  EXPECT_EQ(error_of(make_pendulum(), bytes), "no error");
  EXPECT_EQ(error_of(make_pendulum(0.2), bytes), "it belongs to another system");
  System heavier = make_pendulum();
  heavier.masses[1] = 0.6;
  EXPECT_EQ(error_of(heavier, bytes), "it belongs to another system");
  System sprung = make_pendulum();
  sprung.forces.push_back(Springs{.pairs = {{0, 1}}, .stiffness = 1.0});
  EXPECT_EQ(error_of(sprung, bytes), "it belongs to another system");
}

TEST(SavedState, BytesThatAreCutOffOrFlippedAreRefused) {
  const Bytes good = make_bytes();
  for (std::size_t size = 0; size < good.size(); size += 13)
    EXPECT_NE(error_of(make_pendulum(), Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size))),
              "no error")
        << size;
  for (std::size_t place = 0; place < good.size(); place += 7) {
    Bytes bad = good;
    bad[place] ^= static_cast<std::byte>(1 << (place % 8));
    EXPECT_NE(error_of(make_pendulum(), bad), "no error") << place;
  }
  Bytes longer = good;
  longer.push_back(std::byte{0});
  EXPECT_EQ(error_of(make_pendulum(), longer), "it is damaged or cut off: its checksum is another one");
}

// ---- what a Simulation shows -------------------------------------------------------------------------------------

TEST(Simulation, SystemIsTheOneThatWasGivenThoughPrestressHoldsPoints) {
  System taut;
  Rods rods{.name = "rods"};
  for (Index k = 0; k <= 5; ++k) {
    (void)taut.add_point({.position = {0.25 * k, 0.0, 0.0}});
    if (k > 0) rods.pairs.push_back({k - 1, k});
  }
  taut.supports = {{"", {0, 5}, {}}};
  taut.constraints = {rods};
  taut.add_gravity({0.0, 0.0, -9.81});
  Simulation simulation(taut);

  EXPECT_EQ(simulation.plan().prestress_rigid_points.size(), 4u);
  EXPECT_EQ(simulation.system().supports.size(), 1u);
  EXPECT_EQ(simulation.system().supports[0].points.size(), 2u);
  ASSERT_TRUE(simulation.advance_to(0.1).ok());
  Simulation again(simulation.system());
  EXPECT_NO_THROW(again.restore(simulation.save()));
}

TEST(Simulation, ASolutionInsideAnObserverIsThatOfTheStep) {
  System system = make_pendulum();
  Simulation simulation(system, options);
  Dynamics dynamics(system);
  int looks = 0;
  const Outcome outcome = simulation.advance_to(0.2, [&](const MotionReport& report) {
    const Solution now = simulation.solution();
    EXPECT_TRUE(now.outcome.ok()) << now.outcome.what;
    EXPECT_EQ(now.time, report.time);
    const Solution expected = dynamics.solution(now.state());
    for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(now.accelerations[i], expected.accelerations[i], 1e-11);
    EXPECT_NEAR(now.multipliers[0], expected.multipliers[0], 1e-11);
    EXPECT_LE(now.violation(), 1e-13);
    ++looks;
    return true;
  });
  EXPECT_TRUE(outcome.ok()) << outcome.what;
  EXPECT_GT(looks, 2);
}

}  // namespace
}  // namespace tanor
