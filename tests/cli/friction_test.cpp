#include "cli/program.hpp"

namespace tanor::cli {
namespace {

using nlohmann::json;

/// Returns two beads of 1 kg on rails 2 m apart, joined by a rod that leans (tan a = 2). Both glide at 1 m/s, and a
/// force of F along the rails pulls at the lower bead, whose rail is rough.
///
///     ------o------ y = 2        rod:    R = -w/cos a
///          /                     rail:   |N| = |w| tan a
///     ----o-> F ---- y = 0       bead:   2 w + mu tan a |w| = F
///
/// mu tan a > 2 is Painlevé's case, in which F > 0 has two accelerations and F < 0 none.
std::string rails(double mu, double force, const std::string& more = "") {
  return R"({"tanor_scene": 1, "points": {"positions": [[0,0,0], [1,2,0]], "velocities": [[1,0,0], [1,0,0]]},
    "constraints": [{"name": "lower", "kind": "line", "points": [0], "origin": [0,0,0], "direction": [1,0,0]},
                    {"name": "upper", "kind": "line", "points": [1], "origin": [0,2,0], "direction": [1,0,0]},
                    {"name": "rod", "kind": "rod", "pairs": [[0,1]]}],
    "forces": [{"kind": "constant", "points": [0], "force": [)" +
         std::to_string(force) + R"(,0,0]}],
    "friction": [{"name": "rust", "kind": "coulomb", "at": "lower", "coefficient": )" +
         std::to_string(mu) + "}]" + (more.empty() ? "" : ", " + more) + "}";
}

json solve(const Folder& folder, const std::string& scene) {
  write_text(folder / "s.json", scene);
  const Ended ended = run_program(folder, {"solve", "s.json"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  return json::parse(ended.out);
}

TEST(FrictionTest, SolveTellsFrictionAndHowItWasFound) {
  const Folder folder;
  for (const char* method : {"auto", "fixed_point", "anderson", "newton", "enumeration"}) {
    // With mu tan a = 1, w = F/3 to the right and F/1 to the left.
    const std::string solver = R"("solver": {"friction": ")" + std::string(method) + R"("})";
    for (const auto& [force, acceleration] : {std::pair{6.0, 2.0}, std::pair{-6.0, -6.0}}) {
      const json solution = solve(folder, rails(0.5, force, solver));

      EXPECT_NEAR(solution["accelerations"][0][0], acceleration, 1e-11) << method;
      EXPECT_NEAR(solution["friction"][0][0], -std::abs(acceleration), 1e-11) << method;
      EXPECT_EQ(solution["friction"][1], json({0, 0, 0})) << method;
      EXPECT_EQ(solution["multipliers"].size(), 5u) << "as many as equations";
      EXPECT_EQ(solution["multipliers_unique"].size(), 5u);
      const json& report = solution["friction_report"];
      EXPECT_EQ(report["contacts"], 1);
      EXPECT_EQ(report["sticking"], 0);
      // Newton's method begins at the counted solution and has no step left to make.
      if (method == std::string("newton")) {
        EXPECT_EQ(report["iterations"], 0);
      } else {
        EXPECT_GT(report["iterations"], 0) << method;
      }
      EXPECT_EQ(report["uniqueness"], "proven") << method;
      EXPECT_TRUE(report["method_used"].is_string());
    }
  }
}

TEST(FrictionTest, SolveTellsThatViscousFrictionNeedsNoIteration) {
  const Folder folder;
  const json solution = solve(folder, R"({"tanor_scene": 1,
    "points": {"positions": [[0,0,0]], "velocities": [[3,0,0]], "masses": 2},
    "constraints": [{"name": "floor", "kind": "plane", "points": [0], "normal": [0,0,1]}],
    "friction": [{"kind": "viscous", "at": "floor", "coefficient": 4, "velocity": [1,0,0]}]})");

  // tau = -c (v - u)
  EXPECT_EQ(solution["friction"][0], json({-8.0, 0.0, 0.0}));
  EXPECT_NEAR(solution["accelerations"][0][0], -4.0, 1e-14);
  EXPECT_TRUE(solution["friction_report"]["iterations"].is_null());
  EXPECT_TRUE(solution["friction_report"]["method_used"].is_null());
}

TEST(FrictionTest, WhereNoAccelerationObeysTheLawTheProgramEndsWithThree) {
  const Folder folder;
  write_text(folder / "s.json", rails(2.0, -6.0));

  const Ended ended = run_program(folder, {"solve", "s.json"});

  EXPECT_EQ(ended.code, 3);
  EXPECT_TRUE(contains(ended.err, "rust") && contains(ended.err, "no accelerations obey the law")) << ended.err;
  const json solution = json::parse(ended.out);
  EXPECT_TRUE(solution["friction"].is_null()) << "nothing is claimed";
  EXPECT_EQ(solution["friction_report"]["uniqueness"], "none");
}

TEST(FrictionTest, WhereTwoAccelerationsObeyTheLawTheProgramEndsWithThree) {
  const Folder folder;
  write_text(folder / "s.json", rails(2.0, 6.0));

  for (const char* command : {"solve", "check"}) {
    const Ended ended = run_program(folder, {command, "s.json"});

    EXPECT_EQ(ended.code, 3);
    EXPECT_TRUE(contains(ended.err, "rust") && contains(ended.err, "accelerations obey the law")) << ended.err;
  }
}

TEST(FrictionTest, BeadsOfAChainOnARoughFloorGiveWayOneAfterAnother) {
  // The first bead is a support that draws the chain backwards by 0.05 t^2 exp(-t/10).
  constexpr int count = 20;
  json positions = {{0.0, 0.0, 0.0}}, pairs = json::array();
  for (int i = 1; i < count; ++i) {
    const double angle = 0.6 * std::sin(0.7 * i) + 0.3 * std::sin(0.13 * i), x = positions.back()[0],
                 y = positions.back()[1];
    positions.push_back({x + 0.1 * std::cos(angle), y + 0.1 * std::sin(angle), 0.0});
    pairs.push_back({i - 1, i});
  }
  json scene = json::parse(R"json({"tanor_scene": 1, "points": {"masses": 0.1},
    "supports": [{"points": [0], "motion": {"formula": ["-0.05*t^2*exp(-0.1*t)", "0", "0"]}}],
    "constraints": [{"name": "rods", "kind": "rod"},
                    {"name": "floor", "kind": "plane", "normal": [0,0,1], "offset": 0}],
    "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}],
    "friction": [{"kind": "coulomb", "at": "floor", "coefficient": 0.3}],
    "motion": {"method": "dop853", "t_end": 5, "rtol": 1e-10, "atol": 1e-12}})json");
  scene["points"]["positions"] = positions;
  scene["constraints"][0]["pairs"] = pairs;
  scene["constraints"][1]["points"] = {{"first", 1}, {"count", count - 1}, {"stride", 1}};
  const Folder folder;
  write_text(folder / "s.json", scene.dump());
  const Ended ended = run_program(folder, {"run", "s.json", "--out", "out"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  const std::string last = "; last change at t = ", page = read_text(folder / "out/report.txt");
  ASSERT_TRUE(contains(page, last)) << page;
  EXPECT_TRUE(contains(page.substr(page.find(last), 60), ": coulomb0 at floor[")) << page;
  const json summary = json::parse(read_text(folder / "out" / "summary.json"));
  EXPECT_EQ(summary["t_reached"], 5.0);
  EXPECT_LT(std::abs(summary["energy"]["drift_relative"].get<double>()), 1e-8);
  EXPECT_GE(summary["contact_changes"], count - 1) << "each gives way for itself";
}

TEST(FrictionTest, TwoParallelPlanesAreNoWire) {
  const Folder folder;
  for (const char* velocity : {"[0,0,0]", "[1,0,0]"}) {
    write_text(folder / "s.json", R"({"tanor_scene": 1,
      "points": {"positions": [[0,0,0]], "velocities": [)" +
                                      std::string(velocity) + R"(]},
      "constraints": [{"name": "floor", "kind": "plane", "points": [0], "normal": [0,0,1], "offset": 0},
                      {"name": "table", "kind": "plane", "points": [0], "normal": [0,0,-2], "offset": 0}],
      "forces": [{"kind": "gravity", "acceleration": [1,0,-10]}],
      "friction": [{"name": "rust", "kind": "coulomb", "at": ["floor", "table"], "coefficient": 0.2}],
      "motion": {"t_end": 0.1}})");
    for (const char* command : {"solve", "run"}) {
      const Ended ended = run_program(folder, {command, "s.json"});

      EXPECT_EQ(ended.code, 3) << command << ": " << ended.out;
      EXPECT_NE(ended.err.find("rust at floor[0], point 0: its two surfaces are parallel"), std::string::npos)
          << ended.err;
      EXPECT_EQ(ended.out.find("nan"), std::string::npos) << ended.out;
    }
  }
}

TEST(FrictionTest, InfoAndCheckTellContactsAndLaws) {
  const Folder folder;
  write_text(folder / "s.json", rails(0.5, 6.0));
  write_text(folder / "smooth.json", pendulum(""));

  const std::string line = "friction:                rust (coulomb, exact, 1 contact)\n";
  EXPECT_TRUE(contains(run_program(folder, {"info", "s.json"}).out, line));
  const Ended ended = run_program(folder, {"check", "s.json"});
  EXPECT_TRUE(contains(ended.out, line)) << ended.out;
  EXPECT_TRUE(contains(ended.out, "friction found:          1 contact, 0 stick, ")) << ended.out;
  EXPECT_TRUE(contains(ended.out, "uniqueness proven")) << ended.out;
  EXPECT_EQ(ended.code, 0) << ended.err;
  for (const char* words :
       {"Newton's law", "law of friction", "found another way", "certificate:             certified to "})
    EXPECT_TRUE(contains(ended.out, words)) << words << " is missing in\n" << ended.out;
  const Ended verbose = run_program(folder, {"check", "s.json", "--verbose"});
  for (const char* symbols :
       {"M w = f + tau + K lambda", "tau = tau(r, v, t, lambda) (41)", "K lambda by (43) = K lambda"})
    EXPECT_TRUE(contains(verbose.out, symbols)) << symbols << " is missing in\n" << verbose.out;
  EXPECT_TRUE(contains(run_program(folder, {"info", "smooth.json"}).out, "friction:                none\n"));
  EXPECT_FALSE(contains(run_program(folder, {"check", "smooth.json"}).out, "friction"));
}

TEST(FrictionTest, ARunTellsFrictionOnItsPage) {
  const Folder folder;
  write_text(folder / "s.json", rails(0.5, 6.0, R"("motion": {"t_end": 0.1})"));

  const Ended ended = run_program(folder, {"run", "s.json", "--out", "o"});

  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_TRUE(contains(ended.out, "  friction      rust (coulomb, exact, 1 contact); ")) << ended.out;
  const json summary = read_json(folder / "o" / "summary.json");
  EXPECT_EQ(summary["friction"]["contacts"], 1);
  EXPECT_EQ(summary["certificate"]["verdict"].get<std::string>().rfind("certified to ", 0), 0u);
  EXPECT_LT(summary["certificate"]["friction"], 1e-12);
}

TEST(FrictionTest, BadFrictionIsOneLineAndNothingIsWritten) {
  const Folder folder;
  write_text(folder / "negative.json", rails(-0.5, 6.0, R"("motion": {"t_end": 1})"));
  std::string scene = rails(0.5, 6.0, R"("motion": {"t_end": 1})");
  write_text(folder / "unknown.json", scene.replace(scene.find(R"("at": "lower")"), 13, R"("at": "rails")"));

  for (const std::string command : {"run", "solve", "info", "check"}) {
    EXPECT_EQ(complaint(folder, {command, "negative.json"}),
              "tanor: negative.json: /friction/0/coefficient: found number -0.5, wanted a number >= 0\n");
    EXPECT_EQ(complaint(folder, {command, "unknown.json"}),
              "tanor: unknown.json: /friction/0/at: \"rails\" is the name of no constraint; a plane, sphere, line, "
              "circle, ellipsoid, helix or formula of single points is right\n");
  }
}

/// Two beads rest, as the enumeration of all modes finds, with a share of the load that is not the smallest one.
TEST(FrictionTest, TheShareThatWasCountedIsTheAnswer) {
  const Folder folder;

  const Ended solved = run_program(folder, {"solve", TANOR_TEST_DATA "/friction_share.json"});
  const Ended ran = run_program(folder, {"run", TANOR_TEST_DATA "/friction_share.json", "--out", "o"});

  ASSERT_EQ(solved.code, 0) << solved.err;
  EXPECT_EQ(ran.code, 0) << ran.err;
  const nlohmann::json answer = nlohmann::json::parse(solved.out);
  EXPECT_EQ(answer["friction_report"]["uniqueness"], "proven");
  EXPECT_EQ(answer["friction_report"]["sticking"], 2);
  for (const nlohmann::json& w : answer["accelerations"]) {
    for (const nlohmann::json& a : w) EXPECT_NEAR(a.get<double>(), 0.0, 1e-11);
  }
  EXPECT_EQ(read_json(folder / "o" / "summary.json")["friction"]["uniqueness"], "proven");
}

/// Returns beads on lines along x, side by side and joined by rods or springs. A growing force draws them until all
/// have slid.
std::string make_row(std::size_t count, double beside, bool by_springs) {
  nlohmann::json positions = nlohmann::json::array(), constraints = positions, pairs = positions, friction = positions;
  for (std::size_t k = 0; k < count; ++k) {
    const nlohmann::json r = {1.0 * static_cast<double>(k), k % 2 == 1 ? beside : 0.0, 0.0};
    const std::string name = "l" + std::to_string(k);
    positions.push_back(r);
    constraints.push_back(
        {{"kind", "line"}, {"name", name}, {"points", {k}}, {"origin", r}, {"direction", {1.0, 0.0, 0.0}}});
    friction.push_back({{"kind", "coulomb"}, {"at", name}, {"coefficient", 0.3}});
    if (k > 0) pairs.push_back({k - 1, k});
  }
  nlohmann::json forces = nlohmann::json::array({{{"kind", "gravity"}, {"acceleration", {0.0, 0.0, -10.0}}}});
  if (by_springs)
    forces.push_back({{"kind", "spring"}, {"pairs", pairs}, {"stiffness", 100.0}, {"rest_length", 1.0}});
  else
    constraints.push_back({{"kind", "rod"}, {"pairs", pairs}});
  const std::string pull = std::to_string(6 * count) + "*t";
  forces.push_back({{"kind", "constant"}, {"points", {count - 1}}, {"force", {{"formula", {pull, "0", "0"}}}}});
  return nlohmann::json{
      {"tanor_scene", 1},           {"points", {{"positions", positions}, {"masses", std::vector<double>(count, 1.0)}}},
      {"constraints", constraints}, {"forces", forces},
      {"friction", friction},       {"motion", {{"t_end", 1.0}}}}
      .dump();
}

TEST(FrictionTest, UniquenessOfManyContactsIsSaidWithItsReason) {
  struct Row {
    std::size_t count;
    double beside;
    bool by_springs;
    const char* uniqueness;
  };
  // In a straight row friction changes no reaction, beads that springs join do not feel each other's friction at all,
  // and rods that are inclined press beads into their lines.
  for (const Row& row : {Row{4, 0.0, true, "proven"}, Row{14, 0.0, true, "proven"}, Row{14, 0.0, false, "proven"},
                         Row{80, 0.0, false, "proven"}, Row{14, 0.5, false, "unproven"}}) {
    SCOPED_TRACE(std::to_string(row.count) + " beads, " + (row.by_springs ? "springs" : "rods"));
    const Folder folder;
    write_text(folder / "s.json", make_row(row.count, row.beside, row.by_springs));

    const Ended ended = run_program(folder, {"run", "s.json", "--out", "o"});

    ASSERT_EQ(ended.code, 0) << ended.err;
    const nlohmann::json summary = read_json(folder / "o" / "summary.json");
    EXPECT_GT(summary["contact_changes"].get<int>(), 0);
    EXPECT_EQ(summary["friction"]["uniqueness"], row.uniqueness) << summary["friction"]["uniqueness_reason"];
    EXPECT_EQ(summary["friction"]["uniqueness_reason"].is_null(), std::string(row.uniqueness) == "proven");
  }
}

/// A bead is on two lines that are one. The distribution of its weight on them is a convention, and so is the friction.
TEST(FrictionTest, ChecksOfAConventionAreLeftOutOfTheCertificate) {
  const Folder folder;
  write_text(folder / "s.json", R"({"tanor_scene": 1,
    "points": {"positions": [[0,0,0], [1,0.3,0.2]], "velocities": [[1,0,0], [1,0,0]], "masses": [1, 2]},
    "constraints": [{"kind": "line", "name": "a", "points": [0], "origin": [0,0,0], "direction": [1,0,0]},
                    {"kind": "line", "name": "b", "points": [0], "origin": [0,0,0], "direction": [1,0,0]},
                    {"kind": "line", "name": "l", "points": [1], "origin": [1,0.3,0.2], "direction": [1,0,0]},
                    {"kind": "rod", "pairs": [[0,1]]}],
    "forces": [{"kind": "gravity", "acceleration": [0,0,-10]}],
    "friction": [{"kind": "coulomb", "at": "a", "coefficient": 0.3}, {"kind": "coulomb", "at": "l", "coefficient": 0.2}]})");

  const Ended ended = run_program(folder, {"check", "s.json"});

  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_FALSE(contains(ended.out, "with friction, found another way")) << ended.out;
  EXPECT_TRUE(contains(ended.out,
                       "friction found another way: constraints that depend on each other share the reaction of "
                       "coulomb0 at a[0], point 0 by convention"))
      << ended.out;
}

}  // namespace
}  // namespace tanor::cli
