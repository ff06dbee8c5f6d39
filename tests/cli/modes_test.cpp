#include <cmath>

#include "cli/program.hpp"
#include "report/npy.hpp"

namespace tanor::cli {
namespace {

using nlohmann::json;

/// Two beads below a support, at rest.
constexpr const char* hanging_scene = R"({
  "tanor_scene": 1, "name": "hanging",
  "points": {"positions": [[0,0,0], [0,-1,0], [0,-2,0]], "masses": 2},
  "supports": [{"points": [0]}],
  "constraints": [{"name": "rods", "kind": "rod", "pairs": [[0,1],[1,2]]}],
  "forces": [{"name": "weight", "kind": "gravity", "acceleration": [0,-9.81,0]}],
  "modes": {"count": 3}})";

std::string replaced(std::string text, const std::string& old, const std::string& with) {
  const std::size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return text.replace(at, old.size(), with);
}

Ended run_modes(const Folder& folder, const std::string& scene, Words more = {}) {
  write_text(folder / "s.json", scene);
  Words words{"modes", "s.json", "--out", "answer"};
  words.insert(words.end(), more.begin(), more.end());
  return run_program(folder, words);
}

TEST(ModesTest, WritesFrequenciesAndShapes) {
  const Folder folder;

  const Ended ended = run_modes(folder, hanging_scene);

  ASSERT_EQ(ended.code, 0) << ended.err;
  const json summary = read_json(folder / "answer/summary.json");
  EXPECT_EQ(summary.at("degrees_of_freedom"), 4);
  const json& modes = summary.at("modes");
  ASSERT_EQ(modes.at("omega").size(), 3u);
  // Each omega^2 = (g/l)(2 -+ sqrt 2) occurs twice.
  for (std::size_t k = 0; k < 3; ++k) {
    const double exact = std::sqrt(9.81 * (k < 2 ? 2.0 - std::sqrt(2.0) : 2.0 + std::sqrt(2.0)));
    EXPECT_NEAR(modes.at("omega")[k].get<double>(), exact, 1e-12 * exact);
    EXPECT_NEAR(modes.at("frequency_hz")[k].get<double>(), exact / (2.0 * std::acos(-1.0)), 1e-12 * exact);
  }
  EXPECT_LT(modes.at("residual_max").get<double>(), 1e-12);
  const std::string shapes = read_text(folder / "answer" / modes.at("shapes").get<std::string>());
  EXPECT_NE(shapes.find("'shape': (3, 3, 3)"), std::string::npos);
}

/// The message leads from positions that do not rest to those that do, and on; the folders have the name of the scene.
TEST(ModesTest, PositionsThatDoNotRestLeadToThoseThatDo) {
  const Folder folder;
  write_text(folder / "net.json", replaced(hanging_scene, "[0,-2,0]", "[1,-2,0]"));

  const std::string said = complaint(folder, {"modes", "net.json"});

  EXPECT_TRUE(contains(said,
                       "finds one: tanor equilibrium net.json, then tanor modes net.equilibrium.out/"
                       "equilibrium.json\n"))
      << said;
  ASSERT_EQ(run_program(folder, {"equilibrium", "net.json"}).code, 0);
  for (const Words& words : {Words{"modes", "net.equilibrium.out/equilibrium.json"},
                             {"run", "net.equilibrium.out/equilibrium.json", "--t-end", "0.1"}}) {
    const Ended ended = run_program(folder, words);
    EXPECT_EQ(ended.code, 0) << ended.err;
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "net.at_rest.modes.out/summary.json"));
  EXPECT_TRUE(std::filesystem::exists(folder / "net.at_rest.out/summary.json"));
}

TEST(ModesTest, CountOnTheCommandLineReplacesThatOfTheScene) {
  const Folder folder;

  ASSERT_EQ(run_modes(folder, hanging_scene, {"--count", "all"}).code, 0);

  EXPECT_EQ(read_json(folder / "answer/summary.json").at("modes").at("omega").size(), 4u);
}

