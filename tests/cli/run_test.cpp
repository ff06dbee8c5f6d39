#include <array>
#include <cmath>
#include <regex>

#include "cli/program.hpp"

namespace tanor::cli {
namespace {

using nlohmann::json;
using report::read_xyz;
using report::XyzFrame;

std::vector<double> list_times(const std::filesystem::path& xyz) {
  std::vector<double> times;
  for (const XyzFrame& frame : read_xyz(xyz)) times.push_back(frame.time);
  return times;
}

TEST(RunTest, CertificateIsMadeAsOftenAsItIsWanted) {
  for (const std::string policy : {R"("always")", R"({"every": 3})", R"("final")"}) {
    const Folder folder;
    write_text(folder / "s.json",
               R"({"tanor_scene": 1, "points": {"positions": [[0, 0, 0], [1, 0, 0]]}, "supports": [{"points": [0]}],
                   "constraints": [{"kind": "rod", "pairs": [[0, 1]]}],
                   "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
                   "motion": {"method": "rk4", "step": 0.01, "t_end": 0.1}, "solver": {"certificate": )" +
                   policy + "}}");

    const Ended ended = run_program(folder, {"run", "s.json"});

    EXPECT_EQ(ended.code, 0) << policy << ended.err;
    EXPECT_TRUE(contains(ended.out, "certified to")) << ended.out;
    const json summary = read_json(folder / "s.out/summary.json");
    // `always` makes one for each of ten steps and one at the end.
    EXPECT_EQ(summary["certificates"], policy == R"("always")" ? 11 : policy == R"("final")" ? 1 : 4) << policy;
    // Ten steps take four factorizations each and the start one or more, so that certificates are no work of the
    // motion.
    EXPECT_NEAR(summary["factorizations"].get<double>(), 43.0, 2.0) << policy;
  }
}

TEST(RunTest, TellsWhatAnEventDid) {
  const Folder folder;
  write_text(folder / "s.json",
             R"({"tanor_scene": 1, "units": "si", "points": {"positions": [[0, 0, 0], [1, 0, 0]]},
                 "supports": [{"name": "hook", "points": [0]}],
                 "constraints": [{"name": "rod", "kind": "rod", "pairs": [[0, 1]]}],
                 "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
                 "events": [{"name": "high", "when": "t > 0.1", "do": "report"},
                            {"name": "tears", "when": "tension(rod) > 20", "do": "break"},
                            {"name": "end", "when": "t > 0.7", "do": "stop"}],
                 "motion": {"t_end": 1}})");

  const Ended ended = run_program(folder, {"run", "s.json", "--report"});

