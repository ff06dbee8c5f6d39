/// Passages of a user's functions through 0.

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "motion/elliptic.hpp"
#include "motion/toys.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

using std::numbers::pi;
const double frequency = std::sqrt(9.81 / scenes::spacing);
const double quarter = elliptic::quarter_period(0.5 * pi, frequency);

/// Returns the event x = 0 of a pendulum, which is released at x = 0.1 m and passes it at odd quarters of its period.
Event through_the_vertical(Event::Direction direction = Event::Direction::Both, bool stops = false) {
  return {"vertical", [](double, std::span<const double> r, std::span<const double>) { return r[3]; }, direction,
          stops};
}

struct Accuracy {
  MotionOptions options;
  double error;  // s, of the passages

  friend std::ostream& operator<<(std::ostream& out, const Accuracy& one) { return out << name_of(one.options.method); }
};

class UserEventsTest : public testing::TestWithParam<Accuracy> {};

TEST_P(UserEventsTest, APendulumPassesTheVerticalWhenEllipticIntegralsSay) {
  Simulation simulation(scenes::make_pendulum(), GetParam().options);
  simulation.add_event(through_the_vertical());

  ASSERT_TRUE(simulation.advance_to(10.0 * quarter).ok()) << simulation.outcome().what;

  ASSERT_EQ(simulation.passages().size(), 5U);
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_NEAR(simulation.passages()[k].time, (2.0 * static_cast<double>(k) + 1.0) * quarter, GetParam().error);
    EXPECT_EQ(simulation.passages()[k].rises, k % 2 == 1);
  }
}

TEST_P(UserEventsTest, AStoppingEventEndsTheAdvanceAndTheNextAdvanceGoesOn) {
  Simulation watched(scenes::make_pendulum(), GetParam().options);
  const std::size_t turn = watched.add_event(
      {"turn",
       [](double, std::span<const double> r, std::span<const double> v) { return r[3] * v[5] - r[5] * v[3]; },
       {},
       false});
  const std::size_t vertical = watched.add_event(through_the_vertical(Event::Direction::Rising, true));

  for (const double wanted : {3.0 * quarter, 7.0 * quarter}) {
    ASSERT_TRUE(watched.advance_to(10.0).ok()) << watched.outcome().what;
    EXPECT_NEAR(watched.time(), wanted, GetParam().error);
    EXPECT_EQ(watched.passages().back().event, vertical);
    EXPECT_EQ(watched.passages().back().time, watched.time());
    EXPECT_NEAR(watched.positions()[3], 0.0, 2.0 * GetParam().error);
    EXPECT_NEAR(watched.velocities()[3], std::sqrt(2.0 * 9.81 * scenes::spacing), 20.0 * GetParam().error);
  }
  // The pendulum begins at rest, which is no passage, and turns at 2, 4 and 6 quarters.
  std::vector<std::size_t> order;
  for (const Passage& passage : watched.passages()) order.push_back(passage.event);
  EXPECT_EQ(order, (std::vector{turn, vertical, turn, turn, vertical}));
}

INSTANTIATE_TEST_SUITE_P(Methods, UserEventsTest,
                         testing::Values(Accuracy{{.method = Method::Taylor, .rtol = 1e-13, .atol = 1e-15}, 1e-11},
                                         Accuracy{{.method = Method::Dop853, .rtol = 1e-13, .atol = 1e-15}, 1e-10},
                                         Accuracy{{.method = Method::Dopri5, .rtol = 1e-13, .atol = 1e-15}, 1e-10},
                                         Accuracy{{.method = Method::Rk4, .step = 1e-4}, 1e-10},
                                         Accuracy{{.method = Method::Rattle6, .step = 1e-3}, 1e-8},
                                         Accuracy{{.method = Method::Rattle, .step = 1e-4}, 1e-5}),
                         [](const auto& instance) { return std::string(name_of(instance.param.options.method)); });

TEST(UserEventsTest, CoordinatesGiveTheSameInstants) {
  System system = scenes::make_pendulum();
  system.constraints.clear();
  system.coordinates = {ChainAngles{"chain", {1}, 0, scenes::spacing, {}}};
  Simulation simulation(system, {.method = Method::Dop853, .rtol = 1e-13, .atol = 1e-15});
  simulation.add_event(through_the_vertical());

  ASSERT_TRUE(simulation.advance_to(4.0 * quarter).ok());

  ASSERT_EQ(simulation.passages().size(), 2U);
  EXPECT_NEAR(simulation.passages()[0].time, quarter, 1e-10);
  EXPECT_NEAR(simulation.passages()[1].time, 3.0 * quarter, 1e-10);
}

