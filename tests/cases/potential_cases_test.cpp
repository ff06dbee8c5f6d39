/// The motion under an energy of several points is that of a body on a spring (A1) or of butane (A2), by every kind of
/// method, from C++, from scene files and in coordinates.

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <tanor/dynamics.hpp>

#include "cases/interfaces.hpp"
#include "cases/reference_case.hpp"
#include "measures.hpp"

namespace tanor::cases {
namespace {

System with_masses(const Instant& start, std::vector<double> masses) {
  System system;
  system.positions = start.r;
  system.velocities = start.v;
  system.masses = std::move(masses);
  return system;
}

/// Makes two points and a rod pinned at the origin off the rod. The spring pulls at a place that is no point.
System make_body(const Instant& start) {
  const nlohmann::json file = read_case("A1_body_offaxis_spring");
  System system = with_masses(start, {0.75, 0.75, 1.0});
  system.positions.insert(system.positions.end(), {0.5, 0.6, 0.0});
  system.velocities.insert(system.velocities.end(), {0.0, 0.0, 0.0});
  system.supports = {Support{"", {2}}};
  const double al = number(file.at("al")), bt = number(file.at("bt"));
  system.constraints = {Rods{"", {{0, 1}}, 2.0 * number(file.at("k"))}, Planes{"plane", {0, 1}, Vector3{0, 0, 1}, 0.0},
                        Linears{"", {{0, 1}}, {{0.5 + al, -bt, 0.0}, {0.5 - al, bt, 0.0}}, 0.0},
                        Linears{"", {{0, 1}}, {{bt, 0.5 + al, 0.0}, {-bt, 0.5 - al, 0.0}}, 0.0}};
  Constants constants;
  for (const auto& [name, value] : file.at("parameters").items()) constants.emplace(name, number(value));
  system.forces = {
      Gravity{"", {0.0, -9.81, 0.0}},
      Potential{"spring",
                {{0, 1, 2}},
                formula_potential(file.at("potential_entry").at("energy").get<std::string>(), 3, constants),
                {}}};
  return system;
}

/// Makes four united atoms with rigid bonds and TraPPE's angles and dihedral, in nm, ps and u.
System make_butane(const Instant& start) {
  System system = with_masses(start, {15.035, 14.027, 14.027, 15.035});
  constexpr double degree = 3.14159265358979323846 / 180.0;
  system.constraints = {Rods{"", {{0, 1}, {1, 2}, {2, 3}}, 0.154}};
  system.forces = {
      Bendings{"", {{0, 1, 2}, {1, 2, 3}}, BendingLaw::Harmonic, 519.65, 114.0 * degree},
      Torsions{"", {{0, 1, 2, 3}}, TorsionLaw::Opls, {2 * 2.9519, -2 * 0.56697, 2 * 6.5794, 0.0}, {}, 1, {}, {}}};
  return system;
}

struct PotentialCase {
  std::string name;
  System (*make)(const Instant& start);
};

struct ByMethod {
  PotentialCase scene;
  std::string interface_name;
  Interface find_answer;
  MotionOptions options;