  EXPECT_EQ(ended.code, 0) << ended.err;
  const std::string rest = "tears: rod[0] breaks; point 1 is without constraints";
  EXPECT_TRUE(contains(ended.out, "high\n")) << ended.out;
  EXPECT_TRUE(contains(ended.out, rest)) << ended.out;
  EXPECT_TRUE(contains(ended.out, "end: the run stops\n")) << ended.out;
  const json passages = read_json(folder / "s.out/summary.json").at("passages");
  EXPECT_EQ(passages[1].at("do"), "break");
  const std::string page = folder / "s.out/report.html";
  if (!std::filesystem::exists(page)) GTEST_SKIP() << "this program makes no page";
  EXPECT_TRUE(contains(read_text(page), rest));
  EXPECT_TRUE(contains(read_text(page), R"("support_names":["hook"])"));
}

/// Pages show 0 for what is rounding beside 29.43 N, 78 J or 1000 N/m times 4 m; files have its digits.
TEST(RunTest, PagesShowNoRoundingBesideForcesEnergiesAndSprings) {
  const Folder folder;
  write_text(folder / "s.json", R"json({
    "tanor_scene": 1, "units": "si",
    "points": {"positions": [[0,0,0], [4,0,0], [0,0,-0.7], [9,0,0]], "masses": [1, 2, 3, 1]},
    "supports": [{"points": [0, 3]}],
    "constraints": [{"name": "links", "kind": "rod", "pairs": [[0,1], [0,2]]}],
    "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]},
               {"name": "s", "kind": "spring", "pairs": [[0,1]], "stiffness": 1000},
               {"kind": "constant", "points": [2], "force": [0, 0, 0.1]}],
    "events": [{"name": "snap", "when": "t > 0.3", "do": "break", "of": "s[0]"}],
    "observe": ["acceleration(2)", "velocity(2)", "energy()", "tension(s)"], "motion": {"t_end": 1, "rtol": 1e-13}})json");

  const Ended ended = run_program(folder, {"run", "s.json", "--report"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  const std::string table = read_text(folder / "s.out/observables.csv");
  EXPECT_TRUE(std::regex_search(table, std::regex("e-1[0-9]"))) << "the scene tests nothing: " << table;
  const std::string said = ended.out.substr(0, ended.out.find("method"));
  EXPECT_FALSE(std::regex_search(said, std::regex("e-[0-9][0-9] (N|J|m/s)"))) << said;
  EXPECT_TRUE(contains(ended.out, "energy        -20.531 J at the start")) << ended.out;
  const std::string page = folder / "s.out/report.html";
  if (!std::filesystem::exists(page)) GTEST_SKIP() << "this program makes no page";
  const std::string html = read_text(page);
  const std::size_t begin = html.find("id=\"data\">") + 10;
  const json shown = json::parse(html.substr(begin, html.find("</script>", begin) - begin));
  for (const char* const key : {"energy", "kinetic", "potential"})
    for (const json& each : shown.at("history").at(key))
      EXPECT_TRUE(each == 0.0 || std::abs(each.get<double>()) > 1e-8) << key << each;
}

TEST(RunTest, WritesItsFolder) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.35, "output_every": 0.1)"));

  const Ended ended = run_program(folder, {"run", "s.json"});

  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(ended.out, read_text(folder / "s.out/report.txt"));
  EXPECT_LT(ended.out.find("max tension(rods)"), ended.out.find("certificate "));
  EXPECT_LT(ended.out.find("certificate "), ended.out.find("left out ")) << "what comes for answers reads them first";
  EXPECT_TRUE(contains(ended.err, "t = 0.35 reached")) << ended.err;
  EXPECT_EQ(list_names(folder / "s.out"), (Words{"checkpoint", "observables.csv", "report.txt", "summary.json",
                                                 "trajectory", "trajectory.pvd", "trajectory.xyz"}));
  EXPECT_EQ(list_names(folder / "s.out/trajectory").size(), 5u);
  EXPECT_EQ(list_times(folder / "s.out/trajectory.xyz"), (std::vector<double>{0, 0.1, 0.2, 3 * 0.1, 0.35}));
  const json summary = read_json(folder / "s.out/summary.json");
  EXPECT_EQ(summary["scene"], "pendulum");
  EXPECT_EQ(summary["source"], "inline");
  EXPECT_EQ(summary["t_reached"], 0.35);
  EXPECT_EQ(summary["form"], "normal");
  EXPECT_EQ(summary["rank"], 2);
  EXPECT_EQ(summary["degrees_of_freedom"], 4);
  EXPECT_LT(summary["violation"]["position_max"], 1e-9);
  EXPECT_LT(std::abs(summary["energy"]["drift_relative"].get<double>()), 1e-6);
  EXPECT_GT(summary["wall_s"]["total"], 0.0);
  EXPECT_GT(summary["threads"], 0);
  EXPECT_TRUE(summary.at("accuracy_warning").is_null());
  EXPECT_TRUE(summary.at("doubt").is_null());
}

/// A motion may end before t = 0, or at it. Tables then reach from its start to its end.
TEST(RunTest, MotionsBeforeZeroRun) {
  const Folder folder;
  write_text(folder / "pull.csv", "-5,1,0,0\n-4,1,0,0\n-3,1,0,0\n");
  write_text(folder / "free.json", R"({"tanor_scene": 1, "points": {"positions": [[0,0,0]], "velocities": [[1,0,0]]},
    "motion": {"t_start": -5, "t_end": -3}})");
  write_text(folder / "pulled.json", R"({"tanor_scene": 1, "points": {"positions": [[0,0,0]]},
    "forces": [{"kind": "constant", "points": [0], "force": {"table": "pull.csv"}}],
    "motion": {"t_start": -5, "t_end": -3, "output_every": 0.5}})");
  const auto end_of = [&](const char* name) {
    return read_xyz(folder / (std::string(name) + ".out/trajectory.xyz")).back();
  };

  for (const char* const name : {"free", "pulled"}) {
    const Ended ended = run_program(folder, {"run", std::string(name) + ".json"});

    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_EQ(read_json(folder / (std::string(name) + ".out/summary.json"))["t_reached"], -3.0);
    EXPECT_NEAR(end_of(name).positions[0], 2.0, 1e-8) << name;
  }
  EXPECT_EQ(list_times(folder / "pulled.out/trajectory.xyz"), (std::vector<double>{-5, -4.5, -4, -3.5, -3}));

  const Ended at_zero = run_program(folder, {"run", "free.json", "--t-end", "0", "--overwrite"});
  EXPECT_EQ(at_zero.code, 0) << at_zero.err;
  EXPECT_NEAR(end_of("free").positions[0], 5.0, 1e-8);

  const Ended too_early = run_program(folder, {"run", "free.json", "--t-end=-5", "--overwrite"});
  EXPECT_EQ(too_early.code, 2);
  EXPECT_TRUE(contains(too_early.err, "--t-end: found number -5, wanted a time after t_start = -5")) << too_early.err;
}

