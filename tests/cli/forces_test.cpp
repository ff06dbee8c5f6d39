#include <cmath>

#include <fmt/format.h>

#include "cli/program.hpp"
#include "report/npy.hpp"

namespace tanor::cli {
namespace {

using nlohmann::json;

/// A bead of 2 kg on a rod of 1 m.
constexpr const char* pendulum_scene = R"({
  "tanor_scene": 1, "name": "pendulum",
  "points": {"positions": [[0,0,0], [1,0,0]], "masses": 2},
  "supports": [{"points": [0]}],
  "constraints": [{"name": "rod", "kind": "rod", "pairs": [[0,1]]}],
  "forces": [{"kind": "gravity", "acceleration": [0,-9.81,0]}]})";

/// Returns a motion table that turns evenly at 3 rad/s. `length` is the length of the rod at a time.
template <class Length>
std::string turn_evenly(const Length& length) {
  std::string text = "t,x1,y1,z1,x2,y2,z2\n";
  for (int k = 0; k <= 200; ++k) {
    const double t = 0.005 * k;
    text += fmt::format("{},0,0,0,{},{},0\n", t, length(t) * std::cos(3.0 * t), length(t) * std::sin(3.0 * t));
  }
  return text;
}
constexpr auto one = [](double) { return 1.0; };

