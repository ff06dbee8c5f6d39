#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "cli/program.hpp"

namespace tanor::cli {
namespace {

using nlohmann::json;

/// One of three ropes is slack, and each has its own number in all that follows from the scene at rest, whose modes do
/// not feel it: a bead under two ropes swings with g/l across their plane.
TEST(SlackMembersTest, KeepTheirNumbersInAllThatFollowsFromRest) {
  const Folder folder;
  json scene = json::parse(R"json({
    "tanor_scene": 1, "points": {"positions": [[-3,0,0], [0,0,0], [3,0,0], [0,0,-4]], "masses": 1},
    "supports": [{"points": [0, 1, 2]}], "forces": [{"kind": "gravity", "acceleration": [0,0,-10]}],
    "constraints": [{"name": "wires", "kind": "rod", "pairs": [[0,3],[1,3],[2,3]], "length": [5, 4.5, 5], "side": "at_most"}],
    "observe": ["tension(wires)"], "motion": {"t_end": 0.1}, "solver": {"threads": 1}})json");
  const auto tensions = [&](const std::string& name) {
    std::vector<double> found;
    const json summary = json::parse(read_text(folder / name / "summary.json"));
    for (const json& each : summary["observables"][0]["values"]) found.push_back(each);
    return found;
  };
  const std::vector<double> wanted{6.25, 0.0, 6.25};

  const Ended ended = find_at_rest(folder, scene);
  const Ended again = run_program(folder, {"equilibrium", "at_rest/equilibrium.json", "--out", "again"});
  const Ended run = run_program(folder, {"run", "at_rest/equilibrium.json", "--out", "run"});
  const Ended swung = run_program(folder, {"modes", "at_rest/equilibrium.json", "--count", "1", "--out", "modes"});

  for (const auto& [way, name] : {std::pair{&ended, "at_rest"}, {&again, "again"}, {&run, "run"}, {&swung, "modes"}}) {
    ASSERT_EQ(way->code, 0) << name << way->err;
    const std::vector<double> found = tensions(name);
    ASSERT_EQ(found.size(), wanted.size()) << name;
    for (std::size_t k = 0; k < wanted.size(); ++k) EXPECT_NEAR(found[k], wanted[k], 1e-9) << name << k;
  }
  const json summary = json::parse(read_text(folder / "modes/summary.json"));
  EXPECT_NEAR(summary["modes"]["omega"][0].get<double>(), std::sqrt(10.0 / 4.0), 1e-9);
  EXPECT_EQ(summary["equations"], 3);
}

}  // namespace
}  // namespace tanor::cli