/// The last output time is a bit behind the table's end.
TEST(RunTest, ATableThatReachesTheEndReachesTheLastOutputTime) {
  const Folder folder;
  write_text(folder / "drive.csv", "0,0,0,0\n0.1,0,0,0.01\n0.2,0,0,0.04\n0.3,0,0,0.09\n");
  write_text(folder / "s.json", R"({"tanor_scene": 1, "points": {"positions": [[0,0,0], [0.1,0,0]]},
    "supports": [{"points": [0], "motion": {"table": "drive.csv"}}],
    "constraints": [{"kind": "rod", "pairs": [[0,1]]}], "motion": {"t_end": 0.3, "output_every": 0.1}})");

  const Ended ended = run_program(folder, {"run", "s.json", "--out", "o"});

  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(read_json(folder / "o/summary.json")["t_reached"], 3 * 0.1);
}

TEST(RunTest, AFolderIsNamedAsAShellTakesIt) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.1)"));
  for (const auto& [name, typed] :
       {std::pair{"a/b-1.out", "a/b-1.out"}, {"two words", "'two words'"}, {"it's", R"('it'\''s')"}}) {
    const Ended ended = run_program(folder, {"run", "s.json", "--out", name});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_TRUE(ended.err.ends_with(std::string("results in ") + typed + "\n")) << ended.err;
  }
}

TEST(RunTest, APageLeavesTheMotionAsItIs) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.35, "output_every": 0.1)"));

  ASSERT_EQ(run_program(folder, {"run", "s.json", "--out", "without"}).code, 0);
  const Ended ended = run_program(folder, {"run", "s.json", "--out", "with", "--report"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(read_text(folder / "with/trajectory.xyz"), read_text(folder / "without/trajectory.xyz"));
  // A program without the page says so.
  EXPECT_NE(std::filesystem::exists(folder / "with/report.html"), contains(ended.err, "there is no report.html"));
  // Pictures take its colours, also of one that a run has made on its way.
  if (std::filesystem::exists(folder / "with/report.html")) {
    const std::string ends = read_json(folder / "with/summary.json")["tension_colours"].dump();
    EXPECT_TRUE(contains(read_text(folder / "with/report.html"), R"("colours":{"tensions":)" + ends));
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "without/report.html"));
}

TEST(RunTest, ACoarseToleranceIsSaidOnStderrAndInTheSummary) {
  const Folder folder;
  write_text(folder / "s.json",
             R"({"tanor_scene": 1, "points": {"positions": [[0, 0, 0], [5e-10, 0, 0]]}, "supports": [{"points": [0]}],
                 "constraints": [{"kind": "rod", "pairs": [[0, 1]]}],
                 "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
                 "motion": {"atol": 1e-10, "t_end": 1e-5}})");

  const Ended coarse = run_program(folder, {"run", "s.json"});
  const json summary = read_json(folder / "s.out/summary.json");

  EXPECT_EQ(coarse.code, 0) << coarse.err;
  EXPECT_TRUE(contains(coarse.err, "warning: the absolute tolerance, 1e-10, is 0.2 of the size")) << coarse.err;
  EXPECT_TRUE(contains(summary.at("accuracy_warning").get<std::string>(), "absolute tolerance"));
  EXPECT_EQ(summary.at("doubt"), summary.at("accuracy_warning"));
  const Ended quiet = run_program(folder, {"run", "s.json", "--quiet"});
  EXPECT_TRUE(contains(quiet.err, "warning: the absolute tolerance")) << "quiet of progress, not of doubts";
  const Ended fine = run_program(folder, {"run", "s.json", "--atol", "1e-20"});
  EXPECT_FALSE(contains(fine.err, "warning")) << fine.err;
}

