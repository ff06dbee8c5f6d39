/// `tanor picture` writes instants of a run as PNG files.

#include "cli/program.hpp"

namespace tanor::cli {
namespace {

using nlohmann::json;

const std::string swinging = R"({"tanor_scene": 1, "name": "swing",
  "points": {"positions": [[0, 0, 0], [1, 0, 0]]}, "supports": [{"points": [0]}],
  "constraints": [{"name": "rod", "kind": "rod", "pairs": [[0, 1]]}],
  "forces": [{"kind": "gravity", "acceleration": [0, -9.81, 0]}],
  "motion": {"t_end": 0.4, "output_every": 0.1}})";

/// Reads width and height from the head of a PNG file.
std::array<int, 2> read_size(const std::string& png) {
  EXPECT_TRUE(png.starts_with("\x89PNG\r\n\x1a\n"));
  const auto number = [&](std::size_t at) {
    int value = 0;
    for (std::size_t k = at; k < at + 4; ++k) value = 256 * value + static_cast<unsigned char>(png.at(k));
    return value;
  };
  return {number(16), number(20)};
}

void simulate(const Folder& folder, const Words& more = {}) {
  write_text(folder / "s.json", swinging);
  Words words{"run", "s.json", "--quiet"};
  words.insert(words.end(), more.begin(), more.end());
  const Ended ended = run_program(folder, words);
  ASSERT_EQ(ended.code, 0) << ended.err;
}

TEST(PictureCommandTest, DrawsAnInstantAndSaysBetweenWhichFrames) {
  const Folder folder;
  simulate(folder);

  const Ended ended =
      run_program(folder, {"picture", "s.out", "--time", "0.25", "--out", "p.png", "--size", "320x200"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(ended.err, "tanor: t = 0.25 in p.png, between the frames at 0.2 and 0.3\n");
  EXPECT_EQ(read_size(read_text(folder / "p.png")), (std::array{320, 200}));

  const Ended frame = run_program(folder, {"picture", "s.out", "--time", "0.3", "--json"});
  const json facts = json::parse(frame.out);
  EXPECT_EQ(facts["file"], "s.out/picture.png");
  EXPECT_EQ(facts["frames"][0], facts["frames"][1]);
  EXPECT_EQ(facts["width"], 1600);
  EXPECT_GT(facts["tension_scale"].get<double>(), 10.0);
  EXPECT_GT(facts["arrow"].get<double>(), 0.0);
  EXPECT_EQ(read_size(read_text(folder / "s.out/picture.png")), (std::array{1600, 1000}));
}

/// Runs the lines of README.md that make a picture as they stand there.
TEST(PictureCommandTest, TheLinesOfTheReadmeMakeAPicture) {
  const Folder folder;
  const std::filesystem::path project = std::filesystem::path(TANOR_DOCS).parent_path();
  std::filesystem::create_directory_symlink(project / "examples", folder / "examples");
  std::istringstream readme(read_text(project / "README.md"));
  const std::string program = "build/src/cli/tanor ";
  std::size_t num_lines = 0;
  for (std::string line; std::getline(readme, line);) {
    if (!line.starts_with(program)) continue;
    std::istringstream rest(line.substr(program.size()));
    const Ended ended = run_program(folder, Words{std::istream_iterator<std::string>(rest), {}});
    EXPECT_EQ(ended.code, 0) << line << "\n" << ended.err;
    ++num_lines;
  }
  EXPECT_EQ(num_lines, 2u);
  EXPECT_EQ(read_size(read_text(folder / "build/net/picture.png")), (std::array{1600, 1000}));
}

TEST(PictureCommandTest, DrawsTheLastFrameWithoutATime) {
  const Folder folder;
  simulate(folder, {"--out", "o"});
  const Ended ended = run_program(folder, {"picture", "o", "--json", "--size", "100x100"});
  EXPECT_EQ(json::parse(ended.out)["t"], 0.4);
}

TEST(PictureCommandTest, ANewRunTakesThePictureOfTheOldOneAway) {
  const Folder folder;
  simulate(folder, {"--out", "o"});
  ASSERT_EQ(run_program(folder, {"picture", "o", "--size", "100x100"}).code, 0);
  simulate(folder, {"--out", "o"});
  EXPECT_FALSE(std::filesystem::exists(folder / "o/picture.png"));
}

/// A surface of one point is drawn. A linear equation of two points has no picture, and the program says so.
TEST(PictureCommandTest, SaysWhichGuidesItDoesNotDraw) {
  const Folder folder;
  const std::string saddle = R"json({"kind": "formula", "name": "saddle", "points": [[0]],
    "equation": "z1-0.2*((x1-5)^2-y1^2)"})json";
  const std::string wire =
      R"({"kind": "linear", "name": "wire", "tuples": [[0, 1]], "coefficients": [[1, 0, 0], [-2, 0, 0]]})";
  const auto draw = [&](const std::string& constraints) {
    write_text(folder / "s.json", R"({"tanor_scene": 1, "name": "guides",
      "points": {"positions": [[6, 1, 0], [3, 0, 0]]}, "constraints": [)" +
                                      constraints + R"(],
      "motion": {"t_end": 0.1}})");
    EXPECT_EQ(run_program(folder, {"run", "s.json", "--quiet"}).code, 0);
    const Ended said = run_program(folder, {"picture", "s.out", "--size", "100x100"});
    const json facts = json::parse(run_program(folder, {"picture", "s.out", "--json", "--size", "100x100"}).out);
    return std::pair{said.err, facts["guides_left_out"].get<int>()};
  };

  const auto [saddle_said, saddle_left_out] = draw(saddle);
  EXPECT_FALSE(contains(saddle_said, "not drawn")) << saddle_said;
  EXPECT_EQ(saddle_left_out, 0);
  const auto [both_said, both_left_out] = draw(saddle + "," + wire);
  EXPECT_TRUE(contains(both_said, "tanor: not drawn: wire (linear)\n")) << both_said;
  EXPECT_EQ(both_left_out, 1);

  std::string many = wire;
  for (int k = 0; k < 70; ++k)
    many += R"(, {"kind": "plane", "name": "floor)" + std::to_string(k) + R"(", "points": [0], "normal": [0, 0, 1]})";
  const auto [many_said, many_left_out] = draw(many);
  EXPECT_TRUE(contains(many_said, "tanor: not drawn: wire (linear), 6 more guides\n")) << many_said;
  EXPECT_GE(many_left_out, 7);
}

