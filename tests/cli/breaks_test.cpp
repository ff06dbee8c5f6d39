#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "cli/program.hpp"

namespace tanor::cli {
namespace {

using nlohmann::json;

constexpr double fall = 9.81;

/// Runs a scene of which nothing is certified, so that no certificate says what the run does not.
json run_scene(json scene, int code = 0, std::string* said = nullptr) {
  const Folder folder;
  scene["tanor_scene"] = 1;
  scene["solver"]["certificate"] = "off";
  scene["motion"]["rtol"] = 1e-12;
  scene["motion"]["method"] = "dop853";
  write_text(folder / "s.json", scene.dump());
  const Ended ended = run_program(folder, {"run", "s.json", "--out", "o"});
  EXPECT_EQ(ended.code, code) << ended.err;
  if (said != nullptr) *said = ended.err;
  return read_json(folder / "o/summary.json");
}

/// A mass of 3 lifts one of 1 against a spring of 16 N/m: s = s1 (1 - cos 2t), T = 3 g (1 - cos(2t)/2). The rope breaks
/// at 3 g, where cos 2t = 0; then 3 falls freely and 1 swings on its spring, until that breaks, too.
TEST(BreaksTest, ARopeAndThenASpringBreak) {
  const json summary = run_scene(json::parse(R"json({
    "points": {"positions": [[0,0,-3], [1,0,-1], [0,0,-5]], "masses": [1, 3, 1]}, "supports": [{"points": [2]}],
    "constraints": [{"name": "rope", "kind": "pulley", "pairs": [[0, 1]], "a": [0,0,0], "b": [1,0,0]}],
    "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]},
               {"name": "spring", "kind": "spring", "pairs": [[2, 0]], "stiffness": 16, "rest_length": "initial"}],
    "events": [{"name": "snap", "when": "29.43 < tension(rope)", "do": "break"},
               {"when": "t > 1", "do": "break", "of": "spring[0]"}],
    "observe": [{"what": "tension(rope)", "every_step": true}, "tension(spring)"], "motion": {"t_end": 1.1}})json"));

