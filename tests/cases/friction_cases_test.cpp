/// \file The cases with friction are 04a and 04b in all forms, and 10b by its instances.

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <tanor/dynamics.hpp>
#include <tanor/motion.hpp>

#include "cases/reference_motion.hpp"
#include "rough_scenes.hpp"

namespace tanor::cases {
namespace {

System make_rough_circle(const Instant& start) {
  System system = make_system(start, {}, {1.0});
  system.constraints = {Circles{"wire", {0}, Vector3{0, 0, 0}, Vector3{0, 0, 1}, 1.0}};
  system.friction = {Coulomb{.name = "rough", .at = {"wire"}, .coefficient = 0.2}};
  return system;
}

struct RoughCase {
  std::string name;
  System (*build)(const Instant& start);
  Coordinates (*coordinates)();
  Vector3 (*normal)(const Instant& instant);  // the case's multiplier acts along it

  friend std::ostream& operator<<(std::ostream& out, const RoughCase& given) { return out << given.name; }
};

std::vector<RoughCase> rough_cases() {
  return {{"04a_rough_incline", [](const Instant&) { return scenes::make_rough_incline(1.0, 0.3); },
           []() -> Coordinates {
             return LineCoordinates{"", {0}, Vector3{0, 0, 0}, Vector3{std::sqrt(0.75), -0.5, 0}};
           },
           [](const Instant&) {
             return Vector3{0.5, std::sqrt(0.75), 0};
           }},
          {"04b_rough_circle_no_gravity", make_rough_circle,
           []() -> Coordinates {
             return CircleCoordinates{"", {0}, Vector3{0, 0, 0}, Vector3{0, 0, 1}, 1.0};
           },
           [](const Instant& instant) { return point(instant.r, 0); }}};
}

class RoughCaseTest : public testing::TestWithParam<RoughCase> {
 protected:
  const std::vector<Instant> trajectory = read_trajectory(GetParam().name);
  std::vector<double> reactions(const Instant& instant) const {
    std::vector<double> result(3, 0.0);
    add(instant.lambda[0], GetParam().normal(instant), 0, &result);
    return result;
  }
  void expect_near(std::span<const double> found, const std::vector<double>& wanted, double allowed) const {
    EXPECT_LE(largest_difference(found, wanted), allowed * std::max(1.0, largest(wanted)));
  }
};

TEST_P(RoughCaseTest, MotionHasTenDigitsWithConstraintsAloneAndInBothForms) {
  const System alone = GetParam().build(trajectory.front());
  System with_coordinates = alone;
  with_coordinates.coordinates = {GetParam().coordinates()};
  const MotionOptions options{.method = Method::Dopri5, .rtol = 1e-12, .atol = 1e-14};
  for (const auto& [system, form] :
       {std::pair{alone, Form::Normal}, {with_coordinates, Form::Normal}, {with_coordinates, Form::Tangent}}) {
    Simulation simulation(system, options, {.form = form});
    for (std::size_t k = 1; k < trajectory.size(); ++k) {
      const Instant& instant = trajectory[k];
      ASSERT_TRUE(simulation.advance_to(instant.t).ok()) << simulation.outcome().what;
      expect_near(simulation.positions(), instant.r, 1e-10);
      expect_near(simulation.velocities(), instant.v, 1e-10);
      expect_near(simulation.accelerations(), instant.w, 1e-10);
      expect_near(simulation.reactions(), reactions(instant), 1e-10);
      if (instant.energy) {
        EXPECT_NEAR(simulation.report().energy.now, *instant.energy, 1e-9);
      }
    }
    EXPECT_EQ(simulation.report().events, 0u);
    EXPECT_LE(std::abs(simulation.report().energy.drift_relative()), 1e-10);
  }
}

TEST_P(RoughCaseTest, BothFormsAgreeAtEveryInstant) {
  System system = GetParam().build(trajectory.front());
  system.coordinates = {GetParam().coordinates()};
  Dynamics dynamics(system, {.form = Form::Both});
  for (const Instant& instant : trajectory) {
    std::vector<double> w(3), eta(3), tau(3);
    const SolveReport report = dynamics.solve({.time = instant.t, .positions = instant.r, .velocities = instant.v},
                                              {.accelerations = w, .reactions = eta});
    ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
    EXPECT_LE(report.forms_disagreement, 1e-12);
    expect_near(w, instant.w, 1e-13);
    expect_near(eta, reactions(instant), 1e-13);
  }
}

#ifdef TANOR_PROGRAM
TEST_P(RoughCaseTest, TheProgramGivesTenDigits) {
  const MotionOptions options{.method = Method::Dopri5, .rtol = 1e-12, .atol = 1e-14};
  const Instant& end = trajectory.back();

  const Answer answer = through_program(GetParam().name, {}, options, end.t);

  expect_near(answer.positions, end.r, 1e-10);
  expect_near(answer.velocities, end.v, 1e-10);
  expect_near(answer.reactions, reactions(end), 1e-10);
}

TEST_P(RoughCaseTest, TheProgramSolvesTheStart) {
  const Folder folder;

  run_program("solve " + scene_file(GetParam().name) + " --out " + (folder / "solution.json").string());

  const nlohmann::json solution = read_json(folder / "solution.json");
  expect_near(flatten(solution.at("accelerations")), trajectory.front().w, 1e-13);
  expect_near(flatten(solution.at("reactions")), reactions(trajectory.front()), 1e-13);
}
#endif

INSTANTIATE_TEST_SUITE_P(Cases, RoughCaseTest, testing::ValuesIn(rough_cases()),
                         [](const auto& instance) { return instance.param.name; });

// ---- 10b: a rod between two rails ----------------------------------------------------------------------------------

scenes::Rails read_rails(const nlohmann::json& instance) {
  return {.mu = number(instance.at("mu")),
          .f2 = instance.at("f2").get<double>(),
          .alpha = instance.at("alpha_deg").get<double>(),
          .m1 = number(instance.at("m1")),
          .m2 = number(instance.at("m2")),
          .f1 = instance.at("f1").get<double>()};
}

TEST(PainleveRailsTest, TheNumberOfSolutionsIsThatOfTheCase) {
  const nlohmann::json rails = read_case("10b_painleve_rails");
  for (const nlohmann::json& instance : rails.at("instances")) {
    const System system = scenes::make_rails(read_rails(instance));
    Dynamics dynamics(system);
    std::vector<double> w(6), lambda(5);
    const SolveReport report =
        dynamics.solve({.time = 0.0, .positions = system.positions, .velocities = system.velocities},
                       {.accelerations = w, .multipliers = lambda});
    const int count = instance.at("n_solutions").get<int>();
    EXPECT_EQ(report.friction.uniqueness, count == 0   ? Uniqueness::None
                                          : count == 1 ? Uniqueness::Proven
                                                       : Uniqueness::Several)
        << instance;
    EXPECT_EQ(report.outcome.status, count == 0   ? Status::NoSolution
                                     : count == 1 ? Status::Ok
                                                  : Status::NotUnique)
        << instance;
    const Simulation run(system);
    EXPECT_EQ(run.outcome().status, report.outcome.status) << run.outcome().what;
    if (count == 2) {
      // The message names contact, time and both accelerations.
      for (const std::string& what : {report.outcome.what, run.outcome().what}) {
        EXPECT_NE(what.find("t = 0"), std::string::npos) << what;
        EXPECT_NE(what.find("rust at rough[0], point 0"), std::string::npos) << what;
        std::vector<double> named;
        for (std::size_t k = what.find('('); k != std::string::npos; k = what.find('(', k + 1))
          named.push_back(std::strtod(what.c_str() + k + 1, nullptr));
        ASSERT_EQ(named.size(), 2u) << what;
        std::vector<double> wanted{number(instance.at("solutions").at(0).at("a")),
                                   number(instance.at("solutions").at(1).at("a"))};
        std::sort(named.begin(), named.end());
        std::sort(wanted.begin(), wanted.end());
        for (std::size_t k = 0; k < 2; ++k) EXPECT_NEAR(named[k], wanted[k], 5e-4 * std::abs(wanted[k])) << what;
      }
    }
    if (count != 1) continue;
    const nlohmann::json& solution = instance.at("solutions").at(0);
    EXPECT_NEAR(w[0], number(solution.at("a")), 1e-13);
    EXPECT_NEAR(w[3], number(solution.at("a")), 1e-13);
    EXPECT_NEAR(lambda[4], number(solution.at("T")), 1e-12);
  }
}

#ifdef TANOR_PROGRAM
TEST(PainleveRailsTest, TheProgramSolvesTheUniqueInstance) {
  const Folder folder;

  run_program("solve " + scene_file("10b_painleve_rails") + " --out " + (folder / "solution.json").string());

  const nlohmann::json solution = read_json(folder / "solution.json");
  EXPECT_NEAR(flatten(solution.at("accelerations"))[0], -0.40974901214841566341, 1e-13);
  EXPECT_NEAR(solution.at("multipliers").at(4).get<double>(), -5.4468519176786246638, 1e-12);
}
#endif

}  // namespace
}  // namespace tanor::cases
