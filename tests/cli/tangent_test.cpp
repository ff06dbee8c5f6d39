/// The program solves scenes with coordinates.

#include "cli/program.hpp"

namespace tanor::cli {
namespace {

using nlohmann::json;

/// Returns a bead that slides on a hoop that turns around the vertical. `more` has further keys of the scene.
std::string hoop(const std::string& more = "", double radius = 0.5) {
  return R"json({
    "tanor_scene": 1, "name": "hoop", "parameters": {"R": 0.5, "O": 6},
    "points": {"positions": [[0.5,0,0]], "masses": 0.3},
    "coordinates": [{"name": "bead", "kind": "formula", "points": [0], "q": {"q": 1.5707963267948966},
      "q_dot": {"q": -1},
      "x": "R*sin(q)*cos(O*t)", "y": "R*sin(q)*sin(O*t)", "z": "-R*cos(q)"}],
    "constraints": [{"name": "wire", "kind": "circle", "points": [0], "center": [0,0,0],
      "normal": {"formula": ["-sin(O*t)", "cos(O*t)", "0"]}, "radius": )json" +
         std::to_string(radius) + R"json(}],
    "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}],
    "motion": {"t_end": 1, "method": "rk4", "step": 0.001, "output_every": 0.125})json" +
         more + "}";
}

/// Returns the hoop without its constraints.
std::string coordinates_alone() {
  json scene = json::parse(hoop());
  scene.erase("constraints");
  return scene.dump();
}

TEST(TangentTest, InfoSaysWhichFormAndWhy) {
  const Folder folder;
  write_text(folder / "alone.json", coordinates_alone());
  write_text(folder / "asked.json", hoop(R"(, "solver": {"form": "normal"})"));

  const Ended alone = run_program(folder, {"info", "alone.json"}), asked = run_program(folder, {"info", "asked.json"});

  EXPECT_EQ(alone.code, 0) << alone.err;
  EXPECT_TRUE(contains(alone.out, "degrees of freedom:      1, as many as coordinates")) << alone.out;
  EXPECT_TRUE(contains(alone.out, "coordinates:             bead (formula)")) << alone.out;
  EXPECT_TRUE(contains(alone.out, "form:                    tangent: ")) << alone.out;
  EXPECT_TRUE(contains(alone.out, "no constraints are given")) << alone.out;
  EXPECT_TRUE(contains(asked.out, "form:                    normal: ")) << asked.out;
  EXPECT_TRUE(contains(asked.out, "; tangent ")) << asked.out;
}

TEST(TangentTest, RunWritesFormAndDegreesOfFreedom) {
  const Folder folder;
  write_text(folder / "hoop.json", coordinates_alone());

  const Ended ended = run_program(folder, {"run", "hoop.json", "--quiet"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  const json summary = read_json(folder / "hoop.out/summary.json");
  EXPECT_EQ(summary["form"], "tangent");
  EXPECT_EQ(summary["degrees_of_freedom"], 1);
  EXPECT_TRUE(summary["rank"].is_null());
  EXPECT_TRUE(summary["final"]["multipliers"].is_null());
  EXPECT_EQ(summary["final"]["reactions"].size(), 1u);
}

TEST(TangentTest, BothFormsEndAtTheSamePlace) {
  const Folder folder;
  json ends[2];
  for (const std::string form : {"normal", "tangent"}) {
    write_text(folder / (form + ".json"), hoop(", \"solver\": {\"form\": \"" + form + "\"}"));
    ASSERT_EQ(run_program(folder, {"run", form + ".json", "--quiet", "--out", form}).code, 0);
    const json summary = read_json(folder / (form + "/summary.json"));
    EXPECT_EQ(summary["form"], form);
    EXPECT_EQ(summary["degrees_of_freedom"], 1);
    ends[form == "tangent"] = summary["final"];
  }

  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(ends[0]["positions"][0][k].get<double>(), ends[1]["positions"][0][k].get<double>(), 1e-9);
  }
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_NEAR(ends[0]["multipliers"][k].get<double>(), ends[1]["multipliers"][k].get<double>(), 1e-7);
  }
}

TEST(TangentTest, ResumedRunEndsWhereTheWholeOneDoes) {
  const Folder folder;
  write_text(folder / "hoop.json", coordinates_alone());
  ASSERT_EQ(run_program(folder, {"run", "hoop.json", "--quiet", "--out", "whole"}).code, 0);
  ASSERT_EQ(run_program(folder, {"run", "hoop.json", "--quiet", "--out", "parts", "--t-end", "0.5"}).code, 0);

  const Ended ended = run_program(folder, {"run", "hoop.json", "--quiet", "--out", "parts", "--resume"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  const json whole = read_json(folder / "whole/summary.json"), parts = read_json(folder / "parts/summary.json");
  EXPECT_EQ(whole["steps"], parts["steps"]);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(whole["final"]["positions"][0][k].get<double>(), parts["final"]["positions"][0][k].get<double>(),
                1e-12);
  }
}

TEST(TangentTest, CoordinatesThatDoNotFitAreToldInOneLine) {
  const Folder folder;
  write_text(folder / "rattle.json", coordinates_alone());
  write_text(folder / "wide.json", hoop("", 0.51));

  EXPECT_EQ(complaint(folder, {"run", "rattle.json", "--method", "rattle"}),
            "tanor: rattle.json: /motion/method: rattle projects onto constraints, the tangent form has none; "
            "rk4, dopri5 and dop853 step in coordinates\n");
  const std::string wide = complaint(folder, {"run", "wide.json"});
  EXPECT_TRUE(contains(wide, "wide.json: /coordinates: the places that the coordinates describe violate wire[0].1 by"))
      << wide;
}

}  // namespace
}  // namespace tanor::cli
