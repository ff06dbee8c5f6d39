#include "report/recording.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "rough_incline.hpp"

namespace tanor::report {
namespace {

double length(const std::vector<float>& v) {
  return std::hypot(v[0], v[1], v[2]);
}

// m = 2, 30 degrees: the rail pushes with m g cos(30), friction holds back with mu times that.
TEST(RecordingTest, ReactionsOfAGuideHaveANormalAndATangentPart) {
  const System system = make_incline(1.0, 0.2);
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

// A support carries what hangs on it, and the rods' pull is no reaction of a guide.
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

// Seven output times are no film. Where they are many, or points are, nothing more is asked for.
TEST(RecordingTest, AsksForInstantsBetweenOutputTimesThatAreRare) {
  const System system = make_incline(1.0, 0.2);
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
  const System system = make_incline(1.0, 0.2);
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
  Recording recording(make_incline(1.0, 0.2), {});

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

TEST(RecordingTest, AGuideThatTheStartSizesKeepsItsSize) {
  System system;
  system.positions = {3, 0, 0};
  system.masses = {1.0};
  system.constraints = {Spheres{"ball", {0}, VectorFunction(ScalarFunction::formula("t"), 0.0, 0.0), Parameter()}};

  const std::vector<Guide> later = place_guides(system, 2.0, {.time = 0.0, .positions = system.positions}, 10);

  ASSERT_EQ(later.size(), 1u);
  EXPECT_EQ(later[0].numbers, (std::vector<double>{2, 0, 0, 3}));
}

}  // namespace
}  // namespace tanor::report
