/// Ropes (C) and one-sided guides (D) with digits: instants of events to 1e-12, impulses and states to 1e-11.

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
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
  const std::vector<ContactEvent>& found = simulation_.report().contact_events;
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

}  // namespace
}  // namespace tanor::cases
