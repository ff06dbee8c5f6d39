#include "cli/program.hpp"

#include <csignal>

#include <chrono>
#include <cmath>
#include <sstream>
#include <thread>

#include <fmt/format.h>

namespace tanor::cli {
namespace {

/// Reads a column of error_time.csv.
std::vector<double> read_column(const std::filesystem::path& csv, const std::string& name) {
  std::istringstream lines(read_text(csv));
  std::vector<double> column;
  std::size_t place = 0;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream fields(line);
    std::vector<std::string> words;
    for (std::string word; std::getline(fields, word, ',');) words.push_back(word);
    if (line.starts_with("method,")) {
      place = static_cast<std::size_t>(std::find(words.begin(), words.end(), name) - words.begin());
    } else {
      column.push_back(std::stod(words.at(place)));
    }
  }
  return column;
}

// On a chain of 10 rods rk4 with a 32nd of the step was worse than the finest dopri5 run.
TEST(ErrorTimeTest, ReferencesAreBetterThanTheRows) {
  const Folder folder;
  write_text(folder / "s.json", R"({"tanor_scene": 1, "name": "a/b",
    "generate": {"kind": "chain", "count": 10, "anchored": true},
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}], "motion": {"t_end": 1}})");

  const Ended ended = run_program(folder, {"error-time", "s.json", "--methods", "rk4,dopri5", "--quiet"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(list_names(folder.path()), (Words{"s.json", "s.out"})) << "a folder as run has it";
  const std::vector<double> errors = read_column(folder / "s.out/error_time.csv", "error");
  const std::vector<double> uncertainties = read_column(folder / "s.out/error_time.csv", "reference_error");
  ASSERT_EQ(errors.size(), 8u);
  for (std::size_t k = 0; k < errors.size(); ++k) EXPECT_GT(errors[k], 3.0 * uncertainties[k]) << ended.out;
  EXPECT_FALSE(contains(ended.out.substr(0, ended.out.find("compared with")), "<=")) << ended.out;
  EXPECT_TRUE(contains(ended.out, "whose own error is <= ")) << ended.out;
  EXPECT_TRUE(contains(ended.out, "rk4 is compared with taylor with rtol")) << ended.out;
  // Each step has four stages with one factor each, and positions are projected once more.
  const std::vector<double> steps = read_column(folder / "s.out/error_time.csv", "steps");
  const std::vector<double> factorizations = read_column(folder / "s.out/error_time.csv", "factorizations");
  EXPECT_GE(factorizations[0], 4.0 * steps[0]) << ended.out;
}

// Lengths are scaled by 1e-9 and times by their root. The motion is the same, and as exact relative to its own size.
TEST(ErrorTimeTest, ToleranceIsThatOfAPendulumOfHalfANanometre) {
  const Folder folder;
  write_text(folder / "s.json", R"({"tanor_scene": 1, "name": "s", "points": {"positions": [[0,0,0], [5e-10,0,0]]},
    "supports": [{"points": [0], "motion": "fixed"}], "constraints": [{"kind": "rod", "pairs": [[0, 1]]}],
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}], "motion": {"t_end": 3e-5}})");

  const Ended ended = run_program(folder, {"error-time", "s.json", "--methods", "dop853,radau5", "--quiet"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  const std::vector<double> errors = read_column(folder / "s.out/error_time.csv", "error");
  ASSERT_EQ(errors.size(), 8u);
  for (std::size_t level = 0; level < 4; ++level) {
    const double rtol = 1e-3 * std::pow(0.01, level);
    EXPECT_LT(errors[level], 5e-10 * 10.0 * rtol) << "dop853 with rtol " << rtol;
    EXPECT_LT(errors[4 + level], 5e-10 * 10.0 * rtol) << "radau5 with rtol " << rtol;
  }
}

// A bead falls 4.905 m, and a file has it 0.25 m to the side.
TEST(ErrorTimeTest, AReferenceFileReplacesTheReferenceRun) {
  const Folder folder;
  write_text(folder / "s.json", R"({"tanor_scene": 1, "name": "s", "points": {"positions": [[0,0,0], [1,1,1]]},
    "supports": [{"points": [1], "motion": "fixed"}],
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}], "motion": {"t_end": 1}})");
  write_text(folder / "end.txt", "# by hand\n0.5\n0 0 -1.22625\n1\n0.25 0 -4.905 0 0 -9.81\n");
  write_text(folder / "end.json", R"({"dim": 3, "trajectory": [{"t": "1", "r": ["0", "-0.5", "-4.905"]}]})");

  const auto error_of = [&](const std::string& file) {
    const Ended ended =
        run_program(folder, {"error-time", "s.json", "--methods", "dopri5", "--reference", file, "--quiet"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_TRUE(contains(ended.out, "dopri5 is compared with " + file + "\n")) << ended.out;
    return read_column(folder / "s.out/error_time.csv", "error").back();
  };
  EXPECT_NEAR(error_of("end.txt"), 0.25, 1e-12);
  EXPECT_NEAR(error_of("end.json"), 0.5, 1e-12);

  const std::string line = complaint(
      folder, {"error-time", "s.json", "--t-end", "2", "--methods", "dopri5", "--reference", "end.txt", "--quiet"}, 2);
  EXPECT_TRUE(contains(line, "end.txt: has no state at t_end = 2; its times are 0.5, 1")) << line;
}

constexpr const char* falling_chain = R"({"tanor_scene": 1, "name": "s",
    "generate": {"kind": "chain", "count": 3, "anchored": true},
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}], "motion": {"t_end": 0.5}})";