/// A run that could not start has no picture, and says why.
TEST(PictureCommandTest, NamesWhyARunDidNotStart) {
  const Folder folder;
  write_text(folder / "s.json", R"json({"tanor_scene": 1, "points": {"positions": [[0, 0, 0], [1, 0, 0]]},
    "supports": [{"points": [0]}], "constraints": [{"name": "a", "kind": "rod", "pairs": [[0, 1]], "length": 1},
    {"name": "b", "kind": "rod", "pairs": [[0, 1]], "length": {"formula": "1 + 0.1*t^2"}}], "motion": {"t_end": 1}})json");
  EXPECT_EQ(run_program(folder, {"run", "s.json", "--quiet"}).code, 3);
  const std::string why = read_json(folder / "s.out/summary.json").at("stopped_by");

  EXPECT_EQ(complaint(folder, {"picture", "s.out"}),
            "tanor: s.out/trajectory.pvd: names no frames, since the motion did not start: " + why + "\n");
  EXPECT_TRUE(contains(complaint(folder, {"view", "s.out"}), "--report makes it; the run there was stopped: " + why));
}

TEST(PictureCommandTest, WrongOptionsAreNamed) {
  const Folder folder;
  simulate(folder, {"--out", "o"});
  const auto complain = [&](Words words) {
    words.insert(words.begin(), {"picture", "o"});
    return complaint(folder, words);
  };
  EXPECT_TRUE(contains(complain({"--time", "0.5"}), "--time: must be between 0 and 0.4, the frames of o, not 0.5"));
  EXPECT_TRUE(contains(complain({"--time", "-0.1"}), "--time"));
  EXPECT_TRUE(contains(complain({"--time"}), "--time needs one value; see tanor picture --help"));
  EXPECT_TRUE(contains(complain({"--time", "nan"}), "--time: must be a finite number"));
  EXPECT_TRUE(contains(complain({"--size", "10x10"}), "--size: must be WIDTHxHEIGHT"));
  EXPECT_TRUE(contains(complain({"--size", "1000"}), "--size"));
  EXPECT_TRUE(contains(complain({"--view", "w"}), "--view: must be auto, x, -x"));
  EXPECT_TRUE(contains(complain({"--view", "0,91"}), "--view"));
  EXPECT_TRUE(contains(complain({"--projection", "fish-eye"}), "--projection: must be perspective or orthographic"));
  EXPECT_TRUE(contains(complain({"--scale", "0"}), "--scale: must be a finite number > 0"));
  EXPECT_TRUE(contains(complain({"--show", "rods,ropes"}), "not 'ropes'"));
  EXPECT_TRUE(contains(complain({"--out", "o/trajectory.pvd"}),
                       "--out: found o/trajectory.pvd, wanted a name that ends in .png"));
  EXPECT_TRUE(contains(complaint(folder, {"picture", "missing"}), "missing: there is no such folder"));
  EXPECT_TRUE(contains(complaint(folder, {"picture", "s.json"}), "is a file; wanted the folder of a run"));
  std::filesystem::create_directory(folder / "empty");
  EXPECT_TRUE(contains(complaint(folder, {"picture", "empty"}), "there is no trajectory.pvd"));
  write_text(folder / "o/trajectory/frame_000001.vtp", "<VTKFile>");
  EXPECT_TRUE(contains(complain({"--time", "0.1"}), "frame_000001.vtp: is damaged"));
}

}  // namespace
}  // namespace tanor::cli
