#include <cmath>

#include "cli/program.hpp"

namespace tanor::cli {
namespace {

using nlohmann::json;

/// Three rods between two supports, sagging. The spring between beads is as long as drawn.
const json hanging = json::parse(R"({
  "tanor_scene": 1,
  "points": {"positions": [[0,0,0], [0.7,0,-0.5], [1.5,0,-0.5], [2.2,0,0]], "velocities": [[0,0,0], [1,0,0], [0,0,0], [0,0,0]],
             "masses": 2},
  "supports": [{"points": [0, 3]}],
  "constraints": [{"name": "rods", "kind": "rod", "pairs": [[0,1], [1,2], [2,3]], "length": 0.9}],
  "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]},
             {"name": "air", "kind": "drag", "points": [1, 2], "linear": 0.1},
             {"kind": "spring", "pairs": [[0,2]], "stiffness": 3, "rest_length": "initial"}],
  "motion": {"t_end": 0.1}})");

TEST(EquilibriumTest, WritesTheAnswerOfTheContract) {
  const Folder folder;

  const Ended ended = find_at_rest(folder, hanging);

  ASSERT_EQ(ended.code, 0) << ended.err;
  const json summary = json::parse(read_text(folder / "at_rest/summary.json"));
  const json& found = summary["equilibrium"];
  EXPECT_EQ(found["status"], "stable");
  EXPECT_EQ(found["unstable_directions"], 0);
  EXPECT_LE(found["residual_force"].get<double>(), 1e-10 * found["largest_force"].get<double>());
  EXPECT_LE(found["violation"].get<double>(), 1e-12);
  EXPECT_TRUE(found["buckling_load_factor"].is_null());
  EXPECT_TRUE(found["multipliers_unique"]);
  const std::string left_out = summary["left_out"].dump();
  EXPECT_NE(left_out.find("velocities"), std::string::npos);
  EXPECT_NE(left_out.find("air"), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(folder / "at_rest/equilibrium.xyz"));
}