TEST(ErrorTimeTest, EachMethodIsMeasuredOnceAndNeverByItself) {
  const Folder folder;
  write_text(folder / "s.json", falling_chain);

  const Ended ended =
      run_program(folder, {"error-time", "s.json", "--methods", "taylor,dop853,rk4,taylor,auto", "--quiet"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_TRUE(contains(ended.out, "taylor is compared with dop853 with rtol")) << ended.out;
  EXPECT_TRUE(contains(ended.out, "dop853 is compared with taylor with rtol")) << ended.out;
  EXPECT_TRUE(contains(ended.out, "rk4 is compared with taylor with rtol")) << ended.out;
  EXPECT_EQ(count(ended.out, " is compared with "), 3U) << ended.out;
  EXPECT_EQ(read_column(folder / "s.out/error_time.csv", "error").size(), 12U) << ended.out;
  EXPECT_EQ(count(read_text(folder / "s.out/error_time.svg"), "<polyline "), 3U);
}

// A spring swings thousands of times while its beads fall.
TEST(ErrorTimeTest, StiffScenesHaveAnImplicitMethodToo) {
  const Folder folder;
  write_text(folder / "s.json", R"({"tanor_scene": 1, "name": "s",
    "points": {"positions": [[0,0,0], [1,0,0], [2,0,0]], "masses": 0.1},
    "supports": [{"points": [0], "motion": "fixed"}],
    "constraints": [{"name": "rod", "kind": "rod", "pairs": [[0,1]]}],
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]},
               {"name": "wire", "kind": "spring", "pairs": [[1,2]], "stiffness": 1e8}], "motion": {"t_end": 0.005}})");

  const Ended ended = run_program(folder, {"error-time", "s.json", "--quiet"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_TRUE(contains(ended.out, "radau5 is compared with taylor")) << ended.out;
}

// Two rods of 1 m hang between supports, one of which moves away. They are taut at 0.5 s and have no position after it.
TEST(ErrorTimeTest, ARunThatDoesNotArriveHasNoError) {
  const Folder folder;
  write_text(folder / "s.json", R"({"tanor_scene": 1, "name": "s",
    "points": {"positions": [[0,0,0], [0.75,0,-0.6614378277661477], [1.5,0,0]],
               "velocities": [[0,0,0], [0.5,0,0.5669467095138409], [1,0,0]]},
    "supports": [{"points": [0], "motion": "fixed"}, {"points": [2], "motion": {"formula": ["t","0","0"]}}],
    "constraints": [{"name": "rods", "kind": "rod", "pairs": [[0,1], [1,2]]},
                    {"name": "sheet", "kind": "plane", "points": [1], "normal": [0,1,0]}], "motion": {"t_end": 1}})");
  write_text(folder / "end.txt", "1\n0 0 0\n1.25 0 0\n2.5 0 0\n");

  const Ended ended =
      run_program(folder, {"error-time", "s.json", "--methods", "dopri5", "--reference", "end.txt", "--quiet"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  std::istringstream lines(read_text(folder / "s.out/error_time.csv"));
  std::string line;
  std::getline(lines, line);
  for (int row = 0; row < 4; ++row) {
    std::getline(lines, line);
    std::istringstream fields(line);
    std::string error, trouble;
    for (int k = 0; k < 7; ++k) std::getline(fields, error, ',');
    for (int k = 0; k < 5; ++k) std::getline(fields, trouble, ',');
    EXPECT_EQ(error, "") << line;
    EXPECT_GT(trouble.size(), 2U) << line;
  }
}

TEST(ErrorTimeTest, AFolderThatCannotBeIsToldBeforeAnythingIsMeasured) {
  const Folder folder;
  write_text(folder / "s.json", falling_chain);

  const Ended ended = run_program(folder, {"error-time", "s.json", "--methods", "rk4", "--out", "/dev/null/x"});

  EXPECT_NE(ended.code, 0);
  EXPECT_TRUE(contains(ended.err, "cannot write /dev/null/x")) << ended.err;
  EXPECT_FALSE(contains(ended.err, "rk4 with")) << ended.err;
}

// With coordinates alone there is nothing to project onto and no series in time.
TEST(ErrorTimeTest, MethodsThatASceneRefusesAreLeftOutWithTheReason) {
  const Folder folder;
  write_text(folder / "s.json", R"({"tanor_scene": 1, "name": "s", "points": {"positions": [[1,0,0]]},
    "coordinates": [{"kind": "circle", "points": [0], "center": [0,0,0], "normal": [0,0,1], "radius": 1}],
    "forces": [{"kind": "gravity", "acceleration": [0, -9.81, 0]}], "motion": {"t_end": 1}})");

  const Ended ended = run_program(folder, {"error-time", "s.json", "--quiet"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_TRUE(contains(ended.out, "left out: rattle projects onto constraints")) << ended.out;
  EXPECT_TRUE(contains(ended.out, "left out: taylor: the motion in coordinates")) << ended.out;
  EXPECT_TRUE(contains(ended.out, "rk4 is compared with dop853")) << ended.out;
  EXPECT_TRUE(contains(ended.out, "dop853 is compared with dopri5")) << ended.out;
  EXPECT_TRUE(contains(read_text(folder / "s.out/error_time.md"), "| dop853 | rtol 1e-03 |"));
  EXPECT_EQ(read_column(folder / "s.out/error_time.csv", "wall_s").size(), 12u);

  const std::string line = complaint(folder, {"error-time", "s.json", "--methods", "taylor", "--quiet"}, 2);
  EXPECT_TRUE(contains(line, "taylor: the motion in coordinates")) << line;
}

// A point lies on two parallel planes.
TEST(ErrorTimeTest, WithoutAnAnswerThereIsNoTable) {
  const Folder folder;
  write_text(folder / "s.json", R"({"tanor_scene": 1, "points": {"positions": [[0,0,0]]},
    "constraints": [{"name": "floor", "kind": "plane", "points": [0], "normal": [0,0,1]},
                    {"name": "sheet", "kind": "plane", "points": [0], "normal": [0,0,2], "offset": 0.0005}],
    "motion": {"t_end": 1}})");

  const std::string line = complaint(folder, {"error-time", "s.json", "--quiet"}, 3);

  EXPECT_TRUE(line.starts_with("tanor: s.json: ")) << line;
  EXPECT_TRUE(contains(line, "contradicts")) << line;
}

TEST(ErrorTimeTest, ASignalKeepsTheRowsThatAreThere) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 1e6, "step": 1e-3)"));

  Program program(folder, {"error-time", "s.json", "--methods", "rk4", "--out", "o"});
  while (!std::filesystem::exists(folder / "o")) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  kill(program.process(), SIGTERM);
  const Ended ended = program.wait();

  EXPECT_EQ(ended.code, 143) << ended.err;
  EXPECT_EQ(ended.err, "tanor: s.json: SIGTERM came; rows are missing\n") << "in the first run";
  EXPECT_FALSE(std::filesystem::exists(folder / "o")) << "no row was there";
}

