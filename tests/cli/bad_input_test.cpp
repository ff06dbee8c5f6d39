#include <ostream>

#include "cli/program.hpp"

namespace tanor::cli {
namespace {

struct WrongUsage {
  Words arguments;
  std::string part;  ///< of the complaint
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
        WrongUsage{{}, "subcommand is required"}, WrongUsage{{"fly"}, "fly"}, WrongUsage{{"run"}, "SCENE is required"},
        WrongUsage{{"run", "s.json", "--fast"}, "--fast"}, WrongUsage{{"run", "s.json", "t.json"}, "t.json"},
        WrongUsage{{"run", "s.json", "--step"}, "--step"},
        WrongUsage{{"run", "s.json", "--step", "0"}, "--step: must be a finite number > 0, not '0'"},
        WrongUsage{{"run", "s.json", "--step", "-0.1"}, "--step: must be a finite number > 0, not '-0.1'"},
        WrongUsage{{"run", "s.json", "--step", "1e999"}, "--step: must be a finite number > 0, not '1e999'"},
        WrongUsage{{"run", "s.json", "--rtol", "-1"}, "--rtol: must be a finite number > 0, not '-1'"},
        WrongUsage{{"run", "s.json", "--atol", "nan"}, "--atol: must be a finite number > 0, not 'nan'"},
        WrongUsage{{"run", "s.json", "--t-end", "inf"}, "--t-end: must be a finite number > 0, not 'inf'"},
        WrongUsage{{"run", "s.json", "--t-end", "1s"}, "--t-end: must be a finite number > 0, not '1s'"},
        WrongUsage{{"run", "s.json", "--threads", "-2"},
                   "--threads: must be a whole number 0 (= all) to 1024, not '-2'"},
        WrongUsage{{"run", "s.json", "--threads", "1.5"}, "--threads: must be"},
        WrongUsage{{"run", "s.json", "--step", "0.1", "--rtol", "1e-6"}, "--step"},
        WrongUsage{{"run", "s.json", "--method", "magic"}, "--method: "},
        WrongUsage{{"run", "s.json", "--method", "rk4"}, "s.json: /motion/step: "},
        WrongUsage{{"run", "s.json", "--out", ""}, "--out: must not be empty"},
        WrongUsage{{"solve", "s.json", "--quiet"}, "--quiet"}, WrongUsage{{"info", "s.json", "--out", "x"}, "--out"}));

INSTANTIATE_TEST_SUITE_P(MissingCommands, WrongUsageTest,
                         testing::Values(WrongUsage{{"forces", "s.json", "--motion", "m.csv"},
                                                    "'forces' is not in version"},
                                         WrongUsage{{"check", "s.json"}, "'check' is not in version"},
                                         WrongUsage{{"selftest"}, "'selftest' is not in version"}));

TEST(HelpTest, IsNoError) {
  const Folder folder;
  for (const Words& arguments : {Words{"--help"}, Words{"run", "--help"}, Words{"solve", "-h"}, Words{"--version"}}) {
    const Ended ended = run_program(folder, arguments);

    EXPECT_EQ(ended.code, 0);
    EXPECT_EQ(ended.err, "");
    EXPECT_TRUE(contains(ended.out, "tanor")) << ended.out;
  }
  EXPECT_TRUE(contains(run_program(folder, {"run", "--help"}).out, "--rtol"));
  EXPECT_FALSE(contains(run_program(folder, {"--help"}).out, "selftest"));
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

TEST(BadSceneTest, ARunNeedsItsEnd) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(""));

  EXPECT_TRUE(contains(complaint(folder, {"run", "s.json"}), "s.json: /motion/t_end: is missing"));
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