TEST(ModesTest, DrawsEachModeForParaView) {
  const Folder folder;

  ASSERT_EQ(run_modes(folder, hanging_scene, {"--pictures"}).code, 0);

  EXPECT_EQ(list_names(folder / "answer/mode_3").size(), 24u);
  EXPECT_EQ(count(read_text(folder / "answer/mode_3.pvd"), "<DataSet"), 24u);
  EXPECT_FALSE(std::filesystem::exists(folder / "answer/mode_4.pvd"));
  const auto draw = [&](const Words& more) {
    Words words{"picture", "answer", "--size", "200x150", "--quiet"};
    words.insert(words.end(), more.begin(), more.end());
    const Ended ended = run_program(folder, words);
    return ended.code == 0 || contains(ended.err, "built without cairo") ? "" : ended.err;
  };
  EXPECT_EQ(draw({}), "");
  EXPECT_EQ(draw({"--mode", "1"}), "");
  EXPECT_EQ(draw({"--mode", "3"}), "");
  if (!std::filesystem::exists(folder / "answer/picture.png")) GTEST_SKIP() << "this program draws nothing";
  const std::string rest = read_text(folder / "answer/picture.png");
  EXPECT_NE(read_text(folder / "answer/mode_1.png"), rest);
  EXPECT_NE(read_text(folder / "answer/mode_3.png"), read_text(folder / "answer/mode_1.png"));
  const Ended beyond = run_program(folder, {"picture", "answer", "--mode", "4"});
  EXPECT_EQ(beyond.code, 2);
  EXPECT_TRUE(contains(beyond.err, "--mode: there is no mode 4 in answer; there are modes 1 to 3\n")) << beyond.err;
  ASSERT_EQ(run_modes(folder, hanging_scene, {}).code, 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "answer/mode_1.png")) << "of the modes before";
  EXPECT_TRUE(contains(draw({"--mode", "3"}),
                       "answer: there is no mode_3.pvd; tanor modes SCENE --pictures --out answer makes it"));
}

TEST(ModesTest, TellsHowMuchOfALoadBuckles) {
  const Folder folder;
  // One rod stands upright on a spring of 30 N/m, so that (m g/l) p = k.
  std::string scene = replaced(hanging_scene, "[[0,0,0], [0,-1,0], [0,-2,0]]", "[[0,0,0], [0,1,0]]");
  scene = replaced(scene, "[[0,1],[1,2]]", "[[0,1]]");
  scene = replaced(scene, "-9.81,0]}]",
                   R"json(-9.81,0]}, {"kind": "potential", "points": [[1]], "energy": "15*(x1^2+z1^2)"}])json");

  ASSERT_EQ(run_modes(folder, replaced(scene, R"("count": 3)", R"("buckling": "weight")")).code, 0);

  EXPECT_NEAR(read_json(folder / "answer/summary.json").at("buckling_load_factor").get<double>(), 30.0 / 19.62, 1e-12);
}

TEST(ModesTest, CountsInTheSingular) {
  const Folder folder;
  const auto said = [&](const std::string& scene) {
    const Ended ended = run_modes(folder, scene);
    return ended.out + ended.err;
  };
  const std::string damped = said(replaced(hanging_scene, R"("count": 3)", R"("count": 1, "damped": true)"));
  EXPECT_TRUE(contains(damped, "1 damped mode: omega")) << damped;
  // A rod that stands upright falls to one side, where no spring holds it.
  std::string upright = replaced(hanging_scene, "[[0,0,0], [0,-1,0], [0,-2,0]]", "[[0,0,0], [0,1,0]]");
  upright = replaced(replaced(upright, "[[0,1],[1,2]]", "[[0,1]]"), R"("count": 3)", R"("count": 1)");
  upright = replaced(upright, "-9.81,0]}]",
                     R"json(-9.81,0]}, {"kind": "potential", "points": [[1]], "energy": "15*x1^2"}])json");
  EXPECT_TRUE(contains(said(upright), "1 of 2 modes: omega = -")) << said(upright);
  EXPECT_TRUE(contains(said(upright), "; unstable: 1 grows (negative: growth rate)")) << said(upright);
  // Weight and spring cancel aside, to second order: nothing holds the rod, and nothing drives it.
  const std::string free = said(replaced(upright, "15*x1^2", "15*x1^2+0.5*19.62*z1^2"));
  EXPECT_TRUE(contains(free, "; 1 is 0, 0 of them rigid")) << free;
}