// A bead falls from the horizontal on a rod of 1 m, which breaks at 20 N = 3 m g sin(a), and then flies. The time of
// the fall is the integral of da/sqrt(2 g sin(a)), by Simpson's rule in the root of a.
TEST(ErrorTimeTest, ARodBreaksInEachRun) {
  const Folder folder;
  write_text(folder / "s.json", R"json({"tanor_scene": 1, "points": {"positions": [[0,0,0], [1,0,0]], "masses": 1},
    "supports": [{"points": [0]}], "constraints": [{"name": "rod", "kind": "rod", "pairs": [[0, 1]]}],
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
    "events": [{"when": "tension(rod) > 20", "do": "break"}], "motion": {"t_end": 1, "step": 0.01}})json");
  const double g = 9.81, sine = 20.0 / (3.0 * g), a = std::asin(sine), width = std::sqrt(a) / 2000;
  double time = 0.0;
  for (int k = 0; k <= 2000; ++k) {
    const double u = k * width, weight = k % 2 == 1 ? 4.0 : k == 0 || k == 2000 ? 1.0 : 2.0;
    time += weight * width / 3.0 * 2.0 * (k == 0 ? 1.0 : u / std::sqrt(std::sin(u * u))) / std::sqrt(2.0 * g);
  }
  const double flight = 1.0 - time, speed = std::sqrt(2.0 * g * sine), x = std::cos(a) - speed * sine * flight,
               z = -sine - speed * std::cos(a) * flight - 0.5 * g * flight * flight;
  write_text(folder / "end.txt", fmt::format("# by hand\n1\n{} 0 {} 0 0 0\n", x, z));

  const Ended ended = run_program(
      folder, {"error-time", "s.json", "--methods", "rk4,dopri5", "--reference", "end.txt", "--quiet", "--out", "o"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  const std::vector<double> errors = read_column(folder / "o/error_time.csv", "error");
  ASSERT_EQ(errors.size(), 8u);
  EXPECT_LT(errors[3], 1e-6) << ended.out;
  EXPECT_LT(errors[7], 1e-7) << ended.out;
}

TEST(ErrorTimeTest, ASceneThatAnEventStopsIsRefused) {
  const Folder folder;
  write_text(folder / "s.json", R"json({"tanor_scene": 1, "points": {"positions": [[0,0,0]]},
    "events": [{"when": "t > 2", "do": "report"}, {"when": "position(0).x > 2", "do": "stop"}], "motion": {"t_end": 1}
})json");

  EXPECT_EQ(complaint(folder, {"error-time", "s.json", "--quiet"}, 2),
            "tanor: s.json: /events/1/do: error-time compares states at t_end, and \"stop\" ends each method's run at "
            "an instant of its own\n");
}