  friend std::ostream& operator<<(std::ostream& out, const ByMethod& given) { return out << given.scene.name; }
};

std::vector<ByMethod> list_all() {
  std::vector<ByMethod> result;
  for (const PotentialCase& scene :
       {PotentialCase{"A1_body_offaxis_spring", make_body}, PotentialCase{"A2_butane_rigid_bonds", make_butane}}) {
    for (const Method method : {Method::Taylor, Method::Dop853, Method::Radau5}) {
      // radau5, of order 5, needs 20,000 steps for 1e-12. Below it the rounding of more steps adds up.
      const double rtol = method == Method::Radau5 ? 1e-12 : 1e-13;
      const MotionOptions options{.method = method, .rtol = rtol, .atol = 1e-3 * rtol};
      result.push_back({scene, "library", through_library, options});
#ifdef TANOR_PROGRAM
      result.push_back({scene, "program", through_program, options});
#endif
    }
  }
  return result;
}

class PotentialCases : public testing::TestWithParam<ByMethod> {};

TEST_P(PotentialCases, MotionHasElevenDigitsAtEveryInstant) {
  const auto& [scene, interface_name, find_answer, options] = GetParam();
  const std::vector<Instant> trajectory = read_trajectory(scene.name);
  const Instant& start = trajectory.front();
  const System system = scene.make(start);
  for (const Instant& instant : trajectory) {
    if (instant.t == 0.0) continue;
    const Answer answer = find_answer(scene.name, system, options, instant.t);
    const std::size_t size = instant.r.size();
    const auto error = [&](const std::vector<double>& found, const std::vector<double>& wanted) {
      return largest_difference(std::span(found).first(size), wanted) / largest(wanted);
    };
    EXPECT_LT(error(answer.positions, instant.r), 1e-11) << "t = " << instant.t;
    EXPECT_LT(error(answer.velocities, instant.v), 1e-11) << "t = " << instant.t;
    EXPECT_LT(error(answer.accelerations, instant.w), 1e-10) << "t = " << instant.t;
    EXPECT_NEAR(answer.energy, answer.energy_start, 1e-11 * std::abs(answer.energy_start)) << "t = " << instant.t;
    EXPECT_NEAR(answer.energy_start, *start.energy, 1e-13 * std::abs(*start.energy));
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, PotentialCases, testing::ValuesIn(list_all()), [](const auto& instance) {
  return instance.param.scene.name.substr(0, 2) + "_" + std::string(name_of(instance.param.options.method)) + "_" +
         instance.param.interface_name;
});

/// The body moves in one angle. The accelerations in coordinates and the part of the spring's force that the support
/// carries are those of the case.
TEST(PotentialCase, MotionInOneAngleIsThatOfTheCase) {
  const std::vector<Instant> trajectory = read_trajectory("A1_body_offaxis_spring");
  const Instant& start = trajectory.front();
  const double ax = start.r[0], ay = start.r[1], bx = start.r[3], by = start.r[4];
  System system = make_body(start);
  system.constraints.clear();
  const std::vector<std::string> components{"ax*cos(q) - ay*sin(q)", "ax*sin(q) + ay*cos(q)", "0",
                                            "bx*cos(q) - by*sin(q)", "bx*sin(q) + by*cos(q)", "0"};
  system.coordinates = {UserCoordinates{
      "angle",
      {{0, 1}},
      formula_coordinates(std::vector<std::string>{"q"}, components, {{"ax", ax}, {"ay", ay}, {"bx", bx}, {"by", by}}),
      {0.0},
      {-1.0}}};
  for (const Method method : {Method::Dop853, Method::Dopri5}) {
    Simulation simulation(system, {.method = method, .rtol = 1e-13, .atol = 1e-15});
    for (const Instant& instant : std::span(trajectory).subspan(1)) {
      ASSERT_TRUE(simulation.advance_to(instant.t).ok());
      EXPECT_LT(largest_difference(simulation.positions().first(6), instant.r), 1e-11) << instant.t;
      EXPECT_LT(largest_difference(simulation.velocities().first(6), instant.v), 1e-10) << instant.t;
    }
  }
}

/// The force of an energy on a support is -dU/dr there, which is the force of the spring at its far end.
TEST(PotentialCase, TheSupportCarriesTheSpring) {
  const std::vector<Instant> trajectory = read_trajectory("A1_body_offaxis_spring");
  const Instant& end = trajectory[1];
  const Answer answer =
      through_library("", make_body(trajectory.front()), {.method = Method::Taylor, .rtol = 1e-13}, end.t);
  const double a = 0.9, b = -0.4, k = 180.0, rest = 0.35;
  const double x = 0.5 * (end.r[0] + end.r[3]) + a * (end.r[0] - end.r[3]) - b * (end.r[1] - end.r[4]) - 0.5;
  const double y = 0.5 * (end.r[1] + end.r[4]) + a * (end.r[1] - end.r[4]) + b * (end.r[0] - end.r[3]) - 0.6;
  const double length = std::hypot(x, y), pull = k * (length - rest) / length;

  EXPECT_NEAR(answer.support_forces[6], pull * x, 1e-9 * k);
  EXPECT_NEAR(answer.support_forces[7], pull * y, 1e-9 * k);
}

}  // namespace
}  // namespace tanor::cases