TEST(EquilibriumTest, RunStaysAtTheSceneThatItWrites) {
  const Folder folder;
  ASSERT_EQ(find_at_rest(folder, hanging).code, 0);

  const Ended ended = run_program(folder, {"run", "at_rest/equilibrium.json", "--out", "motion", "--quiet"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  const json before = json::parse(read_text(folder / "at_rest/summary.json"))["final"]["positions"];
  const json after = json::parse(read_text(folder / "motion/summary.json"))["final"]["positions"];
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(after[i][k].get<double>(), before[i][k].get<double>(), 1e-9);
  }
}

TEST(EquilibriumTest, RunStaysAtAGeneratedSceneToo) {
  const Folder folder;
  const json net = json::parse(R"({
    "tanor_scene": 1, "generate": {"kind": "net", "columns": 5, "rows": 4, "spacing": 0.1, "mass": 0.1},
    "supports": [{"points": [0, 4]}], "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}],
    "motion": {"t_end": 0.05}})");
  ASSERT_EQ(find_at_rest(folder, net).code, 0);

  const Ended ended = run_program(folder, {"run", "at_rest/equilibrium.json", "--out", "motion", "--quiet"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  const json after = json::parse(read_text(folder / "motion/summary.json"))["final"]["positions"];
  EXPECT_NEAR(after[19][2].get<double>(), -0.3, 1e-9);
}

/// With a rod that grows or supports that move, the scene at rest begins at its own time. A support that moves evenly
/// carries rest along, and the others are frozen.
TEST(EquilibriumTest, EquilibriumAtALaterTimeIsWrittenAsASceneThatRunsFromThatTime) {
  for (const char* what : {"rod", "support", "spring"}) {
    const Folder folder;
    json scene = json::parse(R"({
      "tanor_scene": 1, "points": {"positions": [[0,0,0], [0.1,0,-1]], "masses": 1}, "supports": [{"points": [0]}],
      "constraints": [{"kind": "rod", "pairs": [[0,1]], "length": 1}],
      "forces": [{"name": "w", "kind": "gravity", "acceleration": [0,0,-9.81]}],
      "equilibrium": {"at": 3}, "motion": {"t_end": 0.2}})");
    if (what == std::string("rod")) scene["constraints"][0]["length"] = {{"formula", "1+0.1*t"}};
    if (what == std::string("support")) scene["supports"][0]["motion"] = {{"formula", {"0.1*t", "0", "0.2*t"}}};
    if (what == std::string("spring"))
      scene["forces"].push_back({{"kind", "potential"}, {"points", {{1}}}, {"energy", "(x1-t)^2"}});
    if (what != std::string("support")) scene["equilibrium"]["time"] = "freeze";
    ASSERT_EQ(find_at_rest(folder, scene).code, 0) << what;

    const Ended ended = run_program(folder, {"run", "at_rest/equilibrium.json", "--out", "motion", "--quiet"});
    const Ended solved = run_program(folder, {"solve", "at_rest/equilibrium.json", "--out", "forces"});
    const Ended again = run_program(folder, {"equilibrium", "at_rest/equilibrium.json", "--out", "again"});

    EXPECT_EQ(ended.code, 0) << what << ended.err;
    EXPECT_EQ(solved.code, 0) << what << solved.err;
    EXPECT_EQ(again.code, 0) << what << again.err;
    EXPECT_NEAR(json::parse(read_text(folder / "motion/summary.json"))["t_end"].get<double>(), 3.2, 1e-12);
    EXPECT_EQ(json::parse(read_text(folder / "again/summary.json"))["equilibrium"]["iterations"], 0) << what;
  }
}

/// A bead that rests on a hoop which turns stays at its height in a motion from there, and one that grows is refused.
TEST(EquilibriumTest, RestOnATurningHoopIsKeptByAMotion) {
  const Folder folder;
  json scene = json::parse(R"json({
    "tanor_scene": 1, "points": {"positions": [[0.6,0,-0.8]]},
    "constraints": [{"name": "hoop", "kind": "circle", "points": [0], "center": [0,0,0],
                     "normal": {"formula": ["-sin(5*t)", "cos(5*t)", "0"]}, "radius": 1}],
    "forces": [{"kind": "gravity", "acceleration": [0,0,-10]}], "motion": {"t_end": 2}})json");
  ASSERT_EQ(find_at_rest(folder, scene).code, 0);

  const Ended ended = run_program(folder, {"run", "at_rest/equilibrium.json", "--out", "motion", "--quiet"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  const json after = json::parse(read_text(folder / "motion/summary.json"))["final"]["positions"];
  EXPECT_NEAR(after[0][2].get<double>(), -0.4, 1e-6);
  scene["constraints"][0]["radius"] = {{"formula", "1+0.1*t"}};
  const Ended refused = find_at_rest(folder, scene);
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("hoop (normal, radius)"), std::string::npos) << refused.err;
}

/// Expects that a scene and the scene which it writes have the same equilibrium, and that a run of the latter starts
/// there.
void expect_same_at_written_scene(const Folder& folder, const json& scene, const std::string& what) {
  const Ended first = find_at_rest(folder, scene);
  ASSERT_EQ(first.code, 0) << what << first.err;

  const Ended again = run_program(folder, {"equilibrium", "at_rest/equilibrium.json", "--out", "again"});
  const Ended ran = run_program(folder, {"run", "at_rest/equilibrium.json", "--out", "motion", "--quiet"});

  ASSERT_EQ(again.code, 0) << what << again.err;
  ASSERT_EQ(ran.code, 0) << what << ran.err;
  const json before = json::parse(read_text(folder / "at_rest/summary.json")),
             after = json::parse(read_text(folder / "again/summary.json"));
  EXPECT_EQ(after["equilibrium"]["iterations"], 0) << what;
  for (std::size_t i = 0; i < before["final"]["positions"].size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(after["final"]["positions"][i][k].get<double>(), before["final"]["positions"][i][k].get<double>(),
                  1e-9)
          << what;
  }
  EXPECT_LE(json::parse(read_text(folder / "motion/summary.json"))["start_correction"].get<double>(), 1e-4) << what;
}

/// The support has moved since lengths, angles and radii were measured, and stands at the time of the equilibrium.
TEST(EquilibriumTest, InitialNumbersAreThoseOfTheSceneThatWasGiven) {
  const Folder folder;
  std::string drive;
  for (int i = 0; i <= 60; ++i)
    drive += std::to_string(0.05 * i) + ",0,0," + std::to_string(0.5 * std::sin(M_PI * 0.025 * i)) + "\n";
  write_text(folder / "drive.csv", drive);
  const json base = json::parse(R"json({
    "tanor_scene": 1, "points": {"positions": [[0,0,0], [0.3,0,-1], [0,0,-2]], "masses": 1},
    "supports": [{"points": [0], "motion": {"formula": ["0", "0", "0.5*sin(pi*t/2)"]}}],
    "constraints": [{"kind": "rod", "pairs": [[0,1],[1,2]]}], "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}],
    "equilibrium": {"at": 1, "accept": "marginal", "time": "freeze"}, "motion": {"t_end": 0.01}})json");
  json angle = base, table = base, sphere = base, pulley = base;
  angle["constraints"].push_back({{"kind", "angle"}, {"triples", {{0, 1, 2}}}});
  table["supports"][0]["motion"] = {{"table", "drive.csv"}};
  sphere["supports"].clear();
  sphere["constraints"][0] = {
      {"kind", "sphere"}, {"points", {1, 2, 0}}, {"center", {{"formula", {"0", "0", "3+(t-1)^2"}}}}};
  sphere["constraints"].push_back({{"kind", "plane"},
                                   {"points", {0, 1, 2}},
                                   {"normal", {{"formula", {"0", "1", "0.1*(t-1)^2"}}}},
                                   {"offset", "initial"}});
  pulley["constraints"] = {{{"kind", "pulley"}, {"pairs", {{0, 1}}}, {"a", {0, 0, 1}}, {"b", {0, 0, 2}}},
                           {{"kind", "rod"}, {"pairs", {{1, 2}}}}};

  for (const auto& [scene, what] :
       {std::pair{base, "rods"}, {table, "table"}, {angle, "angle"}, {sphere, "sphere"}, {pulley, "pulley"}})
    expect_same_at_written_scene(folder, scene, what);
}