/// Returns the method of the first row of the errors that the page of a run shows.
std::string read_report(const std::filesystem::path& page) {
  const std::string text = read_text(page), mark = "id=\"data\">";
  const std::size_t begin = text.find(mark) + mark.size();
  return nlohmann::json::parse(text.substr(begin, text.find("</script>", begin) - begin))
      .at("error_time")
      .at(0)
      .at("method");
}

TEST(ErrorTimeTest, ThePageOfARunNamesTheSceneOfItsErrors) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.1)"));
  write_text(folder / "other.json", R"({"tanor_scene": 1, "name": "a bead", "points": {"positions": [[0,0,0]]},
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}], "motion": {"t_end": 0.1}})");
  ASSERT_EQ(run_program(folder, {"error-time", "s.json", "--methods", "rk4", "--out", "o", "--quiet"}).code, 0);

  const Ended first = run_program(folder, {"run", "s.json", "--report", "--out", "o", "--t-end", "0.2"});
  ASSERT_EQ(first.code, 0) << first.err;
  if (contains(first.err, "there is no report.html")) GTEST_SKIP() << "this program was built without node";
  EXPECT_EQ(read_report(folder / "o/report.html"), "rk4");
  ASSERT_EQ(run_program(folder, {"run", "other.json", "--report", "--out", "o"}).code, 0);
  EXPECT_EQ(read_report(folder / "o/report.html"), "rk4 (pendulum)");
  ASSERT_EQ(run_program(folder, {"error-time", "other.json", "--methods", "rk4", "--out", "o", "--quiet"}).code, 0);
  ASSERT_EQ(run_program(folder, {"run", "s.json", "--report", "--out", "o"}).code, 0);
  EXPECT_EQ(read_report(folder / "o/report.html"), "rk4 (a bead)");
}

}  // namespace
}  // namespace tanor::cli