TEST(RunTest, TheCommandLineOverridesTheScene) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 100, "rtol": 1e-6)"));

  const Words arguments{"run",  "s.json", "--t-end", "0.5",       "--method", "rk4",    "--step",
                        "0.01", "--out",  "a/b",     "--threads", "1",        "--quiet"};
  const Ended ended = run_program(folder, arguments);

  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(ended.out + ended.err, "") << "quiet";
  const json summary = read_json(folder / "a/b/summary.json");
  EXPECT_EQ(summary["method"], "rk4");
  EXPECT_EQ(summary["threads"], 1);
  EXPECT_EQ(summary["steps"], 50);
  EXPECT_EQ(summary["t_end"], 0.5);
  EXPECT_EQ(list_times(folder / "a/b/trajectory.xyz"), (std::vector<double>{0, 0.5}));
}

// A tolerance on the command line replaces a step in the scene.
TEST(RunTest, TolerancesReplaceAStep) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.1, "step": 0.001)"));

  run_program(folder, {"run", "s.json", "--rtol", "1e-4", "--out", "o"});

  const json summary = read_json(folder / "o/summary.json");
  EXPECT_EQ(summary["method"], "taylor");
  EXPECT_LT(summary["steps"], 100);
}

// Only "auto" can follow a tolerance to an adaptive method.
TEST(RunTest, TolerancesLeaveTheStepOfAMethodWithFixedSteps) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.1, "step": 0.01)"));

  const Ended ended = run_program(folder, {"run", "s.json", "--method", "rk4", "--rtol", "1e-6", "--out", "o"});

  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(read_json(folder / "o/summary.json")["steps"], 10);
}

/// Returns a pendulum whose support follows a table up to t = 1 s.
std::string driven_pendulum(const std::string& motion) {
  std::string scene = pendulum(motion);
  scene.insert(scene.find(R"("points": [0])") + 13, R"(, "motion": {"table": "drive.csv"})");
  return scene;
}

TEST(RunTest, TablesMustReachTheEndOfTheCommandLine) {
  const Folder folder;
  write_text(folder / "drive.csv", "0,0,0,0\n0.25,0,0,0.1\n0.5,0,0,0\n1,0,0,0\n");
  write_text(folder / "short.json", driven_pendulum(R"("t_end": 1)"));
  write_text(folder / "long.json", driven_pendulum(R"("t_end": 1.5)"));

  EXPECT_EQ(complaint(folder, {"run", "short.json", "--t-end", "1.5"}),
            "tanor: short.json: /supports/0/motion/table: found string \"drive.csv\", wanted a table from t = 0 to "
            "t_end = 1.5, this one has 0 to 1\n");
  EXPECT_EQ(run_program(folder, {"run", "long.json", "--t-end", "1.0", "--out", "o"}).code, 0);
  EXPECT_EQ(read_json(folder / "o/summary.json")["t_reached"], 1.0);
}

TEST(RunTest, ShowsTheChosenPoints) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.1, "output_points": [2, 1])"));

  run_program(folder, {"run", "s.json", "--out", "o"});

  const std::vector<XyzFrame> frames = read_xyz(folder / "o/trajectory.xyz");
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].positions, (std::vector<double>{0.2, 0, 0, 0.1, 0, 0}));
  EXPECT_TRUE(contains(read_text(folder / "o/trajectory/frame_000001.vtp"), R"(NumberOfPoints="2")"));
  EXPECT_EQ(read_json(folder / "o/summary.json")["final"]["positions"].size(), 3u) << "the summary has all points";
}

TEST(RunTest, TheCertificateMayBeOff) {
  const Folder folder;
  std::string scene = pendulum(R"("t_end": 0.1)");
  scene.insert(scene.rfind('}'), R"(, "solver": {"certificate": "off"})");
  write_text(folder / "s.json", scene);

  run_program(folder, {"run", "s.json", "--out", "o"});

  const json summary = read_json(folder / "o/summary.json");
  EXPECT_TRUE(summary["certificate"]["residual"].is_null());
  EXPECT_TRUE(summary["stopped_by"].is_null()) << summary["stopped_by"];
}