/// Energies of an imported file are the scene's own in the written scene, and entries keep their names.
TEST(EquilibriumTest, WritesWhatCameWithItsPoints) {
  const Folder folder;
  write_text(folder / "chain.data", R"(chain

4 atoms
3 bonds
2 angles
1 dihedrals
1 atom types
1 bond types
1 angle types
1 dihedral types

-9 9 xlo xhi
-9 9 ylo yhi
-9 9 zlo zhi

Masses

1 2

Atoms # molecular

1 1 1 0 0 0
2 1 1 1 0 0
3 1 1 1.5 0.8 0
4 1 1 2.4 1 0.3

Bonds

1 1 1 2
2 1 2 3
3 1 3 4

Angles

1 1 1 2 3
2 1 2 3 4

Dihedrals

1 1 1 2 3 4

Bond Coeffs # harmonic

1 50 1.1

Angle Coeffs # harmonic

1 20 110

Dihedral Coeffs # opls

1 1.1 -0.3 2.2 0.7
)");
  const json scene = json::parse(R"({
    "tanor_scene": 1, "import": {"file": "chain.data", "format": "lammps-data", "bonds": "energies", "angles": "energies",
                                 "dihedrals": "energies"},
    "supports": [{"points": [0, 3]}], "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]},
      {"kind": "pair", "law": "yukawa", "strength": 1, "length": 1}],
    "constraints": [{"kind": "plane", "points": [1], "normal": [0,0,1]}], "motion": {"t_end": 0.01}})");

  expect_same_at_written_scene(folder, scene, "import");
  const json written = json::parse(read_text(folder / "at_rest/equilibrium.json"));
  ASSERT_EQ(written["forces"].size(), 5u);
  EXPECT_EQ(written["forces"][2]["name"], "bonds1");
  EXPECT_EQ(written["constraints"][0]["name"], "plane0");
}

/// The coordinates of a formula begin at the place of the given scene. The constraints describe the same motion.
TEST(EquilibriumTest, LeavesOutCoordinatesThatBeginElsewhere) {
  const Folder folder;
  const json scene = json::parse(R"json({
    "tanor_scene": 1, "points": {"positions": [[1,0,0]], "masses": 1},
    "constraints": [{"kind": "formula", "points": [[0]], "equation": "x1^2 + z1^2 - 1"},
                    {"kind": "plane", "points": [0], "normal": [0,1,0]}],
    "coordinates": [{"kind": "formula", "points": [0], "q": {"a": 0}, "x": "cos(a)", "z": "-sin(a)"}],
    "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}], "motion": {"t_end": 0.01},
    "solver": {"form": "tangent"}})json");

  expect_same_at_written_scene(folder, scene, "formula");
}