TEST(ModesTest, RefusesPositionsThatAreNoEquilibriumAndNamesTheWorstPoint) {
  const Folder folder;

  const Ended ended = run_modes(folder, replaced(hanging_scene, "[0,-2,0]", "[1,-1,0]"));

  EXPECT_EQ(ended.code, 2);
  EXPECT_EQ(count(ended.err, "\n"), 1u) << ended.err;
  EXPECT_NE(ended.err.find("no equilibrium"), std::string::npos) << ended.err;
  EXPECT_NE(ended.err.find("point 2"), std::string::npos) << ended.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "answer"));
}

TEST(ModesTest, WherePointsAreNotOnTheirConstraintsTheWorstIsNamed) {
  const Folder folder;
  write_text(folder / "s.json", R"({
    "tanor_scene": 1, "points": {"positions": [[0,0,0], [0,0,-1], [0,0,-2.1]], "masses": 1}, "supports": [{"points": [0]}],
    "constraints": [{"name": "links", "kind": "rod", "pairs": [[0,1],[1,2]], "length": 1}],
    "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}]})");

  const Ended ended = run_program(folder, {"modes", "s.json", "--out", "out"});

  EXPECT_EQ(ended.code, 2) << ended.err;
  EXPECT_NE(ended.err.find("they break links[1] by 0.1"), std::string::npos) << ended.err;
}

TEST(ModesTest, RefusesWrongValuesOfItsKeys) {
  const auto expect_refused = [](const std::string& modes, const std::string& pointer) {
    const Folder folder;
    const Ended ended = run_modes(folder, replaced(hanging_scene, R"({"count": 3})", modes));
    EXPECT_EQ(ended.code, 2) << modes;
    EXPECT_EQ(count(ended.err, "\n"), 1u) << ended.err;
    EXPECT_NE(ended.err.find("s.json: " + pointer + ": "), std::string::npos) << ended.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "answer"));
  };
  expect_refused(R"({"count": 0})", "/modes/count");
  expect_refused(R"({"count": 2.5})", "/modes/count");
  expect_refused(R"({"count": "many"})", "/modes/count");
  expect_refused(R"({"number": 3})", "/modes/number");
  expect_refused(R"({"damped": 1})", "/modes/damped");
  expect_refused(R"({"buckling": "wind"})", "/modes/buckling");
  expect_refused(R"({"buckling": ["weight", "wind"]})", "/modes/buckling/1");
  expect_refused(R"({"buckling": ["weight", "weight"]})", "/modes/buckling/1");
  expect_refused(R"([])", "/modes");
}

TEST(ModesTest, RefusesAForceWithoutAPotential) {
  const Folder folder;
  // The scene has a follower load across the chain, which vanishes when the chain hangs.
  const std::string scene =
      replaced(hanging_scene, "-9.81,0]}]", R"(-9.81,0]}, {"kind": "formula", "points": [2], "x": "z"}])");

  const Ended ended = run_modes(folder, scene);

  EXPECT_EQ(ended.code, 3) << ended.err;
  EXPECT_NE(ended.err.find("not conservative"), std::string::npos) << ended.err;
  EXPECT_TRUE(read_json(folder / "answer/summary.json").at("modes").is_null());
}

