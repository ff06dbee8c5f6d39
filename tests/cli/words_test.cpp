#include <cctype>
#include <regex>

#include <tanor/motion.hpp>

#include "cli/shell.hpp"
#include "report/loglog_plot.hpp"
#include "report/shared_parts.hpp"

namespace tanor::cli {
namespace {

/// Returns true if a text has the word nan or inf, in any spelling, that is no part of a longer word.
bool names_no_number(const std::string& text) {
  std::string word;
  for (const char c : text + " ") {
    if (std::isalnum(static_cast<unsigned char>(c)) || c == '_') {
      word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      continue;
    }
    if (word == "nan" || word == "inf" || word == "infinity") return true;
    word.clear();
  }
  return false;
}

/// Expects words in every file that is a text.
void expect_words(const std::filesystem::path& folder) {
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::string ending = entry.path().extension().string();
    if (!entry.is_regular_file() || ending == ".png" || ending == ".npy" || ending == ".vtp") continue;
    if (entry.path().filename() == "checkpoint") continue;
    EXPECT_FALSE(names_no_number(read_text(entry.path()))) << entry.path() << ":\n" << read_text(entry.path());
  }
}

// For a bead in the middle of its sphere no direction leads out.
TEST(WordsTest, AStartWithoutAGradientIsToldInWords) {
  const Folder folder;
  for (const std::string start : {"check", "project"}) {
    for (const std::string certificate : {"final", "always"}) {
      write_text(folder / "s.json", R"({"tanor_scene": 1, "name": "middle", "points": {"positions": [[0,0,0], [1,0,0]]},
        "constraints": [{"kind": "sphere", "points": [0], "center": [0,0,0], "radius": 1}],
        "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}],
        "motion": {"t_end": 1, "start": ")" +
                                        start + R"("}, "solver": {"certificate": ")" + certificate + R"("}})");
      for (const Words& words : {Words{"run", "s.json"}, Words{"check", "s.json"}, Words{"solve", "s.json"}}) {
        const Ended ended = run_program(folder, words);
        EXPECT_EQ(ended.code, start == "check" ? 2 : 3) << words[0] << ended.err;
        EXPECT_FALSE(names_no_number(ended.out + ended.err)) << words[0] << ended.out << ended.err;
      }
      expect_words(folder.path());
    }
  }
}

TEST(WordsTest, ACertificateWithoutAnAnswerPrintsNoNan) {
  System system;
  system.positions = {0.0, 0.0, 0.0};
  system.masses = {1.0};
  system.constraints = {Spheres{.name = "ball", .points = {0}, .radius = {1.0}}};
  Simulation simulation(system, {.start = StartMode::Project});
  ASSERT_FALSE(simulation.outcome().ok());

  const std::string line = simulation.certify().line();

  EXPECT_TRUE(line.starts_with("not certified: ")) << line;
  EXPECT_FALSE(names_no_number(line)) << line;
}

