#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include <tanor/system.hpp>

#include "measures.hpp"

/// \file A valid system with everything, and the message of validation where one thing of it is changed.
namespace tanor::everything {

inline constexpr double infinity = std::numeric_limits<double>::infinity();

inline ScalarFunction formula(const char* text) {
  return ScalarFunction::formula(text);
}

/// Makes a system with everything once, on 8 points in general position; point 0 is a support, point 7 another one that
/// moves.
///
///   constraints  0 rods  1 floor  2 ball  3 wire  4 ring  5 bend  6 rope  7 sum      forces  0 … 3
inline System make_system() {
  System system;
  for (int i = 0; i < 8; ++i) {
    const double x = 1.0 * i;
    system.positions.insert(system.positions.end(), {x, 0.3 + x * x / 7, 0.1 - std::sin(x)});
  }
  system.velocities.assign(24, 0.0);
  system.masses.assign(8, 0.1);
  system.supports = {{"anchor", {0}, {}}, {"drive", {7}, {formula("0.1*sin(3*t)"), 0.0, 0.0}}};

  Rods rods{"rods", {{0, 1}, {1, 2}, {2, 3}}, {}, {}};
  Planes floor{"floor", {4, 5}, Vector3{0, 0, 2}, formula("0.1*t")};
  Spheres ball{"ball", {3}, {}, {}};
  Lines wire{"wire", {4, 6}, {}, Vector3{1, 0, 0}};
  Circles ring{"ring", {5}, {}, Vector3{0, 0, 1}, {}};
  Angles bend{"bend", {{0, 1, 2}, {1, 2, 3}}, {}};
  Pulleys rope{"rope", {{1, 4}}, {0, 0, 5}, {1, 0, 5}, {}, 2.0};
  Linears sum{"sum", {{1, 2}, {5, 6}}, {{1, 0, 0}, {0, 1, 0}}, 0.5};
  system.constraints = {rods, floor, ball, wire, ring, bend, rope, sum};

  Gravity gravity{"gravity", {0, 0, -9.81}};
  ConstantForce wind{"wind", {1, 2}, Vector3{1, 0, 0}};
  Springs springs{"springs", {{3, 6}}, 10.0, 0.1, {}};
  Drag air{"air", {1, 2, 3}, 0.1, 0.2};
  system.forces = {gravity, wind, springs, air};
  return system;
}

template <class Group>
Group& constraint(System& system, std::size_t group) {
  return std::get<Group>(system.constraints[group]);
}

template <class Group>
Group& force(System& system, std::size_t index) {
  return std::get<Group>(system.forces[index]);
}

/// Returns "where: what" of the message about the system with one thing changed.
inline std::string error_after(const std::function<void(System&)>& change, double t = 0.0) {
  System system = make_system();
  change(system);
  try {
    validate(system, t);
  } catch (const InputError& error) {
    return error.where() + ": " + error.what();
  }
  return "valid";
}

}  // namespace tanor::everything
