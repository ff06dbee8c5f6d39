#include "cli/program.hpp"

#include <sstream>

namespace tanor::cli {
namespace {

/// Columns of error_time.csv.
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
TEST(ErrorTimeTest, JudgesAreBetterThanTheJudged) {
  const Folder folder;
  write_text(folder / "s.json", R"({"tanor_scene": 1, "name": "a/b",
    "generate": {"kind": "chain", "count": 10, "anchored": true},
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}], "motion": {"t_end": 1}})");

  const Ended ended = run_program(folder, {"error-time", "s.json", "--methods", "rk4,dopri5", "--quiet"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(list_names(folder.path()), (Words{"a_b.out", "s.json"})) << "a folder as run has it";
  const std::vector<double> errors = read_column(folder / "a_b.out/error_time.csv", "error_m");
  const std::vector<double> uncertainties = read_column(folder / "a_b.out/error_time.csv", "judge_error_m");
  ASSERT_EQ(errors.size(), 8u);
  for (std::size_t k = 0; k < errors.size(); ++k) EXPECT_GT(errors[k], 3.0 * uncertainties[k]) << ended.out;
  EXPECT_FALSE(contains(ended.out.substr(0, ended.out.find("judged")), "<=")) << ended.out;
  EXPECT_TRUE(contains(ended.out, "judge's own error <= ")) << ended.out;
}

// A point on two parallel planes.
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

}  // namespace
}  // namespace tanor::cli
