#include "cli/program.hpp"
#include "report/npy.hpp"

namespace tanor::cli {
namespace {

using nlohmann::json;

/// A bead of 2 kg that passes the lowest point of its rod of 0.5 m at 3 m/s.
///
///     X         w_N = v^2/l = 18 m/s^2 upwards, w_T = 0
///     |         tension = m (g + v^2/l) = 55.62 N
///     o-> v
constexpr const char* swing_scene = R"({
  "tanor_scene": 1,
  "points": {"positions": [[0,0,0.5], [0,0,0]], "velocities": [[0,0,0], [3,0,0]], "masses": 2},
  "supports": [{"points": [0]}],
  "constraints": [{"kind": "rod", "pairs": [[0,1]]}],
  "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}]})";

void expect_row(const json& row, double x, double y, double z) {
  EXPECT_NEAR(row[0], x, 1e-13);
  EXPECT_NEAR(row[1], y, 1e-13);
  EXPECT_NEAR(row[2], z, 1e-13);
}

TEST(SolveTest, PrintsTheAnswerOfTheContract) {
  const Folder folder;
  write_text(folder / "s.json", swing_scene);

  const Ended ended = run_program(folder, {"solve", "s.json"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(ended.err, "");
  const json solution = json::parse(ended.out);
  Words keys;
  for (const auto& [key, value] : solution.items()) keys.push_back(key);
  EXPECT_EQ(keys, (Words{"accelerations",
                         "certificate",
                         "degrees_of_freedom",
                         "form",
                         "friction",
                         "friction_report",
                         "groups",
                         "left_out",
                         "mass_coupling",
                         "multipliers",
                         "multipliers_unique",
                         "normal_accelerations",
                         "normal_forces",
                         "normal_friction",
                         "observables",
                         "positions",
                         "rank",
                         "reactions",
                         "reactions_by_cause",
                         "redundant",
                         "self_stress",
                         "support_forces",
                         "tangent_accelerations",
                         "tangent_forces",
                         "tangent_friction",
                         "units",
                         "velocities"}));
  expect_row(solution["velocities"][1], 3, 0, 0);
  expect_row(solution["accelerations"][1], 0, 0, 18);
  expect_row(solution["tangent_accelerations"][1], 0, 0, 0);
  expect_row(solution["normal_accelerations"][1], 0, 0, 18);
  expect_row(solution["reactions"][1], 0, 0, 55.62);
  expect_row(solution["support_forces"][0], 0, 0, -55.62);
  ASSERT_EQ(solution["observables"].size(), 2U);
  EXPECT_EQ(solution["observables"][0]["name"], "tension(rod0)");
  EXPECT_NEAR(solution["observables"][0]["values"][0], 55.62, 1e-13);
  EXPECT_NEAR(solution["multipliers"][0], -55.62, 1e-13);
  expect_row(solution["tangent_forces"][1], 0, 0, 0);
  expect_row(solution["normal_forces"][1], 0, 0, -19.62);
  const json& causes = solution["reactions_by_cause"];
  ASSERT_EQ(causes.size(), 2U);
  EXPECT_EQ(causes[0]["cause"], "gravity0");
  EXPECT_NEAR(causes[0]["multipliers"][0], -19.62, 1e-13);
  expect_row(causes[0]["reactions"][1], 0, 0, 19.62);
  EXPECT_EQ(causes[1]["cause"], "inertia");
  EXPECT_NEAR(causes[1]["multipliers"][0], -36.0, 1e-13);
  EXPECT_EQ(solution["multipliers_unique"], json::array({true}));
  EXPECT_TRUE(solution["friction"].is_null());
  for (const json& figure : solution["friction_report"]) EXPECT_TRUE(figure.is_null());
  EXPECT_EQ(solution["form"], "normal");
  EXPECT_LT(solution["certificate"]["residual"], 1e-14);
  EXPECT_LT(solution["certificate"]["normal_identity"], 1e-14);
  EXPECT_LT(solution["certificate"]["tangent_identity"], 1e-14);
  EXPECT_LT(solution["certificate"]["second_factorization"], 1e-14);
  EXPECT_TRUE(solution["certificate"]["forms_agree"].is_null()) << "no coordinates are given";
  EXPECT_EQ(solution["certificate"]["left_out"], json::array());
  EXPECT_EQ(solution["certificate"]["verdict"].get<std::string>().rfind("certified to ", 0), 0U);
  EXPECT_EQ(list_names(folder.path()), Words{"s.json"});
}

TEST(SolveTest, WritesTheSameToAFile) {
  const Folder folder;
  write_text(folder / "s.json", swing_scene);

  const Ended ended = run_program(folder, {"solve", "s.json", "--out", "answer.json"});

  EXPECT_EQ(ended.code, 0);
  EXPECT_EQ(ended.out, "");
  EXPECT_EQ(read_text(folder / "answer.json"), run_program(folder, {"solve", "s.json"}).out);
  EXPECT_EQ(list_names(folder.path()), (Words{"answer.json", "s.json"}));
}

TEST(SolveTest, LargeArraysGoToFilesBesideIt) {
  const Folder folder;
  write_text(folder / "s.json", R"({"tanor_scene": 1, "generate": {"kind": "chain", "count": 20000, "anchored": true},
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}]})");