// At t = 1 s the rods are straight.
TEST(EarlyEndTest, AFailureKeepsTheResultsUpToItsTime) {
  const Folder folder;
  write_text(folder / "s.json", overstretched());

  const Ended ended = run_program(folder, {"run", "s.json", "--out", "o", "--quiet"});

  EXPECT_EQ(ended.code, 3) << ended.err;
  EXPECT_TRUE(ended.err.starts_with("tanor: stopped at t = ")) << ended.err;
  EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1) << ended.err;
  const json summary = read_json(folder / "o/summary.json");
  const double reached = summary["t_reached"];
  EXPECT_GT(reached, 0.875);
  EXPECT_LE(reached, 1.0 + 1e-3);
  EXPECT_EQ(summary["final"]["t"], reached);
  EXPECT_EQ(summary["t_end"], 3);
  // The folder states why the run ended, for those who did not see it end.
  const std::string why = summary["stopped_by"];
  EXPECT_FALSE(why.empty());
  EXPECT_TRUE(contains(ended.err, ": " + why + "; what was found until then is in o")) << ended.err;
  EXPECT_TRUE(contains(read_text(folder / "o/report.txt"), "stopped by    " + why + "\n"));
  const std::vector<double> times = list_times(folder / "o/trajectory.xyz");
  EXPECT_EQ(times.size(), std::ceil(reached / 0.125) + 1) << "t = 0, 0.125, ... and where it stopped";
  EXPECT_EQ(times.back(), reached);

  const Ended again = run_program(folder, {"run", "s.json", "--out", "o", "--quiet"});
  EXPECT_EQ(again.code, 3) << "a run that found its end may be begun anew";
  EXPECT_EQ(again.err, ended.err);
}

TEST(EarlyEndTest, ARunWithoutAStartHasNullsForItsEnd) {
  const Folder folder;
  write_text(folder / "s.json", torn_apart());

  const Ended ended = run_program(folder, {"run", "s.json", "--out", "o"});

  EXPECT_EQ(ended.code, 3) << ended.err;
  EXPECT_TRUE(ended.err.starts_with("tanor: stopped at t = 0 of 1: ")) << ended.err;
  const json summary = read_json(folder / "o/summary.json");
  EXPECT_EQ(summary["t_reached"], 0);
  for (const auto& [key, value] : summary["final"].items()) EXPECT_TRUE(value.is_null()) << key;
  EXPECT_TRUE(summary["rank"].is_null());
  EXPECT_TRUE(summary["energy"]["start"].is_null());
  EXPECT_FALSE(summary["observables"].empty());
  for (const nlohmann::json& each : summary["observables"])
    for (const nlohmann::json& value : each["values"]) EXPECT_TRUE(value.is_null()) << each;
  EXPECT_EQ(list_times(folder / "o/trajectory.xyz").size(), 0u);
  EXPECT_FALSE(std::filesystem::exists(folder / "o/checkpoint"));
}

TEST(EarlyEndTest, ASignalFinishesTheStep) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 1e4, "output_every": 0.1, "step": 1e-3)"));

  Program program(folder, {"run", "s.json", "--out", "o", "--quiet"});
  ASSERT_TRUE(wait_for_frames(folder / "o", 4));
  kill(program.process(), SIGINT);
  const Ended ended = program.wait();

  EXPECT_EQ(ended.code, 130);
  EXPECT_TRUE(ended.err.starts_with("tanor: stopped at t = ")) << ended.err;
  EXPECT_TRUE(contains(ended.err, "SIGINT")) << ended.err;
  const json summary = read_json(folder / "o/summary.json");
  EXPECT_EQ(summary["stopped_by"], "SIGINT came");
  EXPECT_GE(summary["t_reached"], 0.3);
  EXPECT_EQ(list_times(folder / "o/trajectory.xyz").back(), summary["t_reached"]);
}

