#include <ostream>

#include <tanor/build_info.hpp>
#include <tanor/version.hpp>

#include "cli/program.hpp"

namespace tanor::cli {
namespace {

struct WrongUsage {
  Words arguments;
  std::string part;  ///< what the complaint says
};
void PrintTo(const WrongUsage& usage, std::ostream* stream) {
  for (const std::string& argument : usage.arguments) *stream << argument << ' ';
}

class WrongUsageTest : public testing::TestWithParam<WrongUsage> {};

TEST_P(WrongUsageTest, IsOneLineThatNamesTheWord) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.1)"));

  const std::string line = complaint(folder, GetParam().arguments);

  EXPECT_TRUE(contains(line, GetParam().part)) << line;
}

INSTANTIATE_TEST_SUITE_P(
    CommandLine, WrongUsageTest,
    testing::Values(
        WrongUsage{{}, "a command is required"}, WrongUsage{{"fly"}, "fly"}, WrongUsage{{"run"}, "SCENE is required"},
        WrongUsage{{"run", "s.json", "--fast"}, "--fast"}, WrongUsage{{"run", "s.json", "t.json"}, "t.json"},
        WrongUsage{{"run", "s.json", "--step"}, "--step"},
        WrongUsage{{"run", "s.json", "--step", "0"}, "--step: must be a finite number > 0, not '0'"},
        WrongUsage{{"run", "s.json", "--step", "-0.1"}, "--step: must be a finite number > 0, not '-0.1'"},
        WrongUsage{{"run", "s.json", "--step", "1e999"}, "--step: must be a finite number > 0, not '1e999'"},
        WrongUsage{{"run", "s.json", "--rtol", "-1"}, "--rtol: must be a finite number > 0, not '-1'"},
        WrongUsage{{"run", "s.json", "--atol", "nan"}, "--atol: must be a finite number > 0, not 'nan'"},
        WrongUsage{{"run", "s.json", "--t-end", "inf"}, "--t-end: must be a finite number, not 'inf'"},
        WrongUsage{{"run", "s.json", "--t-end", "1s"}, "--t-end: must be a finite number, not '1s'"},
        WrongUsage{{"run", "s.json", "--threads", "-2"},
                   "--threads: must be a whole number 0 (= all) to 1024, not '-2'"},
        WrongUsage{{"run", "s.json", "--threads", "1.5"}, "--threads: must be"},
        WrongUsage{{"run", "s.json", "--step", "0.1", "--rtol", "1e-6"}, "--step"},
        WrongUsage{{"run", "s.json", "--method", "magic"}, "--method: "},
        WrongUsage{{"run", "s.json", "--method", "taylr"}, "not 'taylr' (did you mean taylor?)"},
        WrongUsage{{"--hlep"}, "there is no option --hlep (did you mean --help?)"},
        WrongUsage{{"run", "s.json", "--method", "rk4"}, "s.json: /motion/step: "},
        WrongUsage{{"run", "s.json", "--out", ""}, "--out: must not be empty"},
        WrongUsage{{"solve", "s.json", "--resume"}, "--resume"}, WrongUsage{{"info", "s.json", "--out", "x"}, "--out"},
        WrongUsage{{"selftest", "s.json"}, "s.json"}));

TEST(HelpTest, VersionSaysWhichCodeUnderTheGplIsCalled) {
  const std::string out = run_program(Folder(), {"--version"}).out;

  EXPECT_EQ(out, describe(build_info()) + "\n");
  EXPECT_TRUE(contains(out, "tanor " TANOR_VERSION "\nQR: ")) << out;
  EXPECT_EQ(contains(out, "SuiteSparseQR (GPL-2.0-or-later)"), build_info().has_suitesparse_qr) << out;
  EXPECT_EQ(contains(out, "GPL modules that tanor does not call"), build_info().cholmod_has_gpl_modules) << out;
}

TEST(HelpTest, EndsWithoutAnError) {
  const Folder folder;
  for (const Words& arguments : {Words{"--help"}, Words{"run", "--help"}, Words{"solve", "-h"}, Words{"--version"}}) {
    const Ended ended = run_program(folder, arguments);

    EXPECT_EQ(ended.code, 0);
    EXPECT_EQ(ended.err, "");
    EXPECT_TRUE(contains(ended.out, "tanor")) << ended.out;
  }
  const std::string help = run_program(folder, {"run", "--help"}).out;
  EXPECT_TRUE(contains(help, "--rtol"));
  EXPECT_TRUE(contains(help, "fixed step, or the first one to try")) << help;
}