TEST(EquilibriumTest, UnknownTensionsOfATautWireAreNull) {
  const Folder folder;
  const json wire = json::parse(R"({
    "tanor_scene": 1, "points": {"positions": [[0,0,0], [1,0,0], [2,0,0]], "masses": 1}, "supports": [{"points": [0, 2]}],
    "constraints": [{"kind": "rod", "pairs": [[0,1],[1,2]]}],
    "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}]})");

  const Ended ended = find_at_rest(folder, wire);

  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(ended.out.find("largest force"), std::string::npos) << ended.out;
  const json summary = json::parse(read_text(folder / "at_rest/summary.json"));
  EXPECT_FALSE(summary["equilibrium"]["multipliers_unique"]);
  EXPECT_TRUE(summary["equilibrium"]["largest_force"].is_null());
  EXPECT_EQ(summary["final"]["multipliers"], json::parse("[null, null]"));
}

TEST(EquilibriumTest, UnstableEquilibriumIsExitCode3) {
  const Folder folder;
  json up = hanging;
  up["points"] = {{"positions", {{0, 0, 0}, {0, 0, 1}, {0, 0, 2}}}, {"masses", 1}};
  up["supports"] = {{{"points", {0}}}};
  up["constraints"] = {{{"kind", "rod"}, {"pairs", {{0, 1}, {1, 2}}}}};
  up["forces"] = {hanging["forces"][0]};
  up["equilibrium"] = {{"method", "newton"}};

  const Ended ended = find_at_rest(folder, up);

  EXPECT_EQ(ended.code, 3);
  EXPECT_NE(ended.err.find("unstable in 4 directions"), std::string::npos) << ended.err;
  EXPECT_EQ(json::parse(read_text(folder / "at_rest/summary.json"))["equilibrium"]["status"], "unstable");
}

TEST(EquilibriumTest, SystemWithoutAnEquilibriumIsExitCode3) {
  const Folder folder;
  json falling = hanging;
  falling["supports"] = json::array();

  const Ended ended = find_at_rest(folder, falling);

  EXPECT_EQ(ended.code, 3);
  EXPECT_NE(ended.err.find("gravity pulls the free island 0"), std::string::npos) << ended.err;
}

TEST(EquilibriumTest, BadInputIsNamedByItsPlace) {
  const std::vector<std::pair<std::string, std::string>> wrong{
      {R"({"tolerance": 1})", "/equilibrium/tolerance"},
      {R"([])", "/equilibrium"},
      {R"({"method": "simplex"})", "/equilibrium/method"},
      {R"({"accept": true})", "/equilibrium/accept"},
      {R"({"accept": "unstable"})", "/equilibrium/accept"},
      {R"({"force_tolerance": 0})", "/equilibrium/force_tolerance"},
      {R"({"force_tolerance": -1e-10})", "/equilibrium/force_tolerance"},
      {R"({"force_tolerance": "small"})", "/equilibrium/force_tolerance"},
      {R"({"max_iterations": 0.5})", "/equilibrium/max_iterations"},
      {R"({"max_iterations": 0})", "/equilibrium/max_iterations"},
      {R"({"load_steps": 0})", "/equilibrium/load_steps"},
      {R"({"load_steps": 1.5})", "/equilibrium/load_steps"},
      {R"({"friction": true})", "/equilibrium/friction"},
      {R"({"prestress": {"rods": "tight"}})", "/equilibrium/prestress/rods"},
      {R"({"prestress": {"rods": [1, "tight", 2]}})", "/equilibrium/prestress/rods/1"},
      {R"({"at": "noon"})", "/equilibrium/at"},
      {R"({"time": "stop"})", "/equilibrium/time"},
      {R"({"friction": "keep"})", "/equilibrium/friction"},
      {R"({"prestress": 5})", "/equilibrium/prestress"},
      {R"({"prestress": {"ropes": 5}})", "/equilibrium/prestress/ropes"},
      {R"({"prestress": {"rods": [1, 2]}})", "/equilibrium/prestress/rods"}};
  for (const auto& [entry, place] : wrong) {
    const Folder folder;
    json scene = hanging;
    scene["equilibrium"] = json::parse(entry);

    const Ended ended = find_at_rest(folder, scene);

    EXPECT_EQ(ended.code, 2) << entry;
    EXPECT_NE(ended.err.find(place + ":"), std::string::npos) << ended.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "at_rest"));
  }
}