TEST(RunTest, WhatBrokeIsToldWithItsTimeAndHasNoNumbers) {
  const Folder folder;
  write_text(folder / "s.json", R"json({"tanor_scene": 1, "name": "s",
    "points": {"positions": [[0,0,0], [1,0,0]], "masses": 1}, "supports": [{"points": [0]}],
    "constraints": [{"name": "rod", "kind": "rod", "pairs": [[0,1]]}],
    "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}], "observe": ["max tension(rod)", "tension(rod)"],
    "events": [{"when": "t > 0.125", "do": "break", "of": "rod[0]"}], "motion": {"t_end": 0.5}
})json");
  const Ended ended = run_program(folder, {"run", "s.json", "--out", "o", "--report"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  const std::string page = read_text(folder / "o/report.txt"), table = read_text(folder / "o/observables.csv");
  EXPECT_TRUE(contains(page, "  rank changes  at t = 0.125 to 0\n")) << page;
  EXPECT_LT(page.find("event at t = 0.125"), page.find("rank changes")) << "below what was asked for";
  EXPECT_NE(page.find("max tension(rod)  broken at t = 0.125"), std::string::npos) << page;
  EXPECT_EQ(page.find("nan"), std::string::npos) << page;
  EXPECT_TRUE(table.ends_with("\n0.5,,\n")) << table;
  if (!std::filesystem::exists(folder / "o/report.html")) GTEST_SKIP() << "this program was built without node";
  const std::string html = read_text(folder / "o/report.html");
  const std::size_t begin = html.find("id=\"data\">") + 10;
  const auto events = nlohmann::json::parse(html.substr(begin, html.find("</script>", begin) - begin)).at("events");
  ASSERT_EQ(events.size(), 1u) << "a change of rank is none of the scene's events";
  EXPECT_EQ(events[0].at("kind"), "event");
}

TEST(RunTest, AGuideThatLetGoIsToldAsReleasedWhateverElseItsEventsTold) {
  const Folder folder;
  write_text(folder / "s.json", R"json({"tanor_scene": 1, "name": "s", "points": {"positions": [[0,0,0]], "masses": 1},
    "constraints": [{"name": "floor", "kind": "plane", "points": [0], "normal": [0,0,1]}],
    "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}], "observe": ["multiplier(floor)", "moment(floor, y)"],
    "events": [{"when": "t > 0.125", "do": "release", "of": "floor"},
               {"when": "force(floor).z < 9", "do": "report"}], "motion": {"t_end": 0.5}
})json");
  const Ended ended = run_program(folder, {"run", "s.json", "--out", "o"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  const std::string page = read_text(folder / "o/report.txt");
  EXPECT_NE(page.find("multiplier(floor)  released at t = 0.125"), std::string::npos) << page;
  EXPECT_NE(page.find("moment(floor, y)   released at t = 0.125"), std::string::npos) << page;
  EXPECT_EQ(page.find("broken"), std::string::npos) << page;
}

/// A chain hangs along its weight up to rounding, which moves it a little.
TEST(RunTest, NumbersOfRoundingAreZeroForPeopleAndAQuotientByZeroIsNone) {
  const Folder folder;
  const std::array weight{0.3, 0.1, -9.81};
  const double size = std::hypot(weight[0], weight[1], weight[2]);
  nlohmann::json scene = nlohmann::json::parse(R"json({"tanor_scene": 1, "name": "s", "supports": [{"points": [0]}],
    "constraints": [{"name": "rods", "kind": "rod", "pairs": [[0,1], [1,2]]}], "observe": ["kinetic()", "temperature()", "moment(rods, x)", {"name": "ratio", "what": "1/(t-t)"}],
    "motion": {"t_end": 0.5, "method": "dop853"}})json");
  scene["forces"] = {{{"kind", "gravity"}, {"acceleration", weight}}};
  for (const double at : {0.0, 0.3, 0.7})
    scene["points"]["positions"].push_back({at * weight[0] / size, at * weight[1] / size, at * weight[2] / size});
  scene["points"]["masses"] = 2.3;
  write_text(folder / "s.json", scene.dump());

  ASSERT_EQ(run_program(folder, {"run", "s.json", "--out", "o"}).code, 0);

  const auto observed = read_json(folder / "o/summary.json")["observables"];
  for (int k = 0; k < 3; ++k) EXPECT_NE(observed[k]["values"][0], 0.0) << "the scene tests nothing";
  const std::string page = read_text(folder / "o/report.txt");
  for (const char* line :
       {"kinetic()        0", "temperature()    0", "moment(rods, x)  0", "ratio            not defined"})
    EXPECT_TRUE(contains(page, std::string("  ") + line + "\n")) << page;
  EXPECT_TRUE(read_text(folder / "o/observables.csv").ends_with(",\n"));
}

}  // namespace
}  // namespace tanor::cli
