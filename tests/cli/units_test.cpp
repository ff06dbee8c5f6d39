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
  EXPECT_FALSE(std::regex_search(text.substr(0, text.find("\nt,x0")), std::regex("[0-9]{12}"))) << text;
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

/// A scene and a command that fail or warn, and what they say in SI units.
struct Reason {
  std::string keys;
  Words words;
  int code;
  std::string said;
};

const Reason reasons[] = {
    {R"("points": {"positions": [[0, 0, 0], [0.1, 0, 0], [0.2, 0, 0]]}, "supports": [{"points": [0, 2]}],
        "constraints": [{"name": "links", "kind": "rod", "pairs": [[0, 1], [1, 2]], "length": [0.5, 0.05]}],
        "motion": {"t_end": 1, "start": "project"})",
     {"run", "s.json"},
     3,
     "links[0] is 0.5 m long at t = 0, but links[1] and the supports let its ends be 0.25 m apart at most"},
    {R"("points": {"positions": [[0, 0, 0]]}, "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}])",
     {"modes", "s.json"},
     2,
     "nothing balances 9.81 N at point 0 (0, 0, 0), where at most 9.81e-06 N, 1e-06 of the largest force, is allowed"},
    {R"("points": {"positions": [[0, 0, 0]], "masses": 2}, "forces": [{"kind": "gravity", "acceleration": [0, 0, -1]}])",
     {"equilibrium", "s.json"},
     3,
     "gravity pulls the free island 0 (of point 0) along [0, 0, -1] without end: 2 N that nothing balances"},
    {R"("points": {"positions": [[0, 0, 0], [5e-10, 0, 0]]}, "supports": [{"points": [0]}],
        "constraints": [{"kind": "rod", "pairs": [[0, 1]]}], "motion": {"atol": 1e-10, "t_end": 1e-5})",
     {"run", "s.json"},
     0,
     "the absolute tolerance, 1e-10 m, is 0.2 of the size of what moves, 5e-10 m; left out"},
    {R"("points": {"positions": [[0, 0, 0], [1, 0, 0]], "velocities": [[0, 0, 0], [0, 0, 3]]}, "supports": [{"points": [0]}],
        "coordinates": [{"kind": "circle", "points": [1], "center": [0, 0, 0], "normal": [0, 0, 1]}],
        "motion": {"t_end": 1})",
     {"run", "s.json"},
     2,
     "the nearest lies 3 m/s (the velocity scale is 1) away"}};

/// Reasons that the library gives have the letters of the scene, too, and none where it has none.
TEST(UnitsTest, ReasonsHaveTheLettersOfTheScene) {
  const auto say = [](const Reason& reason, const std::string& units) {
    const Folder folder;
    write_text(folder / "s.json", "{\"tanor_scene\": 1, " + units + reason.keys + "}");
    const Ended ended = run_program(folder, reason.words);
    EXPECT_EQ(ended.code, reason.code) << ended.err;
    return ended.out + ended.err;
  };
  for (const Reason& reason : reasons) {
    const std::string si = say(reason, "\"units\": \"si\", ");
    EXPECT_TRUE(contains(si, reason.said)) << si;

    const std::string none = say(reason, "");
    EXPECT_TRUE(contains(none, std::regex_replace(reason.said, std::regex("(\\d) (m/s|m|N)\\b"), "$1"))) << none;
    EXPECT_EQ(find_letters(std::regex_replace(none, std::regex("wall time.*"), "")), "");
  }
}

}  // namespace
}  // namespace tanor::cli
