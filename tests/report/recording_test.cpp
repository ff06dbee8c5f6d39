#include "report/recording.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "report/output_file.hpp"
#include "report/reading.hpp"
#include "rough_scenes.hpp"

namespace tanor::report {
namespace {

double length(const std::vector<float>& v) {
  return std::hypot(v[0], v[1], v[2]);
}

// With m = 2 and 30 degrees the rail pushes with m g cos(30), and friction holds back with mu times that.
TEST(RecordingTest, ReactionsOfAGuideHaveANormalAndATangentPart) {
  const System system = scenes::make_rough_incline(1.0, 0.2);
  Simulation simulation(system, {.method = Method::Dopri5});
  Recording recording(system, {});

  recording.take_frame(simulation, simulation.friction_forces());

  const std::vector<RecordedFrame> frames = recording.frames();
  ASSERT_EQ(frames.size(), 1u);
  const double normal = 2.0 * 9.81 * std::cos(std::numbers::pi / 6.0);
  EXPECT_NEAR(length(frames[0].normal_reactions), normal, 1e-5);
  EXPECT_NEAR(length(frames[0].tangent_reactions), 0.2 * normal, 1e-5);
  EXPECT_LT(frames[0].tangent_reactions[0], 0.0);
}

// A support carries the chain that hangs on it, and the rods' pull is no reaction of a guide.
TEST(RecordingTest, ASupportHoldsAChainThatHangs) {
  System system;
  system.positions = {0, 0, 0, 0, 0, -1};
  system.masses = {1.0, 3.0};
  system.supports = {Support{"", {0}}};
  system.constraints = {Rods{"", {{0, 1}}, 1.0, {}}};
  system.forces = {Gravity{"", {0, 0, -10}}};
  const Simulation simulation(system, {.method = Method::Rk4, .step = 0.01});
  Recording recording(system, {});

  recording.take_frame(simulation);

  const RecordedFrame frame = recording.frames().at(0);
  EXPECT_EQ(recording.held(), std::vector<std::int32_t>{0});
  EXPECT_FLOAT_EQ(frame.tensions.at(0), 30.0f);
  EXPECT_NEAR(frame.normal_reactions.at(2), 30.0, 1e-5);  // gravity pulls at no support
  EXPECT_TRUE(frame.tangent_reactions.empty());
}

// Seven output times make no film. Where there are many output times, or many points, no further instants are asked
// for.
TEST(RecordingTest, AsksForInstantsBetweenOutputTimesThatAreRare) {
  const System system = scenes::make_rough_incline(1.0, 0.2);
  const auto count_frames = [&](double every) {
    Recording recording(system, {}, {.duration = 0.6, .every = every});
    Simulation motion(system, {.method = Method::Rk4, .step = 1e-3});
    recording.take_frame(motion);
    const Outcome end = motion.advance_to(0.6, [&](const MotionReport& report) {
      if (recording.wants_frame(report.time)) recording.take_frame(system, motion.solution());
      return true;
    });
    EXPECT_TRUE(end.ok()) << end.what;
    return recording.frames().size();
  };

  EXPECT_NEAR(static_cast<double>(count_frames(0.0)), 150.0, 2.0);
  EXPECT_EQ(count_frames(0.004), 1u);
}

TEST(RecordingTest, AFrameBetweenOutputTimesHasTheForcesOfItsTime) {
  const System system = scenes::make_rough_incline(1.0, 0.2);
  Simulation motion(system, {.method = Method::Dopri5});
  Recording recording(system, {}, {.duration = 1.0});

  const Outcome end = motion.advance_to(1.0, [&](const MotionReport& report) {
    recording.take_frame(system, motion.solution(), motion.friction_forces());
    return report.time < 0.5;
  });

  EXPECT_TRUE(end.ok()) << end.what;
  const RecordedFrame frame = recording.frames().back();
  const double normal = 2.0 * 9.81 * std::cos(std::numbers::pi / 6.0);
  EXPECT_EQ(frame.time, motion.time());
  EXPECT_EQ(frame.positions[0], static_cast<float>(motion.positions()[0]));
  EXPECT_NEAR(length(frame.normal_reactions), normal, 1e-5);
  EXPECT_NEAR(length(frame.tangent_reactions), 0.2 * normal, 1e-5);
}

TEST(RecordingTest, AHistoryIsThinnedEvenlyAndKeepsItsEnd) {
  Recording recording(scenes::make_rough_incline(1.0, 0.2), {});

  MotionReport report;
  for (int k = 0; k <= 20'001; ++k) {
    report.time = k;
    recording.take_step(report);
  }

  const std::vector<RecordedStep> steps = recording.steps();
  EXPECT_LT(steps.size(), 4100u);
  EXPECT_GT(steps.size(), 1900u);
  EXPECT_EQ(steps.back().time, 20'001.0);
  for (std::size_t k = 2; k + 1 < steps.size(); ++k) EXPECT_EQ(steps[k].time - steps[k - 1].time, steps[1].time);
}

constexpr MotionOptions in_small_steps{.method = Method::Rk4, .step = 1e-2};

/// Records every step of a motion to some time, in s.
void record(double end, Simulation* motion, Recording* recording) {
  recording->take_frame(*motion, motion->friction_forces());
  const Outcome outcome = motion->advance_to(end, [&](const MotionReport& report) {
    recording->take_step(report);
    recording->take_frame(motion->system(), motion->solution(), motion->friction_forces());
    return true;
  });
  ASSERT_TRUE(outcome.ok()) << outcome.what;
}

/// A recording of a run that ends at t = 0.5 s, where its bead sticks on a rough rail after it has slid uphill, is
/// stored in a folder.
struct StoredRecording {
  System system = scenes::make_rough_incline(-1.0, 0.8);
  Simulation motion{system, in_small_steps};
  Recording recording{system, {}};
  Folder folder;

  StoredRecording() {
    record(0.5, &motion, &recording);
    write_recording(folder.path(), "mine", motion.time(), recording);
  }
  bool is_taken_by(Recording* other, const std::string& fingerprint = "mine") const {
    return read_recording(folder.path(), fingerprint, motion, other);
  }
};

TEST(RecordingTest, ARunThatGoesOnKeepsWhatWasRecordedBefore) {
  StoredRecording before;
  Recording after(before.system, {});

  ASSERT_TRUE(before.is_taken_by(&after));

  const std::vector<RecordedFrame> frames = before.recording.frames();
  ASSERT_GT(frames.size(), 40u);
  ASSERT_EQ(before.recording.switches().size(), 1u);
  EXPECT_EQ(after.switches(), before.recording.switches());
  EXPECT_TRUE(after.switches()[0].what.ends_with("[0], point 0 sticks")) << after.switches()[0].what;
  EXPECT_EQ(after.frames_seen(), before.recording.frames_seen());
  EXPECT_EQ(after.guides().size(), 1u);
  ASSERT_EQ(after.frames().size(), frames.size());
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const RecordedFrame frame = after.frames()[k];
    EXPECT_EQ(frame.time, frames[k].time);
    EXPECT_EQ(frame.positions, frames[k].positions);
    EXPECT_EQ(frame.tangent_reactions, frames[k].tangent_reactions);
    EXPECT_EQ(frame.guides, frames[k].guides);
  }
  ASSERT_EQ(after.steps().size(), before.recording.steps().size());
  EXPECT_EQ(after.steps().back().energy, before.recording.steps().back().energy);

  // The frame at which it stands is there already, and nothing that was counted before counts again.
  record(0.6, &before.motion, &after);
  EXPECT_EQ(after.frames().size(), frames.size() + 10);
  EXPECT_EQ(after.switches().size(), 1u);
  EXPECT_EQ(after.num_switches(), 1u);
}

// A page that begins where a run is resumed counts only the switches that it can have seen.
TEST(RecordingTest, ContactSwitchesBeforeItBeganDoNotCount) {
  StoredRecording before;
  ASSERT_EQ(before.recording.num_switches(), 1u);
  Recording late(before.system, {});

  ASSERT_FALSE(before.is_taken_by(&late, "another"));
  MotionReport report = before.motion.report();
  report.events += 3;
  late.take_step(report);

  EXPECT_EQ(late.num_switches(), 3u) << "of one step, all of them";
  EXPECT_EQ(late.switches().size(), 1u);
}

// A killed program may have recorded more than its checkpoint has.
TEST(RecordingTest, WhatCameAfterTheCheckpointIsForgotten) {
  StoredRecording before;
  before.motion = Simulation(before.system, in_small_steps);
  ASSERT_TRUE(before.motion.advance_to(0.2).ok());
  Recording after(before.system, {});

  ASSERT_TRUE(before.is_taken_by(&after));

  EXPECT_EQ(after.frames().back().time, before.motion.time());
  EXPECT_EQ(after.steps().back().time, before.motion.time());
  EXPECT_EQ(after.frames_seen(), after.frames().size());
  EXPECT_EQ(after.num_switches(), before.motion.report().events);
}

// A page has room for 4,000 of these steps.
TEST(RecordingTest, AViolationOfOneStepIsSeenThoughTheStepIsNotKept) {
  const System system = scenes::make_rough_incline(0.0, 0.8);
  Recording recording(system, {});
  for (int k = 0; k < 20'000; ++k) {
    MotionReport report;
    report.time = 1e-3 * k;
    const bool is_bad = k == 12'347;
    report.last_violation = {.position = is_bad ? 1e-3 : 1e-12, .velocity = 1e-11, .acceleration = 1e-10};
    report.last_reciprocal_condition = is_bad ? 1e-6 : 0.5;
    recording.take_step(report);
  }

  const std::vector<RecordedStep> steps = recording.steps();
  EXPECT_LE(steps.size(), 4'001u);
  EXPECT_EQ(std::ranges::count(steps, 1e-3, &RecordedStep::position_violation), 1);
  const auto bad = std::ranges::find(steps, 1e-3, &RecordedStep::position_violation);
  EXPECT_NEAR(bad->time, 12.347, 0.01);
  EXPECT_EQ(bad->reciprocal_condition, 1e-6);
  EXPECT_EQ(steps.back().position_violation, 1e-12);
  EXPECT_EQ(steps.back().reciprocal_condition, 0.5);
}

TEST(RecordingTest, DamagedRecordingsAreNotTaken) {
  StoredRecording before;
  const std::filesystem::path file = before.folder / recording_name;
  const std::string good = read_text(file);
  const auto is_taken = [&](const std::string& text) {
    write_text(file, text);
    Recording after(before.system, {});
    const bool is_taken = before.is_taken_by(&after);
    EXPECT_EQ(after.frames().empty(), !is_taken);
    return is_taken;
  };

  EXPECT_TRUE(is_taken(good));
  for (std::size_t k = 0; k < good.size(); k += good.size() / 97) {
    std::string bad = good;
    bad[k] ^= 1;
    EXPECT_FALSE(is_taken(bad)) << k;
    EXPECT_FALSE(is_taken(good.substr(0, k))) << k;
  }

  write_text(file, good);
  Recording after(before.system, {});
  EXPECT_FALSE(before.is_taken_by(&after, "another scene"));
  System on_a_table = before.system;
  on_a_table.constraints.emplace_back(
      Planes{.name = "table", .points = {0}, .normal = Vector3{0.0, 0.0, 1.0}, .offset = 0.0});
  Recording other(on_a_table, {});
  EXPECT_FALSE(read_recording(before.folder.path(), "mine", Simulation(on_a_table, in_small_steps), &other));
  ASSERT_TRUE(before.motion.advance_to(0.6).ok());  // which nothing recorded
  EXPECT_FALSE(before.is_taken_by(&after));
  remove_file(file);
  EXPECT_FALSE(before.is_taken_by(&after));
}

TEST(RecordingTest, AGuideThatTheStartSizesKeepsItsSize) {
  System system;
  system.positions = {3, 0, 0};
  system.masses = {1.0};
  system.constraints = {Spheres{"ball", {0}, VectorFunction(ScalarFunction::formula("t"), 0.0, 0.0), Parameter()}};

  const std::vector<Guide> later = place_guides(system, 0.0, 2.0);

  ASSERT_EQ(later.size(), 1u);
  EXPECT_EQ(later[0].numbers, (std::vector<double>{2, 0, 0, 3}));
}

// A ball of radius 5 and the plane z = 4 leave a circle of radius 3, and the plane beside it leaves nothing of itself.
TEST(GuidesTest, ASphereAndAPlaneOfTheSamePointsAreACircle) {
  System system;
  system.positions = {4, 2, 5, 0, 0, 4};
  system.masses = {1.0, 1.0};
  const auto place = [&](std::vector<Index> of_plane) {
    system.constraints = {Planes{"cut", std::move(of_plane), Vector3{0, 0, 2}, 10.0},
                          Spheres{"ball", {0}, Vector3{1, 2, 1}, 5.0}};
    return place_guides(system, 0.0, 0.0);
  };
  const std::vector<Guide> ring = place({0});
  ASSERT_EQ(ring.size(), 1u);
  EXPECT_EQ(ring[0].kind, "circle");
  EXPECT_EQ(ring[0].name, "ball");
  EXPECT_EQ(ring[0].numbers, (std::vector<double>{1, 2, 5, 0, 0, 2, 3}));
  EXPECT_EQ(place({0, 1}).size(), 2u) << "of other points";
}

TEST(GuidesTest, ThoseThatAreTooManyToDrawAreCounted) {
  System system;
  system.positions.resize(300);
  system.masses.assign(100, 1.0);
  std::vector<Index> points(100);
  for (std::size_t k = 0; k < 100; ++k) {
    points[k] = static_cast<Index>(k);
    system.positions[3 * k + 2] = static_cast<double>(k / 2);  // two points a plane
  }
  const Planes floors{"", points, Vector3{0, 0, 1}, Parameter()};
  system.constraints = {floors, floors, Lines{"", {0}, Vector3{}, Vector3{1, 0, 0}}};

  EXPECT_EQ(place_guides(system, 0.0, 0.0).size(), 64u);
  const std::vector<Guide> others = Recording(system, {}).guides_without_picture(system);
  ASSERT_EQ(others.size(), 1u);
  EXPECT_EQ(count_of(others[0]), 50u + 50u + 1u - 64u);
  EXPECT_EQ(name_guide(others[0]), "37 more guides");
  system.constraints.pop_back();
  system.constraints.pop_back();
  EXPECT_TRUE(Recording(system, {}).guides_without_picture(system).empty());
}

TEST(RecordingTest, HistoriesBeginAtTheStart) {
  System system;
  system.positions = {0, 0, 3};
  system.masses = {2.0};
  system.forces = {Gravity{"", {0, 0, -10}}};
  Simulation simulation(system, {.method = Method::Rk4, .step = 0.1});
  Recording recording(system, {});

  recording.take_frame(simulation);
  ASSERT_TRUE(simulation
                  .advance_to(0.1,
                              [&](const MotionReport& report) {
                                recording.take_step(report);
                                return true;
                              })
                  .ok());
  recording.take_frame(simulation);

  const std::vector<RecordedStep> steps = recording.steps();
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_EQ(steps[0].time, 0.0);
  EXPECT_NEAR(steps[0].potential, 60.0, 1e-12);
  EXPECT_EQ(steps[0].kinetic, 0.0);
  EXPECT_EQ(steps[1].time, 0.1);
  EXPECT_NEAR(steps[1].kinetic, 1.0, 1e-12);
}

// Atwood's machine: both masses hang on a rope with the tension 2 m1 m2/(m1 + m2) g.
TEST(RecordingTest, ARopeHasItsCourseAndItsTension) {
  System system;
  system.positions = {-1, 0, -2, 1, 0, -1};
  system.masses = {1.0, 3.0};
  system.constraints = {Pulleys{"winch", {{0, 1}}, Vector3{-1, 0, 0}, Vector3{1, 0, 0}}};
  system.forces = {Gravity{"", {0, 0, -10}}};
  const Simulation simulation(system, {.method = Method::Rk4, .step = 0.01});
  Recording recording(system, {});

  recording.take_frame(simulation);

  EXPECT_FLOAT_EQ(recording.frames().at(0).tie_tensions.at(0), 15.0f);
  const std::vector<Guide> ties = list_ties(recording.shown());
  ASSERT_EQ(ties.size(), 1u);
  EXPECT_EQ(find_course(ties[0], system.positions),
            (std::vector<Vector3>{{-1, 0, -2}, {-1, 0, 0}, {1, 0, 0}, {1, 0, -1}}));
  for (const std::vector<double>& odd : {std::vector<double>{}, {NAN, 1}, {1e300, 0, 1}, {1, 0, 0}, {0, 2}, {0, -1}})
    EXPECT_TRUE(find_course({"tie", "", odd}, system.positions).empty());
}

/// A rope is as long as it is: what its points do not need hangs down from its longest segment.
TEST(RecordingTest, SlackRopesSagByWhatTheirPointsLeave) {
  System system;
  system.positions = {0, 0, 0, 2, 0, 0, 3, 0, 0, 2, 0, 1};
  system.masses = {1, 1, 1, 1};
  system.constraints = {Ropes{.name = "slack",
                              .paths = {{0, 1, 2}},
                              .length = ScalarFunction::formula("4.5+0.5*t"),
                              .coefficients = {1, 2}},
                        Ropes{.name = "taut", .paths = {{1, 3}}, .length = 1.0}};
  const ShownParts shown = choose_parts(system, {});
  const std::vector<Guide> guides = list_guides(system, shown, {}, 0.0, 1.0);

  ASSERT_EQ(guides.size(), 2u);
  EXPECT_EQ(guides[0].numbers, (std::vector<double>{5, 1, 2, 0, 1, 2}));
  bool is_slack = false;
  const std::vector<Vector3> course = find_course(guides[0], system.positions, {0, 0, -10}, &is_slack);
  EXPECT_TRUE(is_slack);
  EXPECT_EQ(course.front(), (Vector3{0, 0, 0}));
  EXPECT_EQ(course.back(), (Vector3{3, 0, 0}));
  EXPECT_EQ(course[course.size() - 2], (Vector3{2, 0, 0}));
  double length = 0.0, lowest = 0.0;
  for (std::size_t k = 1; k + 1 < course.size(); ++k) {
    length += std::hypot(course[k][0] - course[k - 1][0], course[k][2] - course[k - 1][2]);
    lowest = std::min(lowest, course[k][2]);
  }
  EXPECT_NEAR(length, 3.0, 0.01 * 3.0) << "2 m from point to point, 1 m left over";
  EXPECT_NEAR(lowest, -std::sqrt((9.0 - 4.0) * (4.0 - 2.0 / 3.0) / 16.0), 1e-12);
  EXPECT_EQ(find_course(guides[1], system.positions, {}, &is_slack), (std::vector<Vector3>{{2, 0, 0}, {2, 0, 1}}));
  EXPECT_FALSE(is_slack);
  for (const std::vector<double>& odd : {std::vector<double>{1, 1, 0}, {1, 1, 0, 9}, {1, 1, -1, 0}, {1, 1, NAN, 0}})
    EXPECT_TRUE(find_course({"rope", "", odd}, system.positions).empty());
}

/// They have no multiplier, so that their tension is not known here; one with a hidden end is not drawn.
TEST(RecordingTest, SpringsAreCoilsAndBondsLinesBehindRopes) {
  System system;
  system.positions = {-1, 0, -2, 1, 0, -1, 2, 0, 0, 3, 0, 0};
  system.masses = {1, 3, 1, 1};
  system.constraints = {Pulleys{"winch", {{0, 1}}, Vector3{-1, 0, 0}, Vector3{1, 0, 0}}};
  system.forces = {Springs{.pairs = {{2, 3}, {1, 2}}, .stiffness = 2.0},
                   Bonds{.name = "glue", .pairs = {{0, 2}}, .stiffness = 1.0, .rest_length = 1.0}};
  const std::vector<Index> all, some{0, 1, 2};

  const std::vector<Guide> ties = list_ties(choose_parts(system, all));

  ASSERT_EQ(ties.size(), 4u);
  for (const auto& [k, name] : {std::pair{0, "winch[0]"}, {1, "spring0[0]"}, {2, "spring0[1]"}, {3, "glue[0]"}})
    EXPECT_EQ(ties[k].name, name);
  EXPECT_EQ(find_course(ties[3], system.positions), (std::vector<Vector3>{{-1, 0, -2}, {2, 0, 0}}));
  const std::vector<Vector3> coil = find_course(ties[2], system.positions);
  EXPECT_EQ(coil.front(), (Vector3{1, 0, -1}));
  EXPECT_EQ(coil.back(), (Vector3{2, 0, 0}));
  for (std::size_t k = 1; k + 1 < coil.size(); ++k) {
    const double part = static_cast<double>(k) / static_cast<double>(coil.size() - 1);
    const auto [x, y, z] = coil[k];
    EXPECT_NEAR(x - 1 + z + 1, 2 * part, 1e-12) << "beside its place on the way of a spring along (1, 0, 1)";
    EXPECT_NEAR(std::hypot(x - 1 - part, y, z + 1 - part), 0.05 * std::sqrt(2.0), 1e-12);
  }
  const ShownParts shown = choose_parts(system, some);
  EXPECT_EQ(shown.ties.size(), 3u);
  const std::vector<double> tensions = find_tie_tensions(shown, std::vector{-15.0});
  EXPECT_EQ(tensions[0], 15.0);
  for (const std::size_t k : {1u, 2u}) EXPECT_TRUE(std::isnan(tensions[k]));
  std::get<Springs>(system.forces[0]).pairs.resize(2005, {2, 3});
  EXPECT_EQ(name_guide(list_guides_without_picture(system, choose_parts(system, all), 0.0).back()),
            "7 more ropes, formulas, springs and bonds");
}

TEST(RecordingTest, RopesThatAreTooManyToDrawAreCounted) {
  System system;
  system.positions = {-1, 0, -2, 1, 0, -1};
  system.masses = {1.0, 3.0};
  system.constraints = {
      Pulleys{"", std::vector<std::array<Index, 2>>(2003, {0, 1}), Vector3{-1, 0, 0}, Vector3{1, 0, 0}}};

  const ShownParts shown = choose_parts(system, {});

  EXPECT_EQ(shown.ties.size(), 2000u);
  EXPECT_EQ(shown.ties_left_out, 3u);
}

}  // namespace
}  // namespace tanor::report
