#include "cli/program.hpp"

namespace tanor::cli {
namespace {

using nlohmann::json;

/// Returns three parallel cranks and a bar of three rods in a line, one too many (case 18a), and `extra` constraints.
std::string parallelogram(const std::string& extra = "") {
  return R"({"tanor_scene": 1, "points": {"positions": [[0,0,0], [1,0,0], [2.5,0,0],
      [0.644217687237691, -0.7648421872844885, 0], [1.644217687237691, -0.7648421872844885, 0],
      [3.144217687237691, -0.7648421872844885, 0]], "masses": [1, 1, 1, 1, 2, 3]},
    "supports": [{"points": [0, 1, 2]}],
    "constraints": [{"name": "cranks", "kind": "rod", "pairs": [[0,3], [1,4], [2,5]]},
                    {"name": "bar", "kind": "rod", "pairs": [[3,4], [4,5], [3,5]]})" +
         extra + R"(], "forces": [{"kind": "gravity", "acceleration": [0, -9.81, 0]}],
    "motion": {"method": "dopri5", "rtol": 1e-12, "atol": 1e-12, "t_end": 5}})";
}

TEST(CheckTest, RedundantConstraintsAreNamedAndNoFault) {
  const Folder folder;
  write_text(folder / "s.json", parallelogram());

  const Ended ended = run_program(folder, {"check", "s.json"});

  EXPECT_EQ(ended.code, 0) << ended.err;
  for (const char* line : {"rank:                    5 of 6 equations\n", "degrees of freedom:      4\n",
                           "redundant:               bar[0] depends on ", "certificate:             certified to "}) {
    EXPECT_TRUE(contains(ended.out, line)) << line << " is missing in\n" << ended.out;
  }
  EXPECT_EQ(list_names(folder.path()), Words{"s.json"});
}

TEST(CheckTest, ContradictoryLengthsAreNamed) {
  const Folder folder;
  write_text(folder / "s.json",
             parallelogram(R"(, {"name": "brace", "kind": "rod", "pairs": [[3,4]], "length": 1.0001})"));

  const Ended ended = run_program(folder, {"check", "s.json"});

  EXPECT_EQ(ended.code, 3);
  EXPECT_TRUE(contains(ended.err, " contradicts ") && contains(ended.err, "brace[0]")) << ended.err;
}

TEST(CheckTest, ContradictoryMovingLengthsAreNamed) {
  const Folder folder;
  write_text(folder / "s.json", parallelogram(R"(, {"name": "brace", "kind": "rod", "pairs": [[3,4]],
    "length": {"formula": "1 + 0.1*t^2"}})"));

  const Ended ended = run_program(folder, {"check", "s.json"});

  EXPECT_EQ(ended.code, 3);
  EXPECT_TRUE(contains(ended.err, " contradicts ") && contains(ended.err, "brace[0]")) << ended.err;
}

TEST(CheckTest, ARunOfRedundantConstraintsSaysSoAndArrives) {
  const Folder folder;
  write_text(folder / "s.json", parallelogram());

  const Ended ended = run_program(folder, {"run", "s.json", "--out", "o"});

  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_TRUE(contains(ended.err, "1 of 6 equations is redundant: bar[0] depends on ")) << ended.err;
  const json summary = read_json(folder / "o/summary.json");
  EXPECT_EQ(summary["rank"], 5);
  EXPECT_EQ(summary["degrees_of_freedom"], 4);
  EXPECT_EQ(summary["redundant"].size(), 1u);
  EXPECT_EQ(summary["rank_changes"]["count"], 0) << "redundant from the start on is no change";
  EXPECT_EQ(summary["rank_changes"]["start"], 5);
  // These are the digits of case 18a at t = 5.
  EXPECT_NEAR(summary["final"]["positions"][3][0], -0.5703965679671275, 1e-10);
  EXPECT_NEAR(summary["final"]["accelerations"][3][1], -2.2807536888136015, 1e-8);
}

TEST(CheckTest, ASolveFlagsTheMultipliersThatAreNotUnique) {
  const Folder folder;
  write_text(folder / "s.json", parallelogram());

  const json solution = json::parse(run_program(folder, {"solve", "s.json"}).out);

  EXPECT_EQ(solution["multipliers_unique"], json::array({true, true, true, false, false, false}));
  EXPECT_NEAR(solution["multipliers"][2], -22.50930557178245, 1e-11);
  EXPECT_NEAR(solution["multipliers"][3], 0.0, 1e-11);
}

}  // namespace
}  // namespace tanor::cli