TEST(WordsTest, ThePageCountsAndShowsNoRounding) {
  const Folder folder;
  write_text(folder / "s.json", R"json({"tanor_scene": 1, "units": "real", "points": {
      "positions": [[0,0,0], [1,0,0], [2,0,0], [5,0,0], [5,0,-1]],
      "velocities": [[0,0,0], [0,0,0], [0,0,0], [0,0,0], [1e-4,0,0]]},
    "supports": [{"points": [0, 2]}, {"name": "hook", "points": [3]}],
    "constraints": [{"kind": "rod", "pairs": [[0, 1], [1, 2]]}, {"name": "line", "kind": "rod", "pairs": [[3, 4]]}],
    "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}],
    "observe": ["tension(line)", "load(hook).x"], "motion": {"t_end": 0.5}})json");
  const Ended ended = run_program(folder, {"run", "s.json", "--out", "o"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  for (const char* const part :
       {"  tension(line)  9.81 kcal/mol/angstrom\n", "least 0 kcal/mol/angstrom at t = 0 x 48.88821 fs, largest",
        "1 point without motion, held rigid", "0.5 of 0.5 x 48.88821 fs\n"})
    EXPECT_TRUE(contains(ended.out, part)) << part << "\n" << ended.out;
  EXPECT_TRUE(contains(ended.err, "t = 0.5 x 48.88821 fs reached in 1 step of")) << ended.err;

  const FrictionSummary friction{.solves = 1, .iterations_mean = 1.0};
  EXPECT_TRUE(report::describe_friction(friction).starts_with("1 iteration an instant"));
}

TEST(WordsTest, EqualNumbersOfMembersAreToldOnce) {
  const Folder folder;
  write_text(folder / "s.json", R"json({"tanor_scene": 1, "units": "si", "points": {
      "positions": [[0,0,0], [0,0,-1], [2,0,0], [2,0,-1]]}, "supports": [{"points": [0, 2]}],
    "constraints": [{"name": "links", "kind": "rod", "pairs": [[0, 1], [2, 3]]}],
    "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}],
    "observe": ["each tension(links)"], "motion": {"t_end": 0.1}})json");
  const Ended ended = run_program(folder, {"run", "s.json", "--out", "o"});
  EXPECT_TRUE(contains(ended.out, "each tension(links)  2 numbers, all 9.81 N\n")) << ended.out << ended.err;
}

TEST(WordsTest, PartsOfALoadBesideWhichTheyAreRoundingAreZero) {
  const Folder folder;
  const Ended ended = run_program(
      folder, {"run", (std::filesystem::path(TANOR_DOCS) / "../examples/cable.json").string(), "--out", "o"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_TRUE(std::regex_search(ended.out, std::regex("load\\(walls\\)\\.x, \\.y +0 N\n"))) << ended.out;
  EXPECT_TRUE(std::regex_search(ended.out, std::regex("load\\(walls\\)\\.z +\\S+ N; least"))) << ended.out;
}

TEST(WordsTest, AReferenceOfHugeOrTinyNumbersLeavesTheTablesReadable) {
  const Folder folder;
  write_text(folder / "s.json", R"({"tanor_scene": 1, "name": "fall", "points": {"positions": [[0,0,0]]},
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}], "motion": {"t_end": 1}})");
  for (const std::string r : {"[1e308, -1e308, 1e308]", "[1.5e308, 1.7e308, 1e308]", "[1e-308, 0, -4.905]"}) {
    write_text(folder / "end.json", R"({"trajectory": [{"t": 1, "r": )" + r + "}]}");

    const Ended ended =
        run_program(folder, {"error-time", "s.json", "--methods", "rk4,dopri5", "--reference", "end.json"});

    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_FALSE(names_no_number(ended.out + ended.err)) << r << ended.out << ended.err;
    expect_words(folder / "s.out");
    EXPECT_TRUE(read_text(folder / "s.out/error_time.svg").ends_with("</svg>\n"));
    EXPECT_LT(read_text(folder / "s.out/error_time.svg").size(), 20000u) << "no line for each of 600 decades";
  }
}

TEST(WordsTest, APlotShowsThePointsThatHaveAPlace) {
  const double none = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
  const std::string svg = report::make_loglog_plot(
      {"title",
       "x",
       "y",
       {{"good", {{1.0, 1e-3}, {2.0, 1.7e308}, {5e-324, 1.0}}},
        {"bad", {{none, 1.0}, {1.0, none}, {infinite, 1.0}, {1.0, infinite}, {0.0, 1.0}, {1.0, -1.0}}}}});

  EXPECT_FALSE(names_no_number(svg)) << svg;
  std::size_t circles = 0;
  for (std::size_t at = svg.find("<circle"); at != std::string::npos; at = svg.find("<circle", at + 1)) ++circles;
  EXPECT_EQ(circles, 3u);
}

}  // namespace
}  // namespace tanor::cli