/// The modes are the roots of lambda^2 + (c/m) lambda + omega^2 = 0.
TEST(ModesTest, TellsHowDampedModesDecay) {
  const Folder folder;
  const std::string scene = replaced(replaced(hanging_scene, R"("count": 3)", R"("count": 4, "damped": true)"),
                                     "-9.81,0]}]", R"(-9.81,0]}, {"kind": "drag", "points": [1, 2], "linear": 0.8}])");

  const Ended ended = run_modes(folder, scene);

  ASSERT_EQ(ended.code, 0) << ended.err;
  const json modes = read_json(folder / "answer/summary.json").at("modes");
  ASSERT_EQ(modes.at("omega").size(), 4u);
  for (std::size_t k = 0; k < 4; ++k) {
    const double omega2 = 9.81 * (k < 2 ? 2.0 - std::sqrt(2.0) : 2.0 + std::sqrt(2.0));
    EXPECT_NEAR(modes.at("decay")[k].get<double>(), 0.2, 1e-12);
    EXPECT_NEAR(modes.at("omega")[k].get<double>(), std::sqrt(omega2 - 0.04), 1e-11);
  }
  const std::string shapes = read_text(folder / "answer" / modes.at("shapes_imaginary").get<std::string>());
  EXPECT_NE(shapes.find("'shape': (4, 3, 3)"), std::string::npos);

  ASSERT_EQ(run_modes(folder, hanging_scene).code, 0);
  EXPECT_FALSE(std::filesystem::exists(folder / "answer/shapes_imaginary.npy"));
}

TEST(ModesTest, RefusesMoreModesThanItFindsByItsPlace) {
  const Folder folder;
  const auto refusal = [&](const char* modes) {
    write_text(folder / "net.json", std::string(R"({
      "tanor_scene": 1, "generate": {"kind": "net", "columns": 20, "rows": 20, "spacing": 0.1, "mass": 0.1},
      "supports": [{"points": [0, 19]}], "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}], "modes": )") +
                                        modes + "}");
    EXPECT_EQ(run_program(folder, {"equilibrium", "net.json", "--out", "rest", "--quiet"}).code, 0);
    const Ended ended = run_program(folder, {"modes", "rest/equilibrium.json", "--out", "answer"});
    EXPECT_EQ(ended.code, 2) << modes;
    EXPECT_FALSE(std::filesystem::exists(folder / "answer"));
    return ended.err;
  };
  EXPECT_NE(refusal(R"({"count": "all"})").find("/modes/count"), std::string::npos);
  EXPECT_NE(refusal(R"({"count": 500})").find("/modes/count"), std::string::npos);
  EXPECT_NE(refusal(R"({"damped": true, "count": 500})").find("/modes/count"), std::string::npos);
}

TEST(ModesTest, RefusesFriction) {
  const Folder folder;
  const std::string scene =
      replaced(replaced(hanging_scene, "\"constraints\": [",
                        R"("constraints": [{"name": "wall", "kind": "plane", "points": [2], "normal": [0,0,1]}, )"),
               "\"modes\"", R"("friction": [{"kind": "coulomb", "at": "wall", "coefficient": 0.2}], "modes")");

  const Ended ended = run_modes(folder, scene);

  EXPECT_EQ(ended.code, 2);
  EXPECT_NE(ended.err.find("/friction/0"), std::string::npos) << ended.err;
}

TEST(ModesTest, PrintsDecayBesideOmegaOfDampedModes) {
  const Folder folder;
  const Ended ended = run_modes(folder, R"({
    "tanor_scene": 1, "points": {"positions": [[0,0,0], [0,0,-1]], "masses": 1}, "supports": [{"points": [0]}],
    "constraints": [{"kind": "rod", "pairs": [[0,1]]}],
    "forces": [{"kind": "gravity", "acceleration": [0,0,-9]}, {"kind": "drag", "points": [1], "linear": 10}],
    "modes": {"damped": true}})");

  // The roots of lambda^2 + 10 lambda + 9 = 0 are -1 and -9.
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_NE(ended.out.find("0 (decay 1)"), std::string::npos) << ended.out;
  EXPECT_NE(ended.out.find("0 (decay 9)"), std::string::npos) << ended.out;
}

TEST(ModesTest, SaysThatNoLoadBucklesAHangingChain) {
  const Folder folder;
  const Ended ended =
      run_modes(folder, replaced(hanging_scene, R"("modes": {"count": 3})", R"("modes": {"buckling": "weight"})"));

  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(ended.out.find("inf"), std::string::npos) << ended.out;
  EXPECT_NE(ended.out.find("buckles at no multiple of the load"), std::string::npos) << ended.out;
}

}  // namespace
}  // namespace tanor::cli