  EXPECT_EQ(run_program(folder, {"solve", "s.json", "--out", "answer.json"}).code, 0);

  const json solution = read_json(folder / "answer.json");
  EXPECT_EQ(solution["accelerations"], "answer_accelerations.npy");
  EXPECT_EQ(solution["multipliers_unique"], "answer_multipliers_unique.npy");
  EXPECT_TRUE(solution["friction"].is_null());
  EXPECT_EQ(solution["reactions_by_cause"][1]["reactions"], "answer_cause1_reactions.npy");
  const scene::NpyArray array = report::read_npy(folder / "answer_accelerations.npy");
  EXPECT_EQ(array.shape, (std::vector<std::size_t>{20001, 3}));
}

TEST(SolveTest, ASolveWithoutAStartPrintsNulls) {
  const Folder folder;
  write_text(folder / "s.json", torn_apart());

  const Ended ended = run_program(folder, {"solve", "s.json"});

  EXPECT_EQ(ended.code, 3);
  EXPECT_TRUE(ended.err.starts_with("tanor: s.json: ")) << ended.err;
  const json solution = json::parse(ended.out);
  for (const char* key : {"positions", "accelerations", "multipliers", "multipliers_unique", "reactions"}) {
    EXPECT_TRUE(solution[key].is_null()) << key;
  }
}

TEST(InfoTest, TellsSizesAndWritesNothing) {
  const Folder folder;
  write_text(folder / "s.json", swing_scene);

  const Ended ended = run_program(folder, {"info", "s.json"});

  EXPECT_EQ(ended.code, 0) << ended.err;
  for (const char* line :
       {"source:                  inline\n", "points:                  2\n", "supports:                1\n",
        "equations:               1\n", "degrees of freedom:      2, if", "islands:                 1, in 1 part\n",
        "constraints:             rod", "forces:                  gravity", "left out: "}) {
    EXPECT_TRUE(contains(ended.out, line)) << line << " is missing in\n" << ended.out;
  }
  EXPECT_EQ(list_names(folder.path()), Words{"s.json"});
}

TEST(SolveTest, SplitsTheFrictionOfBeadsThatAreCoupled) {
  // Two beads are on rough rails with a rod between them. tau = tau_T + tau_N, and tau_T does not press on the
  // constraints.
  const Folder folder;
  write_text(folder / "s.json", R"json({
    "tanor_scene": 1,
    "points": {"positions": [[0, 0, 0], [3, 0, 4]], "velocities": [[1, 0, 0], [1, 0, 0]], "masses": [1, 2]},
    "constraints": [{"name": "low", "kind": "line", "points": [0], "origin": [0, 0, 0], "direction": [1, 0, 0]},
                    {"name": "high", "kind": "line", "points": [1], "origin": [0, 0, 4], "direction": [1, 0, 0]},
                    {"kind": "rod", "pairs": [[0, 1]]}],
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -10]}],
    "friction": [{"kind": "coulomb", "at": "low", "coefficient": 0.3}]})json");

  const Ended ended = run_program(folder, {"solve", "s.json"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  const json solution = json::parse(ended.out);
  const double tau = solution["friction"][0][0];
  EXPECT_LT(tau, -0.1);
  // T is (1, 1) along x, so that it takes half of tau at each bead.
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(solution["tangent_friction"][i][0], 0.5 * tau, 1e-12);
    EXPECT_NEAR(solution["normal_friction"][i][0], i == 0 ? 0.5 * tau : -0.5 * tau, 1e-12);
  }
}

TEST(SolveTest, FailedCertificateEndsWithExitCode3) {
  // Differences of places cannot follow a drive of 1e6 rad/s. The answer is written, but nothing proves it.
  const Folder folder;
  write_text(folder / "hum.json", R"json({
    "tanor_scene": 1, "points": {"positions": [[1e-9, 0, 0]]},
    "coordinates": [{"kind": "formula", "points": [0], "q": {"a": 0}, "q_dot": {"a": 0},
                     "x": "0.000000001*cos(1000000*t) + 500*t^2", "y": "a"}]})json");

  const Ended solved = run_program(folder, {"solve", "hum.json", "--out", "hum.solution.json"});
  const Ended checked = run_program(folder, {"check", "hum.json"});

  EXPECT_EQ(solved.code, 3);
  EXPECT_EQ(checked.code, 3);
  EXPECT_TRUE(contains(solved.err, "not certified: ")) << solved.err;
  const json solution = read_json(folder / "hum.solution.json");
  EXPECT_EQ(solution["accelerations"][0][1], 0.0);
  EXPECT_EQ(solution["certificate"]["verdict"].get<std::string>().rfind("not certified: ", 0), 0U);
}

}  // namespace
}  // namespace tanor::cli
