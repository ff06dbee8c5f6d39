#include "cli/program.hpp"

namespace tanor::cli {
namespace {

using nlohmann::json;

/// Three rods between two supports, sagging.
const json sagging = json::parse(R"({
  "tanor_scene": 1, "units": "si",
  "points": {"positions": [[0,0,0], [0.7,0,-0.5], [1.5,0,-0.5], [2.2,0,0]], "masses": 2},
  "supports": [{"name": "hooks", "points": [0, 3]}],
  "constraints": [{"name": "rods", "kind": "rod", "pairs": [[0,1], [1,2], [2,3]], "length": 0.9}],
  "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}]})");

/// The observables stand at the head of the page, in the summary and in one row of a table, as for runs.
TEST(ObservedRestTest, OfEquilibriumHasItsTensionsAndLoads) {
  const Folder folder;

  const Ended plain = find_at_rest(folder, sagging);
  ASSERT_EQ(plain.code, 0) << plain.err;
  EXPECT_TRUE(contains(plain.out, "max tension(rods)  ")) << plain.out;
  EXPECT_TRUE(contains(read_text(folder / "at_rest/report.txt"), "load(hooks).z      -39.24 N")) << plain.out;

  json scene = sagging;
  scene["observe"] = {"load(hooks).z", "max tension(rods)", "kinetic()",
                      "potential()",   "temperature()",     "friction(1).x"};
  ASSERT_EQ(find_at_rest(folder, scene).code, 0);
  const json summary = read_json(folder / "at_rest/summary.json");
  const json& observed = summary.at("observables");
  ASSERT_EQ(observed.size(), 6U);
  EXPECT_EQ(observed[0].at("unit"), "N");
  EXPECT_NEAR(observed[0].at("values")[0].get<double>(), -4.0 * 9.81, 1e-9);
  double largest = 0.0;
  for (const json& lambda : summary.at("final").at("multipliers")) largest = std::max(largest, -lambda.get<double>());
  EXPECT_EQ(observed[1].at("values")[0], largest);
  EXPECT_EQ(observed[2].at("values")[0], 0.0);
  EXPECT_NEAR(observed[3].at("values")[0].get<double>(), summary["equilibrium"]["energy"].get<double>(), 1e-9);
  EXPECT_EQ(observed[4].at("values")[0], 0.0);
  EXPECT_EQ(observed[5].at("values")[0], 0.0);
  EXPECT_TRUE(
      read_text(folder / "at_rest/observables.csv").starts_with("t [s],load(hooks).z [N],max tension(rods) [N],"));
}

TEST(ObservedRestTest, OfModesHasNoVelocity) {
  const Folder folder;
  write_text(folder / "s.json", R"json({
    "tanor_scene": 1,
    "points": {"positions": [[0,0,0], [0,-1,0], [0,-2,0]], "masses": 2, "velocities": [[0,0,0], [1,0,0], [2,0,0]]},
    "supports": [{"points": [0]}],
    "constraints": [{"name": "rods", "kind": "rod", "pairs": [[0,1],[1,2]]}],
    "forces": [{"kind": "gravity", "acceleration": [0,-9.81,0]}], "observe": ["load(support0).y", "kinetic()"]
})json");

  const Ended ended = run_program(folder, {"modes", "s.json", "--out", "answer"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_TRUE(contains(ended.out, "load(support0).y  -39.24\n")) << ended.out;
  const json observed = read_json(folder / "answer/summary.json").at("observables");
  EXPECT_NEAR(observed[0].at("values")[0].get<double>(), -4.0 * 9.81, 1e-10);
  EXPECT_EQ(observed[1].at("values")[0], 0.0);
  EXPECT_EQ(read_text(folder / "answer/observables.csv").substr(0, 29), "t,load(support0).y,kinetic()\n");
}

}  // namespace
}  // namespace tanor::cli
