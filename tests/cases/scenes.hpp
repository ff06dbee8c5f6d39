#pragma once

#include <array>
#include <cmath>
#include <ostream>
#include <string>
#include <vector>

#include <tanor/system.hpp>

#include "cases/reference_case.hpp"

/// The reference cases as systems of tanor. Their masses stand side by side, in the case's order, behind the supports.
namespace tanor::cases {

struct CaseScene {
  std::string name;       // also the name of tests/cases/scenes/<name>.json
  std::string reference;  // name of the case's file
  std::size_t num_supports = 0;
  System (*build)(const Instant& start) = nullptr;
  // These follow from the case's own constraint functions and multipliers.
  std::vector<double> (*reactions)(const Instant&) = nullptr;    // K lambda on the masses
  std::vector<double> (*multipliers)(const Instant&) = nullptr;  // for tanor's constraint functions

  friend std::ostream& operator<<(std::ostream& out, const CaseScene& scene) { return out << scene.name; }
};

inline Vector3 point(const std::vector<double>& array, std::size_t i) {
  return {array[3 * i], array[3 * i + 1], array[3 * i + 2]};
}

// ---- systems -------------------------------------------------------------------------------------------------------

/// Makes the masses of a case behind some supports, which stand at the given places at the start.
inline System make_system(const Instant& start, const std::vector<Vector3>& supports, std::vector<double> masses) {
  System system;
  for (const Vector3& support : supports) {
    system.supports.push_back({{}, {static_cast<Index>(system.supports.size())}, {}});
    system.positions.insert(system.positions.end(), support.begin(), support.end());
  }
  system.positions.insert(system.positions.end(), start.r.begin(), start.r.end());
  system.velocities.assign(3 * supports.size(), 0.0);
  system.velocities.insert(system.velocities.end(), start.v.begin(), start.v.end());
  system.masses.assign(supports.size(), 1.0);
  system.masses.insert(system.masses.end(), masses.begin(), masses.end());
  return system;
}

inline Rods make_chain_rods(std::size_t count, Parameter length) {
  Rods rods{"rods", {}, std::move(length), {}};
  for (std::size_t k = 0; k < count; ++k) rods.pairs.push_back({static_cast<Index>(k), static_cast<Index>(k + 1)});
  return rods;
}

/// Makes beads that hang on one another, the first one on a support at the origin.
inline System make_hanging_chain(const Instant& start, double mass, const Vector3& gravity, Parameter length) {
  const std::size_t count = start.r.size() / 3;
  System system = make_system(start, {{0, 0, 0}}, std::vector<double>(count, mass));
  system.constraints = {make_chain_rods(count, std::move(length))};
  system.forces = {Gravity{"gravity", gravity}};
  return system;
}

inline System make_planar_pendulum(const Instant& start) {
  return make_hanging_chain(start, 1.0, {0, -9.81, 0}, 1.0);
}

/// Makes the same motion on a wire, without a support.
inline System make_pendulum_on_circle(const Instant& start) {
  System system = make_system(start, {}, {1.0});
  system.constraints = {Circles{"wire", {0}, Vector3{0, 0, 0}, Vector3{0, 0, 1}, 1.0}};
  system.forces = {Gravity{"gravity", {0, -9.81, 0}}};
  return system;
}

inline System make_spherical_pendulum(const Instant& start) {
  return make_hanging_chain(start, 1.0, {0, 0, -9.81}, 1.0);
}

inline System make_pendulum_on_sphere(const Instant& start) {
  System system = make_system(start, {}, {1.0});
  system.constraints = {Spheres{"ball", {0}, Vector3{0, 0, 0}, 1.0}};
  system.forces = {Gravity{"gravity", {0, 0, -9.81}}};
  return system;
}

inline System make_swinging_atwood(const Instant& start) {
  System system = make_system(start, {}, {1.0, 1.5});
  system.constraints = {Pulleys{"rope", {{0, 1}}, {-1, 0, 0}, {1, 0, 0}, 3.0, 1.0}};
  system.forces = {Gravity{"gravity", {0, -9.81, 0}}};
  return system;
}

inline System make_double_pendulum(const Instant& start) {
  return make_hanging_chain(start, 1.0, {0, -9.81, 0}, 1.0);
}

/// Makes the double pendulum with two more equations that keep it in its plane and whose multipliers vanish.
inline System make_double_pendulum_in_plane(const Instant& start) {
  System system = make_double_pendulum(start);
  system.constraints.push_back(Planes{"plane", {1, 2}, Vector3{0, 0, 1}, 0.0});
  return system;
}

inline System make_chain_of_10(const Instant& start) {
  return make_hanging_chain(start, 0.1, {0, -9.81, 0}, 0.1);
}

inline System make_variable_length(const Instant& start) {
  return make_hanging_chain(start, 1.0, {0, -9.81, 0}, ScalarFunction::formula("1 + 0.3*sin(2*t)"));
}

/// Makes a bead on a hoop of radius 1 that turns about its vertical diameter, by a ball and a plane that turns.
inline System make_rotating_hoop(const Instant& start) {
  System system = make_system(start, {}, {1.0});
  system.constraints = {
      Spheres{"ball", {0}, Vector3{0, 0, 0}, 1.0},
      Planes{"hoop", {0}, {ScalarFunction::formula("sin(5*t)"), ScalarFunction::formula("-cos(5*t)"), 0.0}, 0.0}};
  system.forces = {Gravity{"gravity", {0, 0, -9.81}}};
  return system;
}

/// Makes the same system with one formula for each constraint of the case.
inline System make_rotating_hoop_by_formulas(const Instant& start) {
  System system = make_rotating_hoop(start);
  const Constants constants = {{"omega", 5.0}};
  system.constraints = {
      UserConstraints{"ball", {{0}}, formula_constraint("(x1^2 + y1^2 + z1^2 - 1)/2", 1)},
      UserConstraints{"hoop", {{0}}, formula_constraint("x1*sin(omega*t) - y1*cos(omega*t)", 1, constants)}};
  return system;
}

/// The car axis of the IVP test set. The right angle at the origin guides the left mass, and the support at (xb, yb) =
/// (sqrt(1 - yb^2), sin(10 t)/10) drives the right one:
///
///   left 2 ----rod---- 3 right
///        |spring       |spring
///      0 origin      1 (xb, yb)
inline System make_car_axis(const Instant& start) {
  System system = make_system(start, {{0, 0, 0}, {1, 0, 0}}, {5e-4, 5e-4});
  system.supports[1].displacement = {ScalarFunction::formula("sqrt(1 - (0.1*sin(10*t))^2) - 1"),
                                     ScalarFunction::formula("0.1*sin(10*t)"), 0.0};
  system.constraints = {Angles{"right_angle", {{2, 0, 1}}, 0.0}, Rods{"axle", {{2, 3}}, 1.0, {}}};
  system.forces = {Springs{"springs", {{0, 2}, {1, 3}}, 1.0, 0.0, 0.5}, Gravity{"gravity", {0, -1, 0}}};
  return system;
}

/// Makes three parallel cranks, whose tips are coupled by one rod more than they need.
inline System make_redundant_parallelogram(const Instant& start) {
  System system = make_system(start, {{0, 0, 0}, {1, 0, 0}, {2.5, 0, 0}}, {1.0, 2.0, 3.0});
  system.constraints = {Rods{"cranks", {{0, 3}, {1, 4}, {2, 5}}, 1.0, {}},
                        Rods{"couplers", {{3, 4}, {4, 5}, {3, 5}}, std::vector{1.0, 1.5, 2.5}, {}}};
  system.forces = {Gravity{"gravity", {0, -9.81, 0}}};
  return system;
}

// ---- K lambda ------------------------------------------------------------------------------------------------------

inline void add(double factor, const Vector3& vector, std::size_t i, std::vector<double>* array) {
  for (std::size_t axis = 0; axis < 3; ++axis) (*array)[3 * i + axis] += factor * vector[axis];
}

inline Vector3 difference(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

inline double length(const Vector3& a) {
  return std::hypot(a[0], a[1], a[2]);
}

/// Returns K lambda of rods (|r_k - r_{k-1}|^2 - l^2)/2 along a chain from the origin.
inline std::vector<double> chain_reactions(const Instant& instant) {
  std::vector<double> result(instant.r.size(), 0.0);
  for (std::size_t k = 0; k < instant.lambda.size(); ++k) {
    const Vector3 before = k > 0 ? point(instant.r, k - 1) : Vector3{0, 0, 0};
    const Vector3 rod = difference(point(instant.r, k), before);
    add(instant.lambda[k], rod, k, &result);
    if (k > 0) add(-instant.lambda[k], rod, k - 1, &result);
  }
  return result;
}

/// Returns K lambda of |r_1 - a| + |r_2 - b| - L.
inline std::vector<double> pulley_reactions(const Instant& instant) {
  std::vector<double> result(6, 0.0);
  for (std::size_t i = 0; i < 2; ++i) {
    const Vector3 rope = difference(point(instant.r, i), {i == 0 ? -1.0 : 1.0, 0, 0});
    add(instant.lambda[0] / length(rope), rope, i, &result);
  }
  return result;
}

/// Returns K lambda of xl xb + yl yb and (xl - xr)^2 + (yl - yr)^2 - L^2.
inline std::vector<double> car_axis_reactions(const Instant& instant) {
  const double yb = 0.1 * std::sin(10.0 * instant.t), xb = std::sqrt(1.0 - yb * yb);
  const Vector3 axle = difference(point(instant.r, 0), point(instant.r, 1));
  std::vector<double> result(6, 0.0);
  add(instant.lambda[0], {xb, yb, 0}, 0, &result);
  add(2.0 * instant.lambda[1], axle, 0, &result);
  add(-2.0 * instant.lambda[1], axle, 1, &result);
  return result;
}

/// Returns K lambda of (|r|^2 - 1)/2 and x sin 5t - y cos 5t.
inline std::vector<double> hoop_reactions(const Instant& instant) {
  std::vector<double> result(3, 0.0);
  add(instant.lambda[0], point(instant.r, 0), 0, &result);
  add(instant.lambda[1], {std::sin(5.0 * instant.t), -std::cos(5.0 * instant.t), 0}, 0, &result);
  return result;
}

/// Returns m (w - g), which is along the crank, since each tip swings like a pendulum of its own.
inline std::vector<double> parallelogram_reactions(const Instant& instant) {
  std::vector<double> result(9, 0.0);
  for (std::size_t i = 0; i < 3; ++i) {
    const double mass = static_cast<double>(i + 1);
    add(mass, point(instant.w, i), i, &result);
    add(mass, {0, 9.81, 0}, i, &result);
  }
  return result;
}

// ---- multipliers ---------------------------------------------------------------------------------------------------

/// The gradient of |dr| - l is that of (|dr|^2 - l^2)/2 over l, so that tanor's multiplier is lambda times l.
inline std::vector<double> chain_multipliers(const Instant& instant) {
  std::vector<double> result = instant.lambda;
  for (std::size_t k = 0; k < result.size(); ++k) {
    const Vector3 before = k > 0 ? point(instant.r, k - 1) : Vector3{0, 0, 0};
    result[k] *= length(difference(point(instant.r, k), before));
  }
  return result;
}

/// Returns the multipliers of a circle's two rows. The first row is the plane, which carries nothing here.
inline std::vector<double> circle_multipliers(const Instant& instant) {
  return {0.0, chain_multipliers(instant).front()};
}

inline std::vector<double> chain_in_plane_multipliers(const Instant& instant) {
  std::vector<double> result = chain_multipliers(instant);
  result.resize(2 * result.size(), 0.0);
  return result;
}

inline std::vector<double> pulley_multipliers(const Instant& instant) {
  return instant.lambda;
}

/// The radius is 1, so both gradients have length 1 in each formulation.
inline std::vector<double> hoop_multipliers(const Instant& instant) {
  return instant.lambda;
}

/// The cosine is (rl.rb)/(|rl| |rb|) with |rb| = 1 at the right angle. The rod has length 1.
inline std::vector<double> car_axis_multipliers(const Instant& instant) {
  return {instant.lambda[0] * length(point(instant.r, 0)), 2.0 * instant.lambda[1]};
}

/// The couplers are redundant and carry nothing, so that their least multipliers are 0. A crank has eta along it.
inline std::vector<double> parallelogram_multipliers(const Instant& instant) {
  const std::vector<double> eta = parallelogram_reactions(instant);
  std::vector<double> result(6, 0.0);
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3 crank = difference(point(instant.r, i), {std::array{0.0, 1.0, 2.5}[i], 0, 0});
    const Vector3 force = point(eta, i);
    result[i] = crank[0] * force[0] + crank[1] * force[1];
  }
  return result;
}

// ---- all of them ---------------------------------------------------------------------------------------------------

inline const std::vector<CaseScene>& moving_cases() {
  static const std::vector<CaseScene> scenes{
      {"01_planar_pendulum", "01_planar_pendulum", 1, make_planar_pendulum, chain_reactions, chain_multipliers},
      {"01_pendulum_on_circle", "01_planar_pendulum", 0, make_pendulum_on_circle, chain_reactions, circle_multipliers},
      {"02_spherical_pendulum", "02_spherical_pendulum", 1, make_spherical_pendulum, chain_reactions,
       chain_multipliers},
      {"02_pendulum_on_sphere", "02_spherical_pendulum", 0, make_pendulum_on_sphere, chain_reactions,
       chain_multipliers},
      {"03_rotating_hoop", "03_rotating_hoop", 0, make_rotating_hoop, hoop_reactions, hoop_multipliers},
      {"03_rotating_hoop_by_formulas", "03_rotating_hoop", 0, make_rotating_hoop_by_formulas, hoop_reactions,
       hoop_multipliers},
      {"05_atwood_swinging", "05_atwood_swinging", 0, make_swinging_atwood, pulley_reactions, pulley_multipliers},
      {"07_chain2", "07_chain2", 1, make_double_pendulum, chain_reactions, chain_multipliers},
      {"07_chain2_in_plane", "07_chain2", 1, make_double_pendulum_in_plane, chain_reactions,
       chain_in_plane_multipliers},
      {"08_chain10", "08_chain10", 1, make_chain_of_10, chain_reactions, chain_multipliers},
      {"11_variable_length", "11_variable_length", 1, make_variable_length, chain_reactions, chain_multipliers},
      {"12_car_axis", "12_car_axis", 2, make_car_axis, car_axis_reactions, car_axis_multipliers},
      {"18a_redundant_parallelogram", "18a_redundant_parallelogram", 3, make_redundant_parallelogram,
       parallelogram_reactions, parallelogram_multipliers}};
  return scenes;
}

/// Makes case 06, which hangs at rest between two supports, point 0 and point 10.
inline System make_catenary() {
  const nlohmann::json file = read_case("06_catenary_N10");
  System system;
  system.positions = {0, 0, 0};
  for (const nlohmann::json& node : file.at("nodes")) {
    const std::vector<double> place = make_spatial(numbers(node), 2);
    system.positions.insert(system.positions.end(), place.begin(), place.end());
  }
  system.masses.assign(11, 0.1);
  system.supports = {{"left", {0}, {}}, {"right", {10}, {}}};
  system.constraints = {make_chain_rods(10, 0.1)};
  system.forces = {Gravity{"gravity", {0, -9.81, 0}}};
  return system;
}

}  // namespace tanor::cases
