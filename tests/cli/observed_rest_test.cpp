#include "cli/program.hpp"

namespace tanor::cli {
namespace {

using nlohmann::json;

/// Three rods between two supports, sagging.
const json sagging = json::parse(R"({
  "tanor_scene": 1, "units": "si",
  "points": {"positions": [[0,0,0], [0.7,0,-0.5], [1.5,0,-0.5], [2.2,0,0]], "masses": 2},
  "supports": [{"name": "hooks", "points": [0, 3]}],
  "constraints": [{"name": "rods", "kind": "rod", "pairs": [[0,1], [1,2], [2,3]], "length": 0.9}],
  "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}]})");

/// The observables stand at the head of the page, in the summary and in one row of a table, as for runs.
TEST(ObservedRestTest, OfEquilibriumHasItsTensionsAndLoads) {
  const Folder folder;

  const Ended plain = find_at_rest(folder, sagging);
  ASSERT_EQ(plain.code, 0) << plain.err;
  EXPECT_TRUE(contains(plain.out, "max tension(rods)  ")) << plain.out;
  EXPECT_TRUE(contains(read_text(folder / "at_rest/report.txt"), "load(hooks).z      -39.24 N")) << plain.out;
  EXPECT_FALSE(contains(plain.out, "left out"));

  // Drag and events belong to motions; the page ends with that.
  json dragged = sagging;
  dragged["forces"].push_back({{"kind", "drag"}, {"name", "air"}, {"points", "all"}, {"linear", 0.1}});
  dragged["events"] = {{{"when", "t > 1"}, {"do", "stop"}}};
  const std::string said = "  left out      air: drag acts on what moves; events: nothing moves\n";
  EXPECT_TRUE(contains(find_at_rest(folder, dragged).out, said));
  EXPECT_TRUE(read_text(folder / "at_rest/report.txt").ends_with(said));

  json scene = sagging;
  scene["observe"] = {"load(hooks).z", "max tension(rods)", "kinetic()",
                      "potential()",   "temperature()",     "friction(1).x"};
  ASSERT_EQ(find_at_rest(folder, scene).code, 0);
  const json summary = read_json(folder / "at_rest/summary.json");
  const json& observed = summary.at("observables");
  ASSERT_EQ(observed.size(), 6U);
  EXPECT_EQ(observed[0].at("unit"), "N");
  EXPECT_NEAR(observed[0].at("values")[0].get<double>(), -4.0 * 9.81, 1e-9);
  double largest = 0.0;
  for (const json& lambda : summary.at("final").at("multipliers")) largest = std::max(largest, -lambda.get<double>());
  EXPECT_EQ(observed[1].at("values")[0], largest);
  EXPECT_EQ(observed[2].at("values")[0], 0.0);
  EXPECT_NEAR(observed[3].at("values")[0].get<double>(), summary["equilibrium"]["energy"].get<double>(), 1e-9);
  EXPECT_EQ(observed[4].at("values")[0], 0.0);
  EXPECT_EQ(observed[5].at("values")[0], 0.0);
  EXPECT_TRUE(
      read_text(folder / "at_rest/observables.csv").starts_with("t [s],load(hooks).z [N],max tension(rods) [N],"));
}

/// Forces that balance up to rounding are 0 for people, on the page in the terminal and on the html page; files have
/// the digits.
TEST(ObservedRestTest, PagesShowNoRounding) {
  const Folder folder;
  const Ended ended = find_at_rest(folder, sagging);
  ASSERT_EQ(ended.code, 0) << ended.err;

  EXPECT_TRUE(contains(ended.out, "load(hooks).x, .y  0 N\n")) << ended.out;
  const std::string page = read_text(folder / "at_rest/report.html");
  const std::size_t begin = page.find("id=\"data\">") + 10;
  const json shown = json::parse(page.substr(begin, page.find("</script>", begin) - begin)).at("observables");
  const json exact = read_json(folder / "at_rest/summary.json").at("observables");
  bool has_rounding = false;
  for (std::size_t k = 0; k < exact.size(); ++k) {
    const json& values = exact[k].at("values");
    double size = 0.0;
    for (const json& value : values) size = std::max(size, std::abs(value.get<double>()));
    for (std::size_t part = 0; part < values.size(); ++part) {
      const double value = values[part], seen = shown[k].at("rows")[0][part];
      const bool is_rounding = std::abs(value) < 1e-10 * size;
      has_rounding = has_rounding || (is_rounding && value != 0.0);
      EXPECT_NEAR(seen, is_rounding ? 0.0 : value, is_rounding ? 0.0 : 1e-8 * size) << exact[k];
      EXPECT_EQ(shown[k].at("values")[part], is_rounding ? json(0.0) : values[part]);
    }
  }
  EXPECT_TRUE(has_rounding) << "the scene tests nothing";
}

/// Where nothing rests, no force is known: the page does not list the multipliers with which the search began.
TEST(ObservedRestTest, AFailedSearchKnowsNoForces) {
  const Folder folder;
  json scene = sagging;
  scene.erase("supports");

  EXPECT_EQ(find_at_rest(folder, scene).code, 3);

  const json final = read_json(folder / "at_rest/summary.json").at("final");
  EXPECT_EQ(final.at("multipliers"), json({nullptr, nullptr, nullptr}));
  for (const char* key : {"reactions", "support_forces"})
    for (const json& row : final.at(key)) EXPECT_EQ(row, json({nullptr, nullptr, nullptr})) << key;
  const std::string page = read_text(folder / "at_rest/report.html");
  EXPECT_TRUE(contains(page, R"("tensions":[[0.0,0.0]])")) << "a range without numbers";
}

/// Rest has no time: neither where extremes of members are told, nor in pictures.
TEST(ObservedRestTest, NothingAtRestHasATime) {
  const Folder folder;
  json scene = sagging;
  scene["observe"] = {"tension(rods)", "max tension(rods)"};

  const Ended ended = find_at_rest(folder, scene);
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_TRUE(contains(ended.out, "3 numbers; least ")) << ended.out;
  EXPECT_FALSE(contains(ended.out, "t = ")) << ended.out;
  const std::string page = read_text(folder / "at_rest/report.html");
  const std::size_t begin = page.find("id=\"data\">") + 10;
  const json shown = json::parse(page.substr(begin, page.find("</script>", begin) - begin));
  EXPECT_TRUE(shown.at("observables")[0].at("least")[0].at("t").is_null());
  EXPECT_EQ(shown.at("observables")[0].at("least")[0].at("member"), "rods[1]");

  const Ended drawn = run_program(folder, {"picture", "at_rest"});
  if (contains(drawn.err, "without cairo")) GTEST_SKIP() << drawn.err;
  EXPECT_TRUE(drawn.err.starts_with("tanor: at rest in at_rest/picture.png")) << drawn.err << drawn.out;
  EXPECT_TRUE(json::parse(run_program(folder, {"picture", "at_rest", "--json"}).out).at("t").is_null());
}

TEST(ObservedRestTest, OfModesHasNoVelocity) {
  const Folder folder;
  write_text(folder / "s.json", R"json({
    "tanor_scene": 1,
    "points": {"positions": [[0,0,0], [0,-1,0], [0,-2,0]], "masses": 2, "velocities": [[0,0,0], [1,0,0], [2,0,0]]},
    "supports": [{"points": [0]}],
    "constraints": [{"name": "rods", "kind": "rod", "pairs": [[0,1],[1,2]]}],
    "forces": [{"kind": "gravity", "acceleration": [0,-9.81,0]}], "observe": ["load(support0).y", "kinetic()"]
})json");

  const Ended ended = run_program(folder, {"modes", "s.json", "--out", "answer"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_TRUE(contains(ended.out, "load(support0).y  -39.24\n")) << ended.out;
  const json observed = read_json(folder / "answer/summary.json").at("observables");
  EXPECT_NEAR(observed[0].at("values")[0].get<double>(), -4.0 * 9.81, 1e-10);
  EXPECT_EQ(observed[1].at("values")[0], 0.0);
  EXPECT_EQ(read_text(folder / "answer/observables.csv").substr(0, 29), "t,load(support0).y,kinetic()\n");
}

}  // namespace
}  // namespace tanor::cli