  const double s1 = 2.0 * fall / 16.0, t1 = std::numbers::pi / 4.0;
  const json& passages = summary.at("passages");
  ASSERT_EQ(passages.size(), 2U);
  EXPECT_EQ(passages[0].at("member"), "rope[0]");
  EXPECT_NEAR(passages[0].at("t").get<double>(), t1, 1e-10);
  EXPECT_EQ(passages[0].at("energy_lost"), 0.0);
  EXPECT_EQ(passages[0].at("rest"), "point 0 and 1 more are without constraints");
  EXPECT_NEAR(summary.at("observables")[0].at("largest")[0].at("value").get<double>(), 3.0 * fall, 1e-8);
  EXPECT_TRUE(summary.at("observables")[0].at("values")[0].is_null());
  EXPECT_TRUE(summary.at("final").at("multipliers")[0].is_null());
  const double until = 1.0 - t1, left = 0.1, mean = -fall / 16.0;
  const double s = mean + (s1 - mean) * std::cos(4.0 * until) + 0.5 * s1 * std::sin(4.0 * until);
  const double speed = -4.0 * (s1 - mean) * std::sin(4.0 * until) + 2.0 * s1 * std::cos(4.0 * until);
  EXPECT_EQ(passages[1].at("member"), "spring[0]");
  const json& at_breaks = summary.at("observables")[1];  // its frames are at 0 and 1.1, where it has no tension
  EXPECT_NEAR(at_breaks.at("least")[0].at("value").get<double>(), std::min(0.0, 16.0 * s), 1e-8);
  EXPECT_NEAR(at_breaks.at("largest")[0].at("value").get<double>(), 16.0 * std::max(s1, s), 1e-8);
  EXPECT_NEAR(passages[1].at("energy_lost").get<double>(), 8.0 * s * s, 1e-9);
  const json& positions = summary.at("final").at("positions");
  EXPECT_NEAR(positions[0][2].get<double>(), -3.0 + s + speed * left - 0.5 * fall * left * left, 1e-9);
  const double fallen = 1.1 - t1;
  EXPECT_NEAR(positions[1][2].get<double>(), -1.0 - s1 - 2.0 * s1 * fallen - 0.5 * fall * fallen * fallen, 1e-9);
}

/// A point leaves a bond whose energy at the break its speed has lost.
TEST(BreaksTest, ABondTellsTheEnergyOfItsLaw) {
  const double morse = 2.0 * std::pow(1.0 - std::exp(-1.5 * 0.4), 2), fene = -0.5 * 3.0 * 4.0 * std::log(1.0 - 0.49);
  for (const auto& [law, held] :
       {std::pair(json{{"law", "morse"}, {"depth", 2}, {"width", 1.5}, {"rest_length", 1}}, morse),
        std::pair(json{{"law", "fene"}, {"stiffness", 3}, {"limit", 2}}, fene),
        std::pair(json{{"law", "harmonic"}, {"stiffness", 5}, {"rest_length", 1}}, 0.5 * 5.0 * 0.16)}) {
    json bond = law;
    bond.update({{"name", "bond"}, {"kind", "bond"}, {"pairs", {{0, 1}}}});
    const json summary =
        run_scene({{"points", {{"positions", {{0, 0, 0}, {1, 0, 0}}}, {"velocities", {{0, 0, 0}, {4, 0, 0}}}}},
                   {"supports", {{{"points", {0}}}}},
                   {"forces", {bond}},
                   {"events", {{{"when", "distance(0, 1) > 1.4"}, {"do", "break"}, {"of", "bond[0]"}}}},
                   {"motion", {{"t_end", 0.5}}}});
    const json& passage = summary.at("passages").at(0);
    EXPECT_NEAR(passage.at("energy_lost").get<double>(), held, 1e-9) << law;
    const double at_start = law.at("law") == "fene" ? -0.5 * 3.0 * 4.0 * std::log(1.0 - 0.25) : 0.0;
    const double speed = std::sqrt(16.0 - 2.0 * (held - at_start));
    EXPECT_NEAR(summary.at("final").at("velocities")[1][0].get<double>(), speed, 1e-9) << law;
    EXPECT_NEAR(summary.at("final").at("positions")[1][0].get<double>(),
                1.4 + speed * (0.5 - passage.at("t").get<double>()), 1e-9)
        << law;
    EXPECT_NEAR(summary.at("energy").at("drift_relative").get<double>(), 0.0, 1e-9) << summary.at("energy");
  }
}

/// Supports hold no energy, wherever they hang and however they move: 0.5 m/s here, 2 kg at a height of 3.
TEST(BreaksTest, ASupportThatIsLetGoHeldNone) {
  const json summary = run_scene(json::parse(R"json({
    "points": {"positions": [[0,0,3], [1,0,3]], "masses": [2, 1]},
    "supports": [{"name": "hook", "points": [0], "motion": {"formula": ["0", "0", "0.5*t"]}}],
    "constraints": [{"kind": "rod", "pairs": [[0, 1]]}], "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}],
    "events": [{"when": "t > 0.1", "do": "release", "of": "hook"}], "motion": {"t_end": 0.2, "start": "project"}})json"));
  EXPECT_EQ(summary.at("passages")[0].at("energy_lost"), 0.0);
  EXPECT_NEAR(summary.at("energy").at("drift_relative").get<double>(), 0.0, 1e-9) << summary.at("energy");
}

/// The event that stops is named as the reason, whichever others are told at its instant, also where a frame is due.
TEST(BreaksTest, TheEventThatStopsIsNamedAmongSeveral) {
  for (const double every : {0.0, 0.1, 0.05}) {
    std::string said;
    json scene = json::parse(R"json({
      "points": {"positions": [[0,0,0]]}, "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}],
      "events": [{"name": "end", "when": "t > 0.1", "do": "stop"}, {"name": "seen", "when": "t > 0.1"}],
      "motion": {"t_end": 0.3}})json");
    if (every > 0.0) scene["motion"]["output_every"] = every;
    const json summary = run_scene(scene, 0, &said);
    EXPECT_TRUE(contains(said, "where the event \"end\" stops the run")) << said;
    EXPECT_EQ(summary.at("passages").size(), 2U);
    EXPECT_EQ(summary.at("t_reached"), 0.1) << every;
  }
}

