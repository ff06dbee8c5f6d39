/// Ropes (C) and one-sided guides (D) with digits: instants of events to 1e-12, impulses and states to 1e-11.

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <tanor/equilibrium.hpp>
#include <tanor/motion.hpp>

#include "cases/reference_case.hpp"
#include "measures.hpp"
#include "scene/scene.hpp"

namespace tanor::cases {
namespace {

struct OneSidedCase {
  std::string name;
  bool bounces = false;  ///< events follow ever faster to an accumulation, and are not all listed
};

std::ostream& operator<<(std::ostream& out, const OneSidedCase& each) {
  return out << each.name;
}

class RopeCases : public testing::TestWithParam<OneSidedCase> {
 protected:
  const nlohmann::json file_ = read_case(GetParam().name);
  const scene::Scene scene_ = scene::parse_scene(file_.at("scene").dump(), "case.json");
  Simulation simulation_{scene_.system, scene_.motion, {.threads = 1}};

  std::vector<double> spatial(const nlohmann::json& list) const {
    return make_spatial(numbers(list), file_.at("dim").get<std::size_t>());
  }
};

TEST_P(RopeCases, StatesHaveTheDigitsOfTheReference) {
  double length = 0.0, speed = 0.0;
  for (const nlohmann::json& state : file_.at("states")) {
    length = std::max(length, largest(spatial(state.at("r"))));
    speed = std::max(speed, largest(spatial(state.at("v"))));
  }
  for (const nlohmann::json& state : file_.at("states")) {
    const Outcome outcome = simulation_.advance_to(number(state.at("t")));
    ASSERT_TRUE(outcome.ok()) << outcome.what;
    EXPECT_LT(largest_difference(simulation_.positions(), spatial(state.at("r"))), 1e-11 * length) << state.at("t");
    EXPECT_LT(largest_difference(simulation_.velocities(), spatial(state.at("v"))), 1e-11 * speed) << state.at("t");
    const std::vector<double> tensions = numbers(state.at("tension"));
    for (std::size_t k = 0; k < tensions.size(); ++k)
      EXPECT_NEAR(-simulation_.multipliers()[k], tensions[k], 1e-10 * std::max(1.0, tensions[k])) << state.at("t");
  }
}

TEST_P(RopeCases, EventsHaveTheInstantsAndImpulsesOfTheReference) {
  const Outcome outcome = simulation_.advance_to(scene_.t_end);
  ASSERT_TRUE(outcome.ok()) << outcome.what;
  // The reference does not list the ropes that an impact lets go slack.
  std::vector<ContactEvent> found;
  for (const ContactEvent& event : simulation_.report().contact_events) {
    const bool is_of_impact = !found.empty() && event.time == found.back().time;
    if (!is_of_impact || event.change != ContactChange::Slack) found.push_back(event);
  }
  std::size_t compared = 0;
  for (const nlohmann::json& wanted : file_.at("events")) {
    const std::string kind = wanted.at("kind");
    if (GetParam().bounces && compared == 5) break;
    ASSERT_LT(compared, found.size());
    const ContactEvent& event = found[compared++];
    EXPECT_NEAR(event.time, number(wanted.at("t")), 1e-12 * number(wanted.at("t")));
    EXPECT_EQ(event.change, kind == "snap" ? ContactChange::Snap : ContactChange::Slack);
    if (kind != "snap") continue;
    const std::vector<std::size_t> ropes = wanted.at("ropes");
    const std::vector<double> impulses = numbers(wanted.at("impulses"));
    const std::vector<double> rates = numbers(wanted.value("rates_before", nlohmann::json::array()));
    for (std::size_t k = 0; k < impulses.size(); ++k) {
      const auto place = std::ranges::find(event.equations, ropes[k]) - event.equations.begin();
      ASSERT_LT(place, std::ssize(event.equations)) << ropes[k];
      EXPECT_NEAR(event.impulses[static_cast<std::size_t>(place)], impulses[k], 1e-11 * std::max(1.0, impulses[k]));
      if (rates.empty()) continue;
      EXPECT_NEAR(event.rates_before[static_cast<std::size_t>(place)], rates[k], 1e-11 * std::max(1.0, rates[k]));
    }
    if (!wanted.contains("energy_lost")) continue;
    EXPECT_NEAR(event.energy_lost, number(wanted.at("energy_lost")), 1e-10);
  }
  if (!GetParam().bounces) EXPECT_EQ(found.size(), compared);
}

INSTANTIATE_TEST_SUITE_P(Cases, RopeCases,
                         testing::Values(OneSidedCase{"C1_ball_on_string_e0"},
                                         OneSidedCase{"C1_ball_on_string_e05", true},
                                         OneSidedCase{"C2_two_balls_string_e0"},
                                         OneSidedCase{"C2_two_balls_string_e05", true}, OneSidedCase{"C3_atwood_slack"},
                                         OneSidedCase{"C4_hub_three_strings_e0"},
                                         OneSidedCase{"C4_hub_three_strings_e05", true},
                                         OneSidedCase{"C5_chain_of_ropes_N5"}, OneSidedCase{"C6_winch_lift_e0"},
                                         OneSidedCase{"C7_crane_two_loads"}, OneSidedCase{"C7_ring_on_rope"}),
                         [](const auto& instance) { return instance.param.name; });

// ---- guides ----

struct Guided {
  nlohmann::json file;
  scene::Scene scene;
  Simulation simulation;