TEST(UserEventsTest, LookingChangesNoMotion) {
  const MotionOptions options{.method = Method::Dop853, .rtol = 1e-9, .atol = 1e-11};
  Simulation plain(scenes::make_shaken_chain(), options), watched(scenes::make_shaken_chain(), options);
  watched.add_event(
      {"first rod upright", [](double, std::span<const double> r, std::span<const double>) { return r[3] - r[0]; }});

  ASSERT_TRUE(plain.advance_to(1.0).ok());
  ASSERT_TRUE(watched.advance_to(1.0).ok());

  EXPECT_GT(watched.passages().size(), 0U);
  EXPECT_EQ(watched.report().steps, plain.report().steps);
  EXPECT_LT(largest_difference(watched.positions(), plain.positions()), 1e-13);
}

/// A time is an event as well, and is found inside long steps of a motion at rest.
TEST(UserEventsTest, FunctionsOfTimeAreFoundToRounding) {
  System system = scenes::make_pendulum();
  system.positions = {0, 0, 0, 0, 0, -0.1};
  Simulation simulation(system);
  simulation.add_event(
      {"bell", [](double t, std::span<const double>, std::span<const double>) { return std::sin(t); }, {}, true});

  for (const double wanted : {pi, 2.0 * pi}) {
    ASSERT_TRUE(simulation.advance_to(7.0).ok());
    EXPECT_NEAR(simulation.time(), wanted, 1e-14);
  }
  ASSERT_TRUE(simulation.advance_to(7.0).ok());
  EXPECT_EQ(simulation.time(), 7.0);
}

/// A block on a spring with friction 0.1, x'' = -x, slides from 1 to -0.8, where it turns. The step that ends there has
/// other accelerations at its end, but its passages are those of the motion before.
TEST(UserEventsTest, PassagesInStepsThatEndInASwitchAreThoseOfTheMotionBefore) {
  toys::Block block(1.0, 0.0, 0.1, 0.1);
  toys::Travel travel(block, Method::Dop853, {.step = 0.1, .rtol = 1e-12, .atol = 1e-14}, {1.0}, {0.0});
  block.direction = -1;
  travel.place(block, 0.0, {1.0}, {0.0});
  const auto through = [](double x0) { return [x0](double, const double* x, const double*) { return x[0] - x0; }; };
  travel.integration.watch().add({through(-0.7999), Event::Direction::Both, false});

  ASSERT_TRUE(travel.advance(4.0).ok());

  // The motion is x = 0.1 + 0.9 cos(t) until t = pi, then x = -0.1 - 0.7 cos(t - pi).
  ASSERT_EQ(travel.integration.watch().passages().size(), 2U);
  EXPECT_NEAR(travel.integration.watch().passages()[0].time, std::acos(-0.8999 / 0.9), 1e-8);
  EXPECT_NEAR(travel.integration.watch().passages()[1].time, pi + std::acos(0.6999 / 0.7), 1e-8);
}

TEST(UserEventsTest, AFunctionThatIsNoNumberIsReported) {
  Simulation simulation(scenes::make_pendulum());
  simulation.add_event({"broken", [](double, std::span<const double>, std::span<const double>) { return NAN; }});

  const Outcome outcome = simulation.advance_to(1.0);

  EXPECT_EQ(outcome.status, Status::StepTooSmall);
  EXPECT_NE(outcome.what.find("event \"broken\" is not finite"), std::string::npos) << outcome.what;
  EXPECT_THROW(simulation.add_event({"empty"}), InputError);
}

/// The function is no number so near to its root that steps evaluate it on both sides of that gap alone.
TEST(UserEventsTest, AFunctionThatIsNoNumberAtItsRootHasNoPassage) {
  for (const MotionOptions& options : {MotionOptions{.method = Method::Taylor, .rtol = 1e-10, .atol = 1e-12},
                                       MotionOptions{.method = Method::Rk4, .step = 1e-3}}) {
    Simulation simulation(scenes::make_pendulum(), options);
    simulation.add_event({"", [](double, std::span<const double> r, std::span<const double>) {
                            return std::abs(r[3]) < 1e-6 ? NAN : r[3];
                          }});

    const Outcome outcome = simulation.advance_to(2.0 * quarter);

    EXPECT_FALSE(outcome.ok());
    EXPECT_NE(outcome.what.find("event 0 is not finite"), std::string::npos) << outcome.what;
    EXPECT_TRUE(simulation.passages().empty());
    EXPECT_NEAR(simulation.time(), quarter, 2e-3);
  }
}

}  // namespace
}  // namespace tanor
