/// An unknown word of a scene is told with the one that may be meant.

#include "base/suggestion.hpp"
#include "scene/reading.hpp"

namespace tanor::scene {
using namespace detail;
namespace {

TEST(Suggestion, IsTheNearestWordIfItIsNear) {
  const std::vector<std::string> words{"rod", "plane", "sphere", "line"};
  EXPECT_EQ(suggest("rods", words), " (did you mean rod?)");
  EXPECT_EQ(suggest("shpere", words), " (did you mean sphere?)");
  EXPECT_EQ(suggest("brake", {"report", "stop", "break", "release"}), " (did you mean break?)");
  EXPECT_EQ(suggest("plan", words), " (did you mean plane?)");
  EXPECT_EQ(suggest("cylinder", words), "");
  EXPECT_EQ(suggest("rod", {}), "");
  EXPECT_EQ(suggest("wind", {"bond"}), "") << "half of it is wrong";
  EXPECT_EQ(suggest("a", {"b"}), "");
  EXPECT_EQ(suggest("acc", {"kind", "acceleration"}), " (did you mean acceleration?)");
  EXPECT_EQ(suggest("velocity", {"positions", "velocities"}), " (did you mean velocities?)");
  EXPECT_EQ(suggest("out", {"output_every", "output_points"}), "") << "several begin so";
  EXPECT_EQ(suggest("t", {"type"}), "");
  EXPECT_EQ(suggest("tEnd", {"t_start", "t_end"}), " (did you mean t_end?)");
  EXPECT_EQ(suggest("time_step", {"step", "max_step"}), " (did you mean step?)");
  EXPECT_EQ(suggest("mu", {"at", "coefficient", "static_coefficient"}), " (did you mean coefficient?)");
  EXPECT_EQ(suggest("mu", {"at"}), "");
  EXPECT_EQ(suggest(std::string(1000000, 'x'), {std::string(1000, 'x')}), "") << "no name is as long";
}

TEST(Suggestion, StandsBehindUnknownKeysKindsAndChoices) {
  const auto told = [](const std::string& more) {
    const std::string error = error_of(three_points(more));
    return error.substr(0, error.find(", wanted"));
  };
  EXPECT_EQ(told(R"("motoin": {})"), "scene.json: /motoin: found the unknown key \"motoin\" (did you mean motion?)");
  EXPECT_EQ(told(R"("motion": {"tend": 1})"),
            "scene.json: /motion/tend: found the unknown key \"tend\" (did you mean t_end?)");
  EXPECT_EQ(told(R"("motion": {"time_step": 1})"),
            "scene.json: /motion/time_step: found the unknown key \"time_step\" (did you mean step?)");
  EXPECT_EQ(told(R"("friction": [{"kind": "coulomb", "mu": 0.5}])"),
            "scene.json: /friction/0/mu: found the unknown key \"mu\" (did you mean coefficient?)");
  EXPECT_EQ(told(R"("forces": [{"kind": "gravity", "acc": [0, 0, 1]}])"),
            "scene.json: /forces/0/acc: found the unknown key \"acc\" (did you mean acceleration?)");
  const std::string mass = error_of(R"({"tanor_scene": 1, "points": {"positions": [[0, 0, 0]], "mass": 1}})");
  EXPECT_NE(mass.find("unknown key \"mass\" (did you mean masses?)"), std::string::npos) << mass;
  EXPECT_EQ(told(R"("constraints": [{"kind": "rod", "pair": [[0, 1]]}])"),
            "scene.json: /constraints/0/pair: found the unknown key \"pair\" (did you mean pairs?)");
  EXPECT_EQ(told(R"("constraints": [{"kind": "shpere"}])"),
            "scene.json: /constraints/0/kind: found string \"shpere\" (did you mean sphere?)");
  EXPECT_EQ(told(R"("forces": [{"kind": "gravty"}])"),
            "scene.json: /forces/0/kind: found string \"gravty\" (did you mean gravity?)");
  EXPECT_EQ(told(R"("motion": {"method": "taylr"})"),
            "scene.json: /motion/method: found string \"taylr\" (did you mean taylor?)");
  EXPECT_EQ(told(R"("solver": {"form": "norml"})"),
            "scene.json: /solver/form: found string \"norml\" (did you mean normal?)");
  EXPECT_EQ(told(R"("motion": {"method": "leap"})"), "scene.json: /motion/method: found string \"leap\"");
}

TEST(Suggestion, IsThePartOfTheSceneThatHasTheKey) {
  const auto told = [](const std::string& more) {
    const std::string error = error_of(three_points(more));
    return error.substr(0, error.find(", wanted"));
  };
  EXPECT_EQ(told(R"("constraints": [{"kind": "rod", "pairs": [[0, 1]], "one_sided": "at_most"}])"),
            "scene.json: /constraints/0/one_sided: found the unknown key \"one_sided\" (a key of /equilibrium)");
  EXPECT_EQ(told(R"("t_end": 1)"), "scene.json: /t_end: found the unknown key \"t_end\" (a key of /motion)");
  EXPECT_EQ(told(R"("motion": {"threads": 1})"),
            "scene.json: /motion/threads: found the unknown key \"threads\" (a key of /solver)");
  EXPECT_EQ(told(R"("solver": {"supports": []})"),
            "scene.json: /solver/supports: found the unknown key \"supports\" (a key of the scene itself)");
  EXPECT_EQ(told(R"("xyz": 1)"), "scene.json: /xyz: found the unknown key \"xyz\"");
}

}  // namespace
}  // namespace tanor::scene
