/// Results have the letters of the scene's units, and none where the scene has none.

#include <regex>

#include "cli/program.hpp"

namespace tanor::cli {
namespace {

/// Returns all that the commands say about a hanging bead, but for the times of the clock.
std::string tell_all(const std::string& units) {
  const Folder folder;
  write_text(folder / "s.json",
             R"({"tanor_scene": 1, "points": {"positions": [[0, 0, 0], [0, 0, -1]]}, "supports": [{"points": [0]}],
                 "constraints": [{"name": "links", "kind": "rod", "pairs": [[0, 1]]}],
                 "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
                 "motion": {"method": "rk4", "step": 0.1, "t_end": 0.3, "trajectory": ["vtp", "csv"]})" +
                 (units.empty() ? "" : R"(, "units": ")" + units + "\"") + "}");
  write_text(folder / "m.csv", "0,0,0,0,0,0,-1\n1,0,0,0,0,0,-1\n2,0,0,0,0,0,-1\n");
  std::string all;
  for (const Words& words : {Words{"run", "s.json"},
                             {"equilibrium", "s.json"},
                             {"modes", "s.json"},
                             {"check", "s.json"},
                             {"info", "s.json"},
                             {"forces", "s.json", "--motion", "m.csv"},
                             {"picture", "s.out", "--time", "0.15"},
                             {"picture", "s.out", "--time", "9"},
                             {"error-time", "s.json", "--methods", "rk4", "--t-end", "0.1", "--quiet"}}) {
    const Ended ended = run_program(folder, words);
    EXPECT_EQ(ended.code, words.back() == "9" ? 2 : 0) << words[0] << ended.err;
    all += ended.out + ended.err;
  }
  return std::regex_replace(all, std::regex("wall time.*|wall, s"), "") + read_text(folder / "s.out/trajectory.csv");
}

std::string find_letters(const std::string& text) {
  std::smatch found;
  return std::regex_search(text, found, std::regex(R"(.*([0-9] (N|m|s|J|rad|m/s)\b|rad/|1/s|, (N|m)\b).*)"))
             ? found.str()
             : "";
}

TEST(UnitsTest, ASceneWithoutUnitsHasNoLetters) {
  const std::string text = tell_all("");
  EXPECT_EQ(find_letters(text), "");
  EXPECT_TRUE(contains(text, "t = 0.3 reached")) << text;
  EXPECT_TRUE(contains(text, "must be between 0 and 0.3, the frames")) << text;
}

TEST(UnitsTest, ResultsHaveTheLettersOfTheScene) {
  const std::string reduced = std::regex_replace(tell_all("lj"), std::regex("rad/tau"), "");
  EXPECT_EQ(find_letters(reduced), "");
  for (const char* const part :
       {"t = 0.3 tau reached", "the largest force is 9.81 epsilon/sigma)", "corrected by 0 sigma and 0 sigma/tau",
        "to t = 0.3 tau", "frames at 0 tau and 0.3 tau", "error, sigma"})
    EXPECT_TRUE(contains(reduced, part)) << part << "\n" << reduced;

  const std::string si = tell_all("si");
  for (const char* const part : {"t = 0.3 s reached", "the largest force is 9.81 N)", "rad/s",
                                 "corrected by 0 m and 0 m/s", "to t = 0.3 s", "frames at 0 s and 0.3 s", "error, m"})
    EXPECT_TRUE(contains(si, part)) << part << "\n" << si;
}

}  // namespace
}  // namespace tanor::cli
