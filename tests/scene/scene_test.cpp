#include "scene/reading.hpp"

#include <tuple>

namespace tanor::scene {
namespace {

TEST(Scene, SceneOfTheContractIsReadWhole) {
  const Scene scene = parse(R"({
    "tanor_scene": 1,
    "name": "three beads",
    "points": {"positions": [[0,0,0],[0.1,0,0],[0.2,0,0]], "velocities": [[0,0,0],[0,0,0],[0,0,0]], "masses": 0.1},
    "supports": [{"points": [0], "motion": "fixed"}],
    "constraints": [{"name": "rods", "kind": "rod", "pairs": [[0,1],[1,2]], "length": "initial"}],
    "forces": [{"kind": "gravity", "acceleration": [0,0,-9.81]}],
    "motion": {"method": "auto", "t_end": 1.0, "output_every": 0.01}
  })");

  EXPECT_EQ(scene.name, "three beads");
  EXPECT_EQ(scene.source, "inline");
  EXPECT_EQ(scene.system.name, "three beads");
  EXPECT_EQ(scene.system.positions, (std::vector<double>{0, 0, 0, 0.1, 0, 0, 0.2, 0, 0}));
  EXPECT_EQ(scene.system.velocities, std::vector<double>(9, 0.0));
  EXPECT_EQ(scene.system.masses, std::vector<double>(3, 0.1));
  ASSERT_EQ(scene.system.supports.size(), 1u);
  EXPECT_EQ(scene.system.supports[0].points, std::vector<Index>{0});
  EXPECT_TRUE(scene.system.supports[0].displacement.is_constant());
  ASSERT_EQ(scene.system.constraints.size(), 1u);
  const Rods& rods = std::get<Rods>(scene.system.constraints[0]);
  EXPECT_EQ(rods.name, "rods");
  EXPECT_EQ(rods.pairs, (std::vector<std::array<Index, 2>>{{0, 1}, {1, 2}}));
  EXPECT_TRUE(rods.length.is_initial());
  EXPECT_EQ(std::get<Gravity>(scene.system.forces.at(0)).acceleration, (Vector3{0, 0, -9.81}));
  EXPECT_EQ(scene.motion.method, Method::Auto);
  EXPECT_EQ(scene.t_end, 1.0);
  EXPECT_EQ(scene.output_every, 0.01);
}

TEST(Scene, HasTheDefaultsOfTheContract) {
  const Scene scene = parse_scene(three_points(), "some/where/beads.json");

  EXPECT_EQ(scene.file, "some/where/beads.json");
  EXPECT_EQ(scene.name, "beads");
  EXPECT_TRUE(scene.system.velocities.empty()) << "at rest";
  EXPECT_EQ(scene.system.masses, std::vector<double>(3, 1.0));
  EXPECT_TRUE(scene.system.supports.empty());
  EXPECT_TRUE(scene.system.constraints.empty());
  EXPECT_TRUE(scene.system.forces.empty());
  EXPECT_EQ(scene.motion.method, Method::Auto);
  EXPECT_EQ(scene.motion.step, 0.0);
  EXPECT_EQ(scene.motion.rtol, 1e-8);
  EXPECT_EQ(scene.motion.atol, 0.0);  // 1e-10 of the size around each point
  EXPECT_EQ(scene.motion.stabilisation, Stabilisation::Projection);
  EXPECT_EQ(scene.motion.start, StartMode::Check);
  EXPECT_FALSE(scene.has_end());
  EXPECT_EQ(scene.output_every, 0.0);
  EXPECT_TRUE(scene.output_points.empty()) << "all";
  EXPECT_EQ(scene.solver.linear_solver, LinearSolver::Auto);
  EXPECT_TRUE(scene.solver.reuse);
  EXPECT_TRUE(scene.solver.exact);
  EXPECT_EQ(scene.solver.ordering, Ordering::Auto);
  EXPECT_EQ(scene.solver.threads, 0);
  EXPECT_EQ(scene.certificate.when, CertificatePolicy::When::Final);
}

TEST(Scene, OldNamesAreReadAndTold) {
  const Scene old = parse(three_points(R"("solver": {"way": "bundles"})"));
  EXPECT_EQ(old.solver.linear_solver, LinearSolver::Batches);
  EXPECT_EQ(old.old_names, (std::vector<std::string>{"/solver/way: its name is linear_solver",
                                                     "/solver/way: \"bundles\" is \"batches\""}));
  const std::tuple<std::string, LinearSolver, std::string> old_words[]{
      {"sparse", LinearSolver::General, "general"},
      {"path", LinearSolver::Paths, "paths"},
      {"tree", LinearSolver::Trees, "trees"},
      {"batched", LinearSolver::Batches, "batches"},
      {"pointwise", LinearSolver::ClosedForm, "closed_form"}};
  for (const auto& [word, solver, name] : old_words) {
    const std::string quoted = '"' + word + '"';
    const Scene scene = parse(three_points("\"solver\": {\"linear_solver\": " + quoted + "}"));
    EXPECT_EQ(scene.solver.linear_solver, solver);
    EXPECT_EQ(scene.old_names, std::vector<std::string>{"/solver/linear_solver: " + quoted + " is \"" + name + '"'});
  }
  const Scene now = parse(three_points(R"("solver": {"linear_solver": "batches"})"));
  EXPECT_EQ(now.solver.linear_solver, LinearSolver::Batches);
  EXPECT_TRUE(now.old_names.empty());
}

TEST(Scene, ReadsMotionAndSolver) {
  const Scene scene = parse(three_points(R"(
    "motion": {"method": "rk4", "step": 1e-3, "max_step": 0.25, "rtol": 1e-6, "atol": 1e-7, "t_end": 2, "output_every": 0.5,
               "output_points": {"first": 1}, "stabilisation": "none", "start": "project"},
    "solver": {"form": "normal", "linear_solver": "general", "ordering": "metis", "reuse": false, "exact": false, "threads": 2,
               "certificate": {"every": 10}})"));

  EXPECT_EQ(scene.motion.method, Method::Rk4);
  EXPECT_EQ(scene.motion.step, 1e-3);
  EXPECT_EQ(scene.motion.rtol, 1e-6);
  EXPECT_EQ(scene.motion.atol, 1e-7);
  EXPECT_EQ(scene.t_end, 2.0);
  EXPECT_EQ(scene.motion.max_step, 0.25);
  EXPECT_EQ(scene.output_every, 0.5);
  EXPECT_EQ(scene.output_points, (std::vector<Index>{1, 2}));
  EXPECT_EQ(scene.motion.stabilisation, Stabilisation::None);
  EXPECT_EQ(scene.motion.start, StartMode::Project);
  EXPECT_EQ(scene.solver.linear_solver, LinearSolver::General);
  EXPECT_FALSE(scene.solver.reuse);
  EXPECT_FALSE(scene.solver.exact);
  EXPECT_EQ(scene.solver.ordering, Ordering::Metis);
  EXPECT_EQ(scene.solver.threads, 2);
  EXPECT_EQ(scene.certificate.when, CertificatePolicy::When::Every);
  EXPECT_EQ(scene.certificate.every, 10);
}

TEST(Scene, TakesNoStepFromNull) {
  EXPECT_EQ(parse(three_points(R"("motion": {"step": null})")).motion.step, 0.0);
}

TEST(Scene, AcceptsEmptyListsOfFrictionAndCoordinates) {
  EXPECT_EQ(error_of(three_points(R"("friction": [], "coordinates": [])")), "no error");
}

TEST(Scene, ReadsListsOfPointsInThreeWays) {
  const Scene scene = parse(three_points(R"("forces": [
    {"kind": "drag", "points": [2, 0]},
    {"kind": "drag", "points": "all"},
    {"kind": "drag", "points": {"first": 0, "count": 2, "stride": 2}},
    {"kind": "drag", "points": {}},
    {"kind": "drag", "points": []}])"));

  const auto points = [&](std::size_t k) { return std::get<Drag>(scene.system.forces[k]).points; };
  EXPECT_EQ(points(0), (std::vector<Index>{2, 0}));
  EXPECT_EQ(points(1), (std::vector<Index>{0, 1, 2}));
  EXPECT_EQ(points(2), (std::vector<Index>{0, 2}));
  EXPECT_EQ(points(3), (std::vector<Index>{0, 1, 2}));
  EXPECT_TRUE(points(4).empty());
}

TEST(Scene, ReadsPointsFromFiles) {
  const Scene csv = parse(R"({"tanor_scene": 1, "points": {"positions": {"file": "positions.csv"}}})");
  const Scene npy = parse(R"({"tanor_scene": 1, "points": {
    "positions": {"file": "positions.npy"}, "velocities": {"file": "positions.npy"},
    "masses": {"file": "masses.npy"}}})");