/// Each frame shows the state behind the events at its time, the first one too: half of the spring is gone at t = 0,
/// the other half at t = 0.1, and so are the energies and tensions of the frames at these times.
TEST(BreaksTest, FramesAreThoseBehindTheEventsAtTheirTime) {
  const Folder folder;
  write_text(folder / "s.json", R"json({
    "tanor_scene": 1, "points": {"positions": [[0,0,0], [1,0,0], [0,1,0]]}, "supports": [{"points": [0]}],
    "forces": [{"name": "s", "kind": "spring", "pairs": [[0,1], [0,2]], "stiffness": 2, "rest_length": 0}],
    "events": [{"when": "t > -1", "do": "break", "of": "s[0]"}, {"when": "t > 0.1", "do": "break", "of": "s[1]"}],
    "observe": ["potential()", "tension(s)"], "motion": {"t_end": 0.2, "output_every": 0.1}})json");

  const Ended ended = run_program(folder, {"run", "s.json", "--out", "o"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  std::istringstream table(read_text(folder / "o/observables.csv"));
  std::vector<std::string> lines;
  for (std::string line; std::getline(table, line);) lines.push_back(line);
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_EQ(lines[1], "0,1,,2");
  EXPECT_TRUE(lines[2].starts_with("0.1,0,,")) << lines[2];
  EXPECT_TRUE(lines[2].ends_with(",")) << lines[2];
}

/// An event that stops at the start leaves one frame.
TEST(BreaksTest, AnEventMayStopAtTheStart) {
  std::string said;
  const json summary = run_scene(json::parse(R"json({
    "points": {"positions": [[0,0,0]]}, "events": [{"name": "end", "when": "t > -1", "do": "stop"}],
    "motion": {"t_end": 0.3}})json"),
                                 0, &said);
  EXPECT_TRUE(contains(said, "where the event \"end\" stops the run")) << said;
  EXPECT_EQ(summary.at("t_reached"), 0.0);
}

/// The rest is said to be singular by the run itself.
TEST(BreaksTest, ARestThatPrestressHoldsGoesOn) {
  std::string said;
  const json summary = run_scene(json::parse(R"json({
    "points": {"positions": [[0,0,0], [2,0,0], [1.3,0.4,0.8], [0.9,-0.7,0.9], [1,0,0]]},
    "supports": [{"points": [0, 1, 2, 3]}],
    "constraints": [{"name": "links", "kind": "rod", "pairs": [[0,4], [4,1], [4,2], [4,3]]}],
    "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}],
    "events": [{"when": "t > 0.1", "do": "break", "of": "links[2]"}, {"when": "t > 0.1", "do": "break", "of": "links[3]"}],
    "motion": {"t_end": 0.3}})json"),
                                 0, &said);
  EXPECT_TRUE(contains(said, "held rigid by prestress")) << said;
  EXPECT_EQ(summary.at("t_reached"), 0.3);
}

/// A bead of 2 kg at x = 1 + 0.5 t on a level rail, and a rope over two pulleys with 1 kg and 3 kg. Rods pull at both
/// their ends, so that their forces have neither sum nor moment.
TEST(BreaksTest, MomentsOfGuidesPulleysAndRods) {
  const json summary = run_scene(json::parse(R"json({
    "points": {"positions": [[1,0,0], [0,0,-1], [1,0,-1], [5,0,0], [5,0,2]], "masses": [2, 1, 3, 1, 1],
               "velocities": [[0.5,0,0], [0,0,0], [0,0,0], [0,0,0], [3,0,0]]},
    "supports": [{"name": "pivot", "points": [3]}],
    "constraints": [{"name": "rail", "kind": "line", "points": [0], "origin": [0,0,0], "direction": [1,0,0]},
                    {"name": "rope", "kind": "pulley", "pairs": [[1, 2]], "a": [0,0,0], "b": [1,0,0]},
                    {"name": "rod", "kind": "rod", "pairs": [[3, 4]]}],
    "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}],
    "observe": ["moment(rail, y)", "moment(rail, [0,-2,0], [1,0,0])", "moment(rail, y, 0)", "moment(rope, y)",
                "moment(rope, y, [1,0,0])", "moment(rod, y, [3,1,1])", "force(rod).norm", "tension(rod)"],
    "motion": {"t_end": 0.2}})json"));
  const double weight = 2.0 * fall, x = 1.1, rope = 1.5 * fall;
  std::vector<double> wanted{-weight * x, weight * (x - 1.0), 0.0, -rope, rope, 0.0, 0.0};
  const json& observed = summary.at("observables");
  for (std::size_t k = 0; k < wanted.size(); ++k)
    EXPECT_NEAR(observed[k].at("values")[0].get<double>(), wanted[k], 1e-9) << observed[k];
  EXPECT_LT(observed[7].at("values")[0].get<double>(), -1.0) << "the rod pushes";
}

}  // namespace
}  // namespace tanor::cli
