#include <gtest/gtest.h>

#include "motion/toys.hpp"

namespace tanor {
namespace {

using toys::SwitchingToy;
using toys::Travel;

constexpr double singular_time = 0.8;

/// A ball that flies freely and turns where x falls through 0. K loses rank at `singular_time`, where the smallest
/// singular value of K goes through 0 as a straight line.
class Ball final : public SwitchingToy {
 public:
  explicit Ball(double steepness = 0.01) : SwitchingToy(1), steepness_(steepness) {}

  Outcome push(double t, const double*, const double*, double* a) override {
    const double distance = t - singular_time;
    reciprocal_condition_ = steepness_ * distance * distance;
    a[0] = 0.0;
    return {};
  }
  std::size_t num_events() const override { return 1; }
  void evaluate_events(const Kinematics& at, const Reactions&, double* values) override {
    values[0] = at.v[0] > 0.0 ? 1.0 : at.x[0];
  }
  Outcome switch_equations(double t, const double* x, double* v, std::span<const std::size_t>, const Request&,
                           const AccelerationOutput& to) override {
    switch_times.push_back(t);
    v[0] = -v[0];
    return push(t, x, v, to.a);
  }
  double reciprocal_condition() const override { return reciprocal_condition_; }

 private:
  double steepness_;
  double reciprocal_condition_ = 1.0;
};

/// Options with which steps end at 0.1, 0.6, …, since an error of 0 makes every step five times the one before.
const MotionOptions growing{.step = 0.1, .rtol = 1e-8, .atol = 1e-8};

TEST(SingularEventTest, AMotionWithoutEventsIsExtrapolatedPastTheSingularConfiguration) {
  Ball ball;
  Travel travel(ball, Method::Dopri5, growing, {10.0}, {-1.0});

  ASSERT_TRUE(travel.advance(2.0).ok());

  EXPECT_NEAR(travel.integration.state.x[0], 8.0, 1e-12);
  ASSERT_EQ(travel.report.singular_passages.count, 1u);
  EXPECT_NEAR(travel.report.singular_passages.first[0].time, singular_time, 1e-12);
}

TEST(SingularEventTest, ASwitchForgetsTheVelocityBeforeIt) {
  // The ball turns at 0.4. A step of 0.5 from there would be extrapolated along the velocity that it had at 0.1.
  Ball ball;
  Travel travel(ball, Method::Dopri5, growing, {0.4}, {-1.0});

  ASSERT_TRUE(travel.advance(2.0).ok());

  ASSERT_EQ(ball.switch_times.size(), 1u);
  EXPECT_NEAR(ball.switch_times[0], 0.4, 1e-12);
  EXPECT_NEAR(travel.integration.state.x[0], 1.6, 1e-12);
  EXPECT_EQ(travel.integration.state.v[0], 1.0);
  EXPECT_EQ(travel.report.rejected, 0u);
}

TEST(SingularEventTest, AFixedStepGoesOnAfterASwitchWithTheVelocityOfTheNewEquations) {
  // The singular configuration is suspected first at 0.6, where the ball turns in the midst of a step from 0.5 to 1.
  Ball ball(0.2);
  Travel travel(ball, Method::Rk4, {.step = 0.5}, {0.6}, {-1.0});

  ASSERT_TRUE(travel.advance(2.0).ok());

  ASSERT_EQ(ball.switch_times.size(), 1u);
  EXPECT_NEAR(ball.switch_times[0], 0.6, 1e-12);
  EXPECT_NEAR(travel.integration.state.x[0], 1.4, 1e-12);
  EXPECT_EQ(travel.integration.state.v[0], 1.0);
}

TEST(SingularEventTest, AnEventDuringAnExtrapolationIsMetAtItsEnd) {
  // The motion is extrapolated from 0.6 over 0.2 + 0.5 (0.5/2) = 0.325.
  Ball ball;
  Travel travel(ball, Method::Dopri5, growing, {0.85}, {-1.0});

  ASSERT_TRUE(travel.advance(2.0).ok());

  ASSERT_EQ(ball.switch_times.size(), 1u);
  EXPECT_NEAR(ball.switch_times[0], 0.925, 1e-12);
  EXPECT_EQ(travel.report.last_event, ball.switch_times[0]);
  EXPECT_NEAR(travel.integration.state.x[0], 1.0, 1e-12);  // 1.075 - 0.075
  EXPECT_EQ(travel.report.singular_passages.count, 1u);
  EXPECT_EQ(travel.report.steps, 4u) << "to 0.1, 0.6, 0.925 and 2";
}

}  // namespace
}  // namespace tanor