  explicit Guided(const std::string& name)
      : file(read_case(name)),
        scene(scene::parse_scene(file.at("scene").dump(), "case.json")),
        simulation(scene.system, {.method = Method::Taylor, .rtol = 1e-13, .atol = 1e-15}, {.threads = 1}) {}
  const std::vector<ContactEvent>& advance_to(double t) {
    const Outcome outcome = simulation.advance_to(t);
    EXPECT_TRUE(outcome.ok()) << outcome.what;
    return simulation.report().contact_events;
  }
};

class BouncingBall : public testing::TestWithParam<const char*> {};

TEST_P(BouncingBall, ImpactsFollowEachOtherAndEndInTheAccumulation) {
  Guided ball(GetParam());
  const double end = number(ball.file.at("zeno_time"));
  const std::vector<ContactEvent>& found = ball.advance_to(1.2 * end);
  std::size_t k = 0;
  for (const nlohmann::json& wanted : ball.file.at("first_impacts")) {
    ASSERT_LT(k, found.size());
    EXPECT_EQ(found[k].change, ContactChange::Touch);
    EXPECT_NEAR(found[k].time, number(wanted.at("t")), 1e-12 * number(wanted.at("t")));
    EXPECT_NEAR(found[k++].impulses.at(0), number(wanted.at("impulse_per_mass")), 1e-11);
  }
  EXPECT_EQ(found.back().change, ContactChange::Zeno);
  EXPECT_NEAR(found.back().time, end, 1e-3 * end);
}

TEST_P(BouncingBall, StatesBetweenAndAfterTheImpactsAreThoseOfTheClosedForm) {
  std::vector<nlohmann::json> states = read_case(GetParam()).at("states");
  std::ranges::sort(states, {}, [](const nlohmann::json& state) { return number(state.at("t")); });
  Guided ball(GetParam());
  for (const nlohmann::json& state : states) {
    (void)ball.advance_to(number(state.at("t")));
    const std::vector<double> r = make_spatial(numbers(state.at("r")), 2);
    EXPECT_LT(largest_difference(ball.simulation.positions(), r), 1e-11 * (1.0 + largest(r))) << state.at("t");
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, BouncingBall, testing::Values("D1_bouncing_ball", "D1_bouncing_incline"));

/// A bead slides down the outside of a sphere, lifts off where its force vanishes, bounces on a floor and slides on it.
TEST(OneSidedGuides, ABeadLeavesASphereWhereTheForceVanishes) {
  Guided bead("D2_sphere_outside");
  for (const nlohmann::json& state : bead.file.at("states")) {
    const std::vector<ContactEvent>& found = bead.advance_to(number(state.at("t")));
    const std::vector<double> r = numbers(state.at("r")), v = numbers(state.at("v"));
    const std::size_t up = bead.simulation.positions()[1] == 0.0 ? 2 : 1;
    EXPECT_NEAR(bead.simulation.positions()[0], r[0], 1e-11);
    EXPECT_NEAR(bead.simulation.positions()[up], r[1], 1e-11);
    EXPECT_NEAR(bead.simulation.velocities()[0], v[0], 1e-11);
    EXPECT_NEAR(bead.simulation.velocities()[up], v[1], 1e-11);
    if (found.empty()) continue;
    EXPECT_EQ(found[0].change, ContactChange::LiftOff);
    EXPECT_NEAR(found[0].time, number(bead.file.at("leaves").at("t")), 1e-12);
    if (found.size() > 1) {
      EXPECT_EQ(found[1].change, ContactChange::Touch);
      EXPECT_NEAR(found[1].time, number(bead.file.at("first_floor_impact").at("t")), 1e-12);
    }
  }
}

/// Ten beads fall in a column; the k-th impact is that of the reference, with floor and beads in its order.
TEST(OneSidedGuides, AColumnOfBeadsCollidesOneByOne) {
  const nlohmann::json file = read_case("D3_column_of_beads");
  const std::vector<double> heights = numbers(file.at("points").at("z"));
  const double e = number(file.at("e"));
  System system;
  Rods gaps{.length = 0.2, .side = OneSide::AtLeast, .restitution = e};
  for (std::size_t i = 0; i < heights.size(); ++i) {
    (void)system.add_point({{0.0, 0.0, heights[i]}});
    if (i > 0) gaps.pairs.push_back({static_cast<Index>(i) - 1, static_cast<Index>(i)});
  }
  system.add_gravity({0.0, 0.0, -number(file.at("g"))});
  system.constraints = {
      Planes{.points = {0}, .normal = {0.0, 0.0, 1.0}, .offset = 0.1, .side = OneSide::AtLeast, .restitution = e},
      gaps};
  Simulation simulation(system, {.method = Method::Taylor, .rtol = 1e-13}, {.threads = 1});
  ASSERT_TRUE(simulation.advance_to(0.48).ok());
  std::size_t k = 0;
  for (const nlohmann::json& wanted : file.at("first_impacts")) {
    if (number(wanted.at("t")) > 0.48) break;
    ASSERT_LT(k, simulation.report().contact_events.size());
    const ContactEvent& found = simulation.report().contact_events[k++];
    EXPECT_NEAR(found.time, number(wanted.at("t")), 1e-12) << k;
    const std::size_t row = wanted.at("pair").is_string() ? 0 : wanted.at("pair")[1].get<std::size_t>();
    EXPECT_EQ(found.equations, std::vector<std::size_t>{row}) << k;
    EXPECT_NEAR(found.impulses.at(0), number(wanted.at("impulse")), 1e-11) << k;
  }
  EXPECT_GT(k, 20u);
}

/// Four equal strings meet at a hub, whose three directions they hold: the motion is unique, the tensions are not.
TEST(OneSidedGuides, FourStringsThatAreThreeStopAHub) {
  Guided hub("C4_hub_four_strings_redundant");
  const double t = number(hub.file.at("snap"));
  const std::vector<ContactEvent>& found = hub.advance_to(1.05 * t);
  ASSERT_FALSE(found.empty());
  EXPECT_NEAR(found[0].time, t, 1e-12);
  EXPECT_EQ(found[0].equations.size(), 4u);
  EXPECT_NEAR(found[0].energy_lost, number(hub.file.at("energy_lost_first_impact")), 1e-11);
  EXPECT_LT(largest(hub.simulation.velocities()), 1e-11);
  const std::vector<double> upwards = {0.0, 0.0, 2.0 * number(nlohmann::json("9.81"))};
  EXPECT_LT(largest_difference(hub.simulation.reactions().last(3), upwards), 1e-10);
}

// ---- nets ----

/// A gust hits a net at rest whose ropes are all just taut: which of them hold in the first instant.
TEST(NetOfRopes, AGustTightensTheRopesOfTheReference) {
  const nlohmann::json file = read_case("C8_net_gust_instant");
  const System system = scene::parse_scene(file.at("scene").dump(), "case.json").system;
  const Solution found = Dynamics(system, {.threads = 1}).solution({.positions = system.positions});
  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  const std::vector<double> tensions = numbers(file.at("tension"));
  for (std::size_t k = 0; k < tensions.size(); ++k) EXPECT_NEAR(-found.multipliers[k], tensions[k], 1e-11 * 20.0) << k;
  std::vector<double> accelerations;
  for (const nlohmann::json& point : file.at("accelerations")) {
    for (const double each : numbers(point)) accelerations.push_back(each);
  }
  EXPECT_LT(largest_difference(found.accelerations, accelerations), 1e-11 * largest(accelerations));
}

/// The same net rests in steady wind, with four slack ropes.
TEST(NetOfRopes, RestInWindHasTheSlackRopesOfTheReference) {
  const nlohmann::json file = read_case("C8_net_wind_static");
  const System system = scene::parse_scene(file.at("scene").dump(), "case.json").system;
  const EquilibriumResult found = find_equilibrium(system, {.force_tolerance = 1e-13, .solver = {.threads = 1}});
  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  const std::vector<double> tensions = numbers(file.at("tensions"));
  for (std::size_t k = 0; k < tensions.size(); ++k) {
    EXPECT_NEAR(-found.multipliers[k], tensions[k], 1e-11 * largest(tensions)) << k;
    EXPECT_EQ(found.open[k], tensions[k] == 0.0) << k;
  }
  std::size_t next = 0;
  for (const std::size_t point : file.at("moving_points").get<std::vector<std::size_t>>()) {
    const std::vector<double> wanted = numbers(file.at("positions_of_moving_points")[next++]);
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(found.positions[3 * point + axis], wanted[axis], 1e-11) << point;
  }
}

}  // namespace
}  // namespace tanor::cases
