/// \file Runs that reach the end of an energy's range return exit code 3, with the tuple, its trouble and the time.

#include <ostream>

#include "cli/program.hpp"

namespace tanor::cli {
namespace {

struct End {
  const char* name;
  std::string path, force;  // x and y of point 2 as formulas of t
  std::string tuple;        // as the program names it
  double time;

  friend std::ostream& operator<<(std::ostream& out, const End& end) { return out << end.name; }
};

/// Returns a scene in which points 0, 1 and 3 stand and point 2 is led.
std::string led(const End& end) {
  return R"({"tanor_scene": 1, "points": {"positions": [[-1,0,0],[0,0,0],[1,1,0],[-1,0,1]], "masses": 1},
    "supports": [{"points": [0, 1, 3]}],
    "constraints": [{"kind": "line", "name": "way", "points": [2], "direction": [0,0,1], "origin": {"formula": [)" +
         end.path + R"(, "0"]}},
      {"kind": "plane", "name": "floor", "points": [2], "normal": [0,0,1]}],
    "forces": [)" +
         end.force + R"(], "motion": {"start": "project", "t_end": 2, "output_every": 0.1}})";
}

class EnergyEnds : public testing::TestWithParam<End> {};

TEST_P(EnergyEnds, AreExitCode3WithTheTupleAndTheTime) {
  for (const char* method : {"auto", "dopri5", "radau5"}) {
    const Folder folder;
    write_text(folder / "s.json", led(GetParam()));

    const Ended ended = run_program(folder, {"run", "s.json", "--out", "o", "--quiet", "--method", method});

    EXPECT_EQ(ended.code, 3) << method << ": " << ended.err;
    EXPECT_NE(ended.err.find(GetParam().tuple), std::string::npos) << method << ": " << ended.err;
    const nlohmann::json summary = read_json(folder / "o/summary.json");
    EXPECT_NEAR(summary["t_reached"].get<double>(), GetParam().time, 0.05) << method << ": " << ended.err;
    EXPECT_EQ(ended.err.find("nan"), std::string::npos) << ended.err;
  }
}

// clang-format off
const End ends[] = {
    {"ABondAtItsLimit", R"("1 + t", "0")", R"({"kind": "bond", "law": "fene", "pairs": [[1,2]], "stiffness": 5, "limit": 1.5})",
     "bond0: [1, 2]: the distance 1.5", 0.5},
    {"AnAngleThatBecomesStraight", R"json("1", "max(1 - t, 0)")json", R"({"kind": "bending", "law": "harmonic", "triples": [[0,1,2]], "stiffness": 1, "rest": 2})",
     "bending0: [0, 1, 2]: its angle is straight", 1.0},
    {"ATorsionInLine", R"json("1", "max(1 - t, 0)")json", R"({"kind": "torsion", "law": "opls", "quadruples": [[3,0,1,2]], "coefficients": [1,1,1,1]})",
     "torsion0: [3, 0, 1, 2]: its last three points are on a straight line", 1.0},
    {"AnEnergyOfAUser", R"("1", "1 - t")", R"json({"kind": "potential", "points": [[1,2]], "energy": "log(y2 - y1)"})json",
     "potential0: [1, 2]: the energy or its gradient is not finite", 1.0},
};
// clang-format on
INSTANTIATE_TEST_SUITE_P(Scenes, EnergyEnds, testing::ValuesIn(ends),
                         [](const auto& instance) { return std::string(instance.param.name); });

/// Expects that each command warns once on stderr, and repeats the warning in `left_out`.
void expect_warning_of_each_command(const Folder& folder, const std::string& warning) {
  for (const Words& words : std::vector<Words>{{"run", "s.json", "--out", "run", "--quiet"},
                                               {"solve", "s.json", "--out", "solve.json"},
                                               {"info", "s.json"},
                                               {"equilibrium", "s.json", "--out", "equilibrium"},
                                               {"modes", "s.json", "--out", "modes"}}) {
    const Ended ended = run_program(folder, words);

    ASSERT_EQ(ended.code, 0) << words[0] << ended.err;
    EXPECT_EQ(count(ended.err, "warning: " + warning), 1u) << words[0] << ended.err;
    const std::string told = words[0] == "info"    ? ended.out
                             : words[0] == "solve" ? read_text(folder / "solve.json")
                                                   : read_text(folder / words[0] / "summary.json");
    EXPECT_NE(told.find(warning), std::string::npos) << words[0];
    if (words[0] == "run") {
      EXPECT_TRUE(contains(read_text(folder / "run/report.txt"), "left out")) << words[0];
      EXPECT_TRUE(contains(read_text(folder / "run/report.txt"), warning)) << words[0];
    }
  }
}

TEST(EnergiesTest, ABondAlongARodIsWarnedOfByEachCommand) {
  const Folder folder;
  write_text(folder / "s.json", R"({
    "tanor_scene": 1, "points": {"positions": [[0,0,0], [0,0,-1]], "masses": 1}, "supports": [{"points": [0]}],
    "constraints": [{"kind": "rod", "pairs": [[0,1]]}], "motion": {"t_end": 0.01},
    "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]},
               {"name": "bb", "kind": "bond", "law": "harmonic", "pairs": [[1,0]], "stiffness": 3, "rest_length": 0.8}]})");
  expect_warning_of_each_command(folder, "bb: the energy of 1 bond along rods is constant");
}

/// The file has two atoms on a bond at rest, and a section of pairs.
TEST(EnergiesTest, ASectionThatIsNotReadIsWarnedOfByEachCommand) {
  const Folder folder;
  write_text(folder / "a.data",
             "a molecule\n\n2 atoms\n1 bonds\n1 atom types\n1 bond types\n\nMasses\n\n1 1.0\n\n"
             "Bond Coeffs # harmonic\n\n1 3.0 1.0\n\nPair Coeffs # lj/cut\n\n1 0.1 3.0\n\n"
             "Atoms # molecular\n\n1 1 1 0 0 0\n2 1 1 1 0 0\n\nBonds\n\n1 1 1 2\n");
  write_text(folder / "s.json", R"({"tanor_scene": 1, "import": {"file": "a.data", "bonds": "energies"},
    "supports": [{"points": [0]}], "equilibrium": {"accept": "any"}, "motion": {"t_end": 0.01}})");
  expect_warning_of_each_command(folder, "import: the section Pair Coeffs of a.data is not read");
}

}  // namespace
}  // namespace tanor::cli