TEST(EquilibriumTest, TellsTheModesThatAreAskedForAndSoDoesModesOfItsScene) {
  const Folder folder;
  write_text(folder / "s.json", hanging.dump());

  const Ended ended = run_program(folder, {"equilibrium", "s.json", "--out", "at_rest", "--modes", "2"});
  const Ended again = run_program(folder, {"modes", "at_rest/equilibrium.json", "--count", "3", "--out", "again"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  ASSERT_EQ(again.code, 0) << again.err;
  const json summary = json::parse(read_text(folder / "at_rest/summary.json"));
  const json omega = summary["modes"]["omega"], other = json::parse(read_text(folder / "again/summary.json"))["modes"];
  ASSERT_EQ(omega.size(), 2u);
  ASSERT_EQ(other["omega"].size(), 3u);
  EXPECT_NEAR(omega[0].get<double>(), std::sqrt(summary["equilibrium"]["lowest_omega2"].get<double>()), 1e-9);
  for (std::size_t k = 0; k < 2; ++k) EXPECT_NEAR(omega[k].get<double>(), other["omega"][k].get<double>(), 1e-8);
  EXPECT_NE(read_text(folder / "at_rest/shapes.npy").find("'shape': (2, 4, 3)"), std::string::npos);
}

TEST(EquilibriumTest, WrongNumbersOfModesAreRefused) {
  for (const char* count : {"0", "-1", "2.5", "many"}) {
    const Folder folder;
    write_text(folder / "s.json", hanging.dump());

    const Ended ended = run_program(folder, {"equilibrium", "s.json", "--out", "at_rest", "--modes", count});

    EXPECT_EQ(ended.code, 2) << count;
    EXPECT_NE(ended.err.find("--modes"), std::string::npos) << ended.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "at_rest"));
  }
}

TEST(EquilibriumTest, SearchThatEndsEarlyIsExitCode3WithTheBestResidualAndItsPlace) {
  const Folder folder;
  json scene = hanging;
  scene["equilibrium"] = {{"max_iterations", 1}};

  const Ended ended = find_at_rest(folder, scene);

  EXPECT_EQ(ended.code, 3);
  EXPECT_NE(ended.err.find("after 1 iteration; best residual"), std::string::npos) << ended.err;
  EXPECT_NE(ended.err.find("at point"), std::string::npos) << ended.err;
  EXPECT_EQ(json::parse(read_text(folder / "at_rest/summary.json"))["equilibrium"]["status"], "none");
}

/// A square with both diagonals can have a self-stress, and its stiffness across its plane depends on that.
TEST(EquilibriumTest, ModesThatASelfStressDecidesAreExitCode3) {
  const Folder folder;
  const json square = json::parse(R"({
    "tanor_scene": 1, "points": {"positions": [[0,0,0], [1,0,0], [1,1,0], [0,1,0]], "masses": 1},
    "constraints": [{"name": "bars", "kind": "rod", "pairs": [[0,1],[1,2],[2,3],[3,0],[0,2],[1,3]]}],
    "equilibrium": {"accept": "any"}})");
  write_text(folder / "s.json", square.dump());

  const Ended ended = run_program(folder, {"equilibrium", "s.json", "--out", "at_rest", "--modes", "2"});

  EXPECT_EQ(ended.code, 3) << ended.err;
  EXPECT_NE(ended.err.find("bars["), std::string::npos) << ended.err;
  EXPECT_NE(ended.err.find("a prestress must be given"), std::string::npos) << ended.err;
  EXPECT_TRUE(json::parse(read_text(folder / "at_rest/summary.json"))["modes"].is_null());
}

/// A taut wire without load holds its points, but its tension is not determined.
TEST(EquilibriumTest, ModesOfAWireWithoutLoadAreExitCode3) {
  const Folder folder;
  const json wire = json::parse(R"({
    "tanor_scene": 1, "points": {"positions": [[0,0,0], [1,0,0], [2,0,0]], "masses": 1}, "supports": [{"points": [0, 2]}],
    "constraints": [{"name": "wire", "kind": "rod", "pairs": [[0,1],[1,2]]}], "equilibrium": {"accept": "any"}})");
  write_text(folder / "s.json", wire.dump());

  const Ended ended = run_program(folder, {"equilibrium", "s.json", "--out", "at_rest", "--modes", "all"});

  EXPECT_EQ(ended.code, 3) << ended.err;
  EXPECT_NE(ended.err.find("a prestress must be given"), std::string::npos) << ended.err;
}