TEST(BadSceneTest, EveryCommandNamesTheFileAndThePlace) {
  const Folder folder;
  write_text(folder / "no_json.json", "{\n  \"tanor_scene\": 1,,\n}");
  write_text(folder / "unknown.json", R"({"tanor_scene": 1, "points": {"positions": [[0,0,0]]}, "colour": "red"})");
  write_text(folder / "torn.json", R"({"tanor_scene": 1, "points": {"positions": [[0,0,0], [1,0,0]]},
    "constraints": [{"name": "stick", "kind": "rod", "pairs": [[0,1]], "length": 2}], "motion": {"t_end": 1}})");

  for (const std::string command : {"run", "solve", "info"}) {
    EXPECT_TRUE(contains(complaint(folder, {command, "missing.json"}), "missing.json"));
    EXPECT_TRUE(contains(complaint(folder, {command, "no_json.json"}), "no_json.json: line 2"));
    EXPECT_TRUE(contains(complaint(folder, {command, "unknown.json"}), "unknown.json: /colour: "));
  }
  for (const std::string command : {"run", "solve"}) {
    const std::string line = complaint(folder, {command, "torn.json"});
    EXPECT_TRUE(line.starts_with("tanor: torn.json")) << line;
    EXPECT_TRUE(contains(line, "stick")) << line;
  }
}

/// One broken rule of docs/scene-format.md, and the line that `run` prints after "tanor: s.json: ".
struct BadScene {
  const char* rule;
  std::string scene, error;
};
void PrintTo(const BadScene& bad, std::ostream* stream) {
  *stream << bad.scene;
}

class BadSceneRuleTest : public testing::TestWithParam<BadScene> {};

TEST_P(BadSceneRuleTest, RunEndsWithOneLineAndWritesNothing) {
  const Folder folder;
  write_text(folder / "s.json", GetParam().scene);

  EXPECT_EQ(complaint(folder, {"run", "s.json"}), "tanor: s.json: " + GetParam().error + "\n");
}

/// Returns a scene of two points a metre apart that are to move for a second. `more` are other members.
std::string two_points(const std::string& more, const std::string& motion = "") {
  return R"({"tanor_scene": 1, "points": {"positions": [[0,0,0], [1,0,0]]}, "motion": {"t_end": 1)" +
         (motion.empty() ? "" : ", " + motion) + "}" + (more.empty() ? "" : ", " + more) + "}";
}
std::string constrained(const std::string& constraint) {
  return two_points(R"("constraints": [{)" + constraint + "}]");
}