TEST(ForcesTest, FindsReactionsAndControlOfAMotion) {
  const Folder folder;
  write_text(folder / "s.json", pendulum_scene);
  write_text(folder / "m.csv", turn_evenly(one));

  const Ended ended = run_program(folder, {"forces", "s.json", "--motion", "m.csv", "--out", "answer"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(ended.err, "");
  EXPECT_TRUE(contains(ended.out, "largest control force 19.6 (point 1, t = 0)")) << ended.out;
  EXPECT_TRUE(contains(ended.out, "results in answer")) << ended.out;
  const json forces = read_json(folder / "answer/forces.json");
  const json& sample = forces["samples"][100];
  const double a = 1.5;
  EXPECT_EQ(sample["t"], 0.5);
  EXPECT_LT(sample["position_violation"], 1e-15);
  EXPECT_LT(sample["acceleration_violation"], 1e-6);
  EXPECT_EQ(sample["outcome"], "ok");
  // u = m g cos a, tension = m (omega^2 l - g sin a)
  EXPECT_NEAR(sample["largest_control_force"], 19.62 * std::abs(std::cos(a)), 1e-6);
  EXPECT_NEAR(forces["multipliers"][100][0], -(18.0 - 19.62 * std::sin(a)), 1e-6);
  EXPECT_NEAR(forces["control_forces"][100][4], 19.62 * std::cos(a) * std::cos(a), 1e-6);
  EXPECT_EQ(forces["reactions"].size(), 201U);
  EXPECT_EQ(forces["support_forces"][0].size(), 6U);
  EXPECT_EQ(forces["given"], "positions");
  EXPECT_TRUE(forces["friction"].is_null());
}

TEST(ForcesTest, AMotionOfCoordinatesIsTakenWhereTheSceneHasSome) {
  const Folder folder;
  write_text(folder / "s.json", R"({
    "tanor_scene": 1, "name": "slide", "points": {"positions": [[0,0,0]], "masses": 2},
    "coordinates": [{"kind": "line", "points": [0], "origin": [0,0,0], "direction": [1,0,0]}],
    "forces": [{"kind": "gravity", "acceleration": [0,-9.81,0]}]})");
  std::string text;
  for (int k = 0; k <= 20; ++k) text += fmt::format("{},{}\n", 0.1 * k, 1.5 * 0.01 * k * k);
  write_text(folder / "q.csv", text);

  const Ended ended = run_program(folder, {"forces", "s.json", "--motion", "q.csv"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  const json forces = read_json(folder / "s.out/forces.json");
  EXPECT_EQ(forces["given"], "coordinates");
  EXPECT_NEAR(forces["control_forces"][10][0], 6.0, 1e-9);  // m q''
  EXPECT_NEAR(forces["reactions"][10][1], 19.62, 1e-12);
  EXPECT_TRUE(forces["multipliers"].is_null());
}

TEST(ForcesTest, ArraysOfManyPointsOverTimeGoToFilesBesideIt) {
  const Folder folder;
  const std::size_t num_points = 101;
  std::vector<double> rows;
  for (int k = 0; k < 120; ++k) {
    rows.push_back(k);
    rows.insert(rows.end(), 3 * num_points, 0.0);
  }
  write_text(folder / "s.json", R"({"tanor_scene": 1, "name": "c", "points": {"positions": {"file": "p.npy"}}})");
  report::write_npy(folder / "p.npy", std::vector<double>(3 * num_points, 0.0), 3);
  report::write_npy(folder / "m.npy", rows, 1 + 3 * num_points);

  const Ended ended = run_program(folder, {"forces", "s.json", "--motion", "m.npy", "--out", "o"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  const json forces = read_json(folder / "o/forces.json");
  EXPECT_EQ(forces["control_forces"], "forces_control_forces.npy");
  EXPECT_EQ(report::read_npy(folder / "o/forces_control_forces.npy").shape,
            (std::vector<std::size_t>{120, 3 * num_points}));
}

TEST(ForcesTest, AMotionOffTheConstraintsEndsWith3AndIsWrittenAllTheSame) {
  const Folder folder;
  write_text(folder / "s.json", pendulum_scene);
  write_text(folder / "m.csv", turn_evenly([](double t) { return 1.0 + 1e-3 * t; }));

  const Ended ended = run_program(folder, {"forces", "s.json", "--motion", "m.csv", "--out", "o"});

  EXPECT_EQ(ended.code, 3);
  EXPECT_TRUE(contains(ended.err, "tanor: s.json: the motion breaks the constraints: worst by 0.00")) << ended.err;
  EXPECT_TRUE(contains(ended.err, "rod[0] at t = 1")) << ended.err;
  EXPECT_EQ(read_json(folder / "o/forces.json")["samples"][200]["position_violation_at"], "rod[0]");
}

TEST(ForcesTest, PoorAccelerationsAreSaidWithTheirViolation) {
  // The motion lies on the circle at the samples. Between two samples the spline is a straight line, between nine a
  // rough curve.
  const Folder folder;
  write_text(folder / "s.json", pendulum_scene);
  const auto turn = [](int samples) {
    std::string text;
    for (int k = 0; k < samples; ++k) {
      const double angle = 4.0 * k / (samples - 1);
      text += fmt::format("{},0,0,0,{:.17g},{:.17g},0\n", 1.0 * k / (samples - 1), std::cos(angle), std::sin(angle));
    }
    return text;
  };
  const auto warning = [&](int samples) {
    write_text(folder / "m.csv", turn(samples));
    const Ended ended = run_program(folder, {"forces", "s.json", "--motion", "m.csv"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    return ended.err;
  };

  const std::string two = warning(2), nine = warning(9), many = warning(201);

  EXPECT_TRUE(contains(two, "warning: the motion has 2 samples, 6 are the fewest")) << two;
  EXPECT_TRUE(contains(two, "polynomial of degree 1; the accelerations of the spline break the constraints by")) << two;
  EXPECT_TRUE(contains(nine, "warning: the accelerations of the spline break the constraints by")) << nine;
  EXPECT_TRUE(contains(nine, "rod[0] at t = ")) << nine;
  EXPECT_EQ(many, "");
}

TEST(ForcesTest, WrongMotionsAreNamed) {
  const Folder folder;
  write_text(folder / "s.json", pendulum_scene);
  write_text(folder / "narrow.csv", "0,1,2,3\n1,1,2,3\n");
  write_text(folder / "still.csv", "0,0,0,0,1,0,0\n0,0,0,0,1,0,0\n");
  write_text(folder / "single.csv", "0,0,0,0,1,0,0\n");
  write_text(folder / "words.csv", "0,0,0,0,1,0,0\n1,0,0,0,one,0,0\n");

  const auto complain = [&](const std::string& motion) {
    return complaint(folder, {"forces", "s.json", "--motion", motion});
  };
  EXPECT_TRUE(contains(complain("narrow.csv"), "narrow.csv: found 4 columns, wanted 7 (t, then x, y, z of 2 points)"));
  EXPECT_TRUE(contains(complain("still.csv"), "still.csv: table: row 2: time 0 after 0"));
  EXPECT_TRUE(contains(complain("single.csv"), "at least 2"));
  EXPECT_TRUE(contains(complain("words.csv"), "line 2"));
  EXPECT_TRUE(contains(complain("none.csv"), "none.csv"));
  EXPECT_TRUE(contains(complaint(folder, {"forces", "s.json"}), "--motion is required"));
}

}  // namespace
}  // namespace tanor::cli