/// The last bead of the line would hang below the floor. All members keep their numbers in the scene at rest.
TEST(EquilibriumTest, EquilibriumOnAFloorIsWrittenAsASceneThatRuns) {
  const Folder folder;
  json scene = hanging;
  scene["constraints"].push_back(
      {{"name", "floor"}, {"kind", "plane"}, {"points", {1, 2}}, {"normal", {0, 0, 1}}, {"offset", {-2, -0.3}}});
  scene["constraints"].push_back(
      {{"name", "far"}, {"kind", "plane"}, {"points", {1}}, {"normal", {0, 0, 1}}, {"offset", -9}});
  scene["equilibrium"] = {{"one_sided", {{"floor", "at_least"}, {"far", "at_least"}}}};
  scene["constraints"].push_back({{"name", "far2"}, {"kind", "plane"}, {"points", {1}}, {"normal", {0, 1, 0}}});
  scene["observe"] = {"force(floor).z",
                      "force(floor[0]).z",
                      "force(floor[1]).z",
                      "force(far)",
                      "force( far ).x",
                      "sum force( floor ).z",
                      "force(far2).z",
                      {{"what", "multiplier(far)"}, {"name", "m"}},
                      {{"what", "position(1).z"}, {"name", "far off"}}};
  scene["events"] = {{{"when", "t > 5"}, {"do", "release"}, {"of", "far"}},
                     {{"when", "t > 5"}, {"do", "release"}, {"of", "floor[1]"}},
                     {{"when", "t > 6"}, {"do", "release"}, {"of", "far2"}},
                     {{"name", "far"}, {"when", "t > 5"}, {"do", "report"}}};

  const Ended ended = find_at_rest(folder, scene);
  const Ended again = run_program(folder, {"equilibrium", "at_rest/equilibrium.json", "--out", "again"});
  const Ended run = run_program(folder, {"run", "at_rest/equilibrium.json", "--out", "run"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  const json summary = json::parse(read_text(folder / "at_rest/summary.json"));
  EXPECT_EQ(summary["one_sided"],
            json::parse(R"({"floor": {"closed": [1], "members": 2}, "far": {"closed": [], "members": 1}})"));
  EXPECT_NEAR(summary["final"]["positions"][2][2].get<double>(), -0.3, 1e-12);
  EXPECT_GT(summary["final"]["multipliers"][4].get<double>(), 1.0);
  const json at_rest = json::parse(read_text(folder / "at_rest/equilibrium.json"));
  EXPECT_EQ(at_rest["constraints"][1]["points"], json::parse("[1, 2]"));
  EXPECT_EQ(at_rest["constraints"][1]["offset"], json::parse("[-2, -0.3]"));
  EXPECT_EQ(at_rest["constraints"][1]["side"], "at_least");
  EXPECT_EQ(at_rest["constraints"].size(), 4u);
  EXPECT_EQ(at_rest["observe"], scene["observe"]);
  EXPECT_EQ(at_rest["events"], scene["events"]);
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_EQ(run.code, 0) << run.err;
}

TEST(EquilibriumTest, OneSidedConstraintsAreNamedAndHaveASide) {
  const Folder folder;
  for (const auto& [sides, place] :
       {std::pair{R"({"floor": "at_least"})", "/equilibrium/one_sided/floor: no constraint"},
        {R"({"rods": "above"})", "/equilibrium/one_sided/rods: found string \"above\""},
        {R"(["rods"])", "/equilibrium/one_sided: found"}}) {
    json scene = hanging;
    scene["equilibrium"] = {{"one_sided", json::parse(sides)}};

    const Ended ended = find_at_rest(folder, scene);

    EXPECT_EQ(ended.code, 2);
    EXPECT_NE(ended.err.find(place), std::string::npos) << ended.err;
  }
}

TEST(EquilibriumTest, FrictionIsRefusedUnlessItIsToBeIgnored) {
  const Folder folder;
  json rough = hanging;
  rough["constraints"].push_back({{"name", "wall"}, {"kind", "plane"}, {"points", {1, 2}}, {"normal", {0, 1, 0}}});
  rough["friction"] = {{{"kind", "coulomb"}, {"at", "wall"}, {"coefficient", 0.2}}};

  const Ended refused = find_at_rest(folder, rough);
  rough["equilibrium"] = {{"friction", "ignore"}};
  const Ended ignored = find_at_rest(folder, rough);

  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("/friction/0"), std::string::npos) << refused.err;
  EXPECT_EQ(ignored.code, 0) << ignored.err;
}

}  // namespace
}  // namespace tanor::cli