  const std::vector<double> positions = {0, 0, 0, 1.5, 0, -2, 3, 0.4, 0};
  EXPECT_EQ(csv.system.positions, positions);
  EXPECT_EQ(npy.system.positions, positions);
  EXPECT_EQ(npy.system.velocities, positions);
  EXPECT_EQ(npy.system.masses, (std::vector<double>{0.1, 0.2, 0.3}));
}

TEST(Scene, FileOfTheWrongWidthNamesItsKey) {
  const std::string error =
      error_of(R"({"tanor_scene": 1, "points": {"positions": {"file": "masses.npy"}}})", TANOR_TEST_DATA "/scene.json");

  EXPECT_EQ(
      error,
      "scene.json: /points/positions/file: found string \"masses.npy\", wanted a file of 3 columns, this one has 1");
}

TEST(Scene, IsLoadedFromItsFile) {
  const Folder folder;
  const std::filesystem::path file = folder.add("beads.json", three_points());

  EXPECT_EQ(load_scene(file).name, "beads");
}

TEST(Scene, UnreadableSceneNamesItsFile) {
  const Folder folder;

  for (const char* name : {"nowhere.json", ""}) {  // the second one is the folder itself
    try {
      load_scene(folder / name);
      FAIL() << "no error";
    } catch (const InputError& error) {
      EXPECT_EQ(error.where(), (folder / name).string());
      EXPECT_NE(std::string(error.what()).find("cannot be read: "), std::string::npos);
    }
  }
}

TEST(Scene, MillionPointsAreRead) {
  constexpr int num_points = 1'000'000;
  std::string positions, pairs;
  for (int k = 0; k < num_points; ++k) {
    positions += (k > 0 ? ",[0.1," : "[0.1,") + std::to_string(k) + ",0]";
    if (k > 0) pairs += (k > 1 ? ",[" : "[") + std::to_string(k - 1) + "," + std::to_string(k) + "]";
  }

  const Scene scene = parse(R"({"tanor_scene": 1, "points": {"positions": [)" + positions +
                            R"(]}, "constraints": [{"kind": "rod", "pairs": [)" + pairs + "]}]}");

  EXPECT_EQ(scene.system.num_points(), std::size_t{num_points});
  EXPECT_EQ(scene.system.positions[3 * 999'999 + 1], 999'999.0);
  EXPECT_EQ(std::get<Rods>(scene.system.constraints[0]).pairs.size(), std::size_t{num_points - 1});
}

}  // namespace
}  // namespace tanor::scene