// clang-format off
const BadScene bad_scenes[] = {
    {"UnknownKey", two_points(R"("constraints": [{"kind": "rod", "pairs": [[0,1]], "lenght": 1}])"),
     R"(/constraints/0/lenght: found the unknown key "lenght" (did you mean length?), wanted one of kind, name, pairs, length, offsets, side, restitution, breaks_at)"},
    {"DuplicateKey", two_points(R"("name": "a", "name": "b")"),
     R"(/name: found the key "name" twice, wanted once)"},
    {"WrongType", two_points(R"("name": 7)"), R"(/name: found number 7, wanted a string)"},
    {"PointOutOfRange", constrained(R"("kind": "rod", "pairs": [[0,2]])"),
     R"(/constraints/0/pairs/0/1: found number 2, wanted a whole number from 0 to 1)"},
    {"NotFinite", two_points("", R"("rtol": NaN)"), R"(/motion/rtol: found NaN, wanted a finite number)"},
    {"Overflows", two_points("", R"("rtol": 1e999)"), R"(/motion/rtol: found 1e999, wanted a finite number)"},
    {"MassIsZero", R"({"tanor_scene": 1, "points": {"positions": [[0,0,0]], "masses": 0}, "motion": {"t_end": 1}})",
     R"(/points/masses: mass 0 is not positive)"},
    {"StepIsZero", two_points("", R"("step": 0)"), R"(/motion/step: found number 0, wanted a number > 0)"},
    {"ToleranceIsNegative", two_points("", R"("atol": -1e-9)"),
     R"(/motion/atol: found number -1e-09, wanted a number > 0)"},
    {"NormalIsZero", constrained(R"("kind": "plane", "points": [0], "normal": [0,0,0])"), R"(/constraints/0/normal: )"
    R"(normal [0, 0, 0] is zero; it must have a direction)"},
    {"DirectionIsZero", constrained(R"("kind": "line", "points": [0], "origin": [0,0,0], "direction": [0,0,0])"),
     R"(/constraints/0/direction: direction [0, 0, 0] is zero; it must have a direction)"},
    {"PairNamesAPointTwice", constrained(R"("kind": "rod", "pairs": [[1,1]])"), R"(/constraints/0/pairs/0: [1, 1] )"
    R"(names point 1 twice; a rod joins two different points)"},
    {"NoPoints", R"({"tanor_scene": 1, "points": {"positions": []}, "motion": {"t_end": )"
    R"(1}})", R"(/points/positions: found a list of 0, wanted at least one point)"},
    {"FileCannotBeRead", two_points(R"("supports": [{"points": [0], "motion": {"table": "nowhere.csv"}}])"),
     R"(/supports/0/motion/table: nowhere.csv cannot be read: No such file or directory)"},
    {"EndIsZero", R"({"tanor_scene": 1, "points": {"positions": [[0,0,0]]}, "motion": {"t_end": 0}})",
     R"(/motion/t_end: found number 0, wanted a time after t_start = 0)"},
    {"TooManyThreads", two_points(R"("solver": {"threads": 100000})"),
     R"(/solver/threads: found number 100000, wanted a whole number from 0 to 1024)"},
    {"TooManySteps", two_points("", R"("step": 1e-17)"),
     R"(/motion/step: found number 1e-17, wanted at least t_end/1e+12 = 1e-12 (t_end = 1, 1e+12 steps at most))"},
    {"TooManyFrames", two_points("", R"("output_every": 1e-18)"),
     R"(/motion/output_every: found number 1e-18, wanted at least t_end/1e+06 = 1e-06 (t_end = 1, 1e+06 frames )"
     R"(at most))"},
};
// clang-format on

INSTANTIATE_TEST_SUITE_P(Contract, BadSceneRuleTest, testing::ValuesIn(bad_scenes),
                         [](const testing::TestParamInfo<BadScene>& bad) { return std::string(bad.param.rule); });

TEST(BadSceneTest, AFileThatCannotBeReadIsNamed) {
  const Folder folder;

  EXPECT_EQ(complaint(folder, {"run", "nowhere.json"}),
            "tanor: nowhere.json cannot be read: No such file or directory\n");
  write_text(folder / "s.json", R"({"tanor_scene": 1, "import": {"file": "far.data", "get": "fetch melt"}})");
  EXPECT_EQ(complaint(folder, {"info", "s.json"}),
            "tanor: s.json: /import/file: far.data is not there; fetch melt gets it\n");
}

TEST(BadSceneTest, AStepOfTheCommandLineHasTheSameLimit) {
  const Folder folder;
  write_text(folder / "s.json", two_points(""));

  for (const std::string command : {"run", "error-time"}) {
    EXPECT_EQ(complaint(folder, {command, "s.json", "--step", "1e-300"}),
              "tanor: --step: found number 1e-300, wanted at least t_end/1e+12 = 1e-12 (t_end = 1, 1e+12 steps at "
              "most)\n");
  }
}

TEST(BadSceneTest, ARunNeedsItsEnd) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(""));

  for (const std::string command : {"run", "error-time"}) {
    EXPECT_EQ(complaint(folder, {command, "s.json"}),
              "tanor: s.json: /motion/t_end: is missing; give it there or with --t-end (s)\n");
  }
  EXPECT_EQ(run_program(folder, {"run", "s.json", "--t-end", "0.1", "--quiet"}).code, 0);
}

TEST(MachineFailureTest, IsNamedWithItsReason) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.1)"));
  write_text(folder / "file", "");

  EXPECT_EQ(complaint(folder, {"run", "s.json", "--out", "file/x"}, 4),
            "tanor: cannot write file/x: Not a directory\n");
  EXPECT_EQ(complaint(folder, {"solve", "s.json", "--out", "nowhere/x.json"}, 4),
            "tanor: cannot write nowhere/x.json.part: No such file or directory\n");
  const Ended ended = Program(folder, {"solve", "s.json"}, "/dev/full").wait();
  EXPECT_EQ(ended.code, 4);
  EXPECT_EQ(ended.err, "tanor: cannot write standard output: No space left on device\n");
}

}  // namespace
}  // namespace tanor::cli
