#include <Eigen/Dense>
#include <cmath>
#include <cstdio>
#include <regex>

#include "cli/program.hpp"
#include "friction/rough_contacts.hpp"

/// \file The scenes of tests/data/friction in the program, and runs that meet several motions on their way.
namespace tanor::cli {
namespace {

using Eigen::Vector3d;
using nlohmann::json;

Vector3 vector_of(const json& a) {
  return {a.at(0), a.at(1), a.at(2)};
}

/// Returns a system of lines with one bead each, rods and constant forces.
System read_system(const json& scene) {
  System system;
  for (const json& r : scene.at("points").at("positions")) {
    for (const json& each : r) system.positions.push_back(each);
  }
  system.velocities.assign(system.positions.size(), 0.0);
  for (const json& mass : scene.at("points").at("masses")) system.masses.push_back(mass);
  for (const json& entry : scene.at("constraints")) {
    if (entry.at("kind") == "line") {
      system.constraints.push_back(Lines{entry.at("name"),
                                         {entry.at("points").at(0)},
                                         vector_of(entry.at("origin")),
                                         vector_of(entry.at("direction"))});
      continue;
    }
    Rods rods{"rods", {}, {}, {}};
    for (const json& pair : entry.at("pairs")) rods.pairs.push_back({pair.at(0), pair.at(1)});
    system.constraints.push_back(rods);
  }
  for (const json& entry : scene.at("forces"))
    system.forces.push_back(ConstantForce{"", {entry.at("points").at(0)}, vector_of(entry.at("force"))});
  for (const json& entry : scene.at("friction"))
    system.friction.push_back(Coulomb{.name = "", .at = {entry.at("at")}, .coefficient = entry.at("coefficient")});
  return system;
}

TEST(FrictionAtRest, SolveAndRunRefuseExactlyTheScenesWithoutOneMotion) {
  int unique = 0, several = 0;
  for (const auto& file : std::filesystem::directory_iterator(std::filesystem::path(TANOR_TEST_DATA) / "friction")) {
    if (file.path().extension() != ".json") continue;
    SCOPED_TRACE(file.path().filename().string());
    const json content = read_json(file.path());
    const json& scene = content.contains("scene") ? content.at("scene") : content;
    const reference::RoughContacts twin(read_system(scene));
    const auto counted = twin.find_all();
    ASSERT_TRUE(counted.is_certain);
    ASSERT_GT(counted.margin, 1e-6);
    const auto& motions = counted.motions;
    ASSERT_FALSE(motions.empty());
    (motions.size() == 1 ? unique : several) += 1;
    const Folder folder;
    write_text(folder / "s.json", scene.dump());

    const Ended solved = run_program(folder, {"solve", "s.json"});
    const Ended ran = run_program(folder, {"run", "s.json", "--out", "o", "--t-end", "0.001"});

    const json solution = json::parse(solved.out);
    EXPECT_EQ(solved.code, motions.size() == 1 ? 0 : 3) << solved.err;
    EXPECT_EQ(ran.code, motions.size() == 1 ? 0 : 3) << ran.err;
    EXPECT_EQ(solution["friction_report"]["uniqueness"], motions.size() == 1 ? "proven" : "several");
    if (motions.size() == 1) {
      EXPECT_EQ(read_json(folder / "o" / "summary.json")["friction"]["uniqueness"], "proven");
      for (std::size_t c = 0; c < twin.mu.size(); ++c) {
        const json& w = solution["accelerations"][static_cast<std::size_t>(twin.points[c])];
        const double a = twin.lines[c].dot(Vector3d(w[0], w[1], w[2])),
                     wanted = motions[0].a(static_cast<Eigen::Index>(c));
        EXPECT_NEAR(a, wanted, 1e-9 * (1.0 + std::abs(wanted)));
      }
      if (content.contains("accelerations")) {
        for (std::size_t i = 0; i < 2; ++i) {
          for (std::size_t k = 0; k < 3; ++k)
            EXPECT_NEAR(solution["accelerations"][i][k].get<double>(), content["accelerations"][i][k].get<double>(),
                        1e-4);
        }
      }
    } else {
      for (const Ended* ended : {&solved, &ran}) {
        EXPECT_TRUE(contains(ended->err, std::to_string(motions.size()) + " accelerations obey the law")) << ended->err;
        EXPECT_TRUE(contains(ended->err, "t = 0")) << ended->err;
        EXPECT_FALSE(std::regex_search(ended->err, std::regex("[1-9][0-9]{5}"))) << ended->err;
      }
    }
  }
  EXPECT_GE(unique, 5);
  EXPECT_GE(several, 4);
}

/// Returns a rod between two rails whose upper end is D(t) = 0.4 + 0.2 cos t ahead of the lower one
/// (tests/friction/modes_test.cpp). Several motions obey the law while D < 0.3, t from 2 pi/3 to 4 pi/3. No motion does
/// where in addition F > 2 g D.
std::string telescope(const std::string& F, const std::string& motion) {
  return R"json({"tanor_scene": 1, "points": {"positions": [[0,0,0], [0.6,1,0]], "velocities": [[30,0,0], [30,0,0]]},
    "constraints": [{"name": "lower", "kind": "line", "points": [0], "origin": [0,0,0], "direction": [1,0,0]},
                    {"name": "upper", "kind": "line", "points": [1], "origin": [0,1,0], "direction": [1,0,0]},
                    {"name": "rod", "kind": "rod", "pairs": [[0,1]],
                     "length": {"formula": "sqrt(1 + (0.4 + 0.2*cos(t))^2)"}}],
    "forces": [{"kind": "gravity", "acceleration": [0,-9.81,0]},
               {"kind": "constant", "points": [1], "force": {"formula": [")json" +
         F + R"json( - 0.2*cos(t)", "0", "0"]}}],
    "friction": [{"name": "rust", "kind": "coulomb", "at": "lower", "coefficient": 0.6}], "motion": {)json" +
         motion + "}}";
}

TEST(FrictionInRuns, SeveralMotionsAreCountedAndSaidOnStderr) {
  const Folder folder;
  write_text(folder / "s.json", telescope("1", R"("method": "rk4", "step": 0.001, "t_end": 5)"));

  const Ended ended = run_program(folder, {"run", "s.json", "--out", "o"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_TRUE(contains(ended.err, "several accelerations obeyed the law at 2094 instants, at t = 2.095")) << ended.err;
  const json friction = read_json(folder / "o" / "summary.json")["friction"];
  EXPECT_EQ(friction["uniqueness"], "several");
  EXPECT_EQ(friction["several"], 2094) << "steps that end between 2 pi/3 and 4 pi/3";
  EXPECT_NEAR(friction["first_several"].get<double>(), 2.095, 1e-12);
}

TEST(FrictionInRuns, WhereNoMotionIsLeftTheRunEndsWithThree) {
  const Folder folder;
  write_text(folder / "s.json", telescope("1 + 0.5*t^2", R"("method": "dopri5", "t_end": 5, "output_every": 0.5)"));

  const Ended ended = run_program(folder, {"run", "s.json", "--out", "o"});

  EXPECT_EQ(ended.code, 3);
  EXPECT_TRUE(contains(ended.err, "rust at lower[0], point 0") && contains(ended.err, "no accelerations obey the law"))
      << ended.err;
  // 1 + t^2/2 = 2 g (0.4 + 0.2 cos t)
  double low = 2.1, high = 3.0;
  for (int pass = 0; pass < 60; ++pass) {
    const double middle = 0.5 * (low + high);
    (1.0 + 0.5 * middle * middle < 2.0 * 9.81 * (0.4 + 0.2 * std::cos(middle)) ? low : high) = middle;
  }
  EXPECT_NEAR(read_json(folder / "o" / "summary.json")["t_reached"].get<double>(), low, 1e-5);
}

}  // namespace
}  // namespace tanor::cli
