#pragma once

/// \file Beads on guides with corners.

#include <cmath>
#include <string>
#include <vector>

#include <tanor/tanor.hpp>

#include "methods.hpp"

namespace tanor {

inline MotionOptions corner_options(Method method) {
  MotionOptions options{.method = method};
  if (has_fixed_steps(method))
    options.step = 2e-3;
  else
    options.rtol = options.atol = 1e-12;
  return options;
}

inline std::vector<Method> list_all_methods() {
  return with_auto(list_methods_that([](const MethodTraits&) { return true; }));
}

/// Returns how far a method of fixed steps may be off.
inline double allowed(Method method, double fixed = 1e-4) {
  return has_fixed_steps(method) ? fixed : 1e-9;
}

/// Returns a bead of 1 kg at rest on the wire z = |x| in the plane y = 0, 1 m beside its corner, under g = 10 m/s^2.
inline System make_bead_on_v(const std::string& equation = "z1-abs(x1)") {
  System system;
  system.positions = {1.0, 0.0, 1.0};
  system.velocities = {0.0, 0.0, 0.0};
  system.masses = {1.0};
  system.constraints = {Planes{.name = "sheet", .points = {0}, .normal = Vector3{0.0, 1.0, 0.0}, .offset = 0.0},
                        UserConstraints{.name = "wire", .tuples = {{0}}, .kernel = formula_constraint(equation, 1)}};
  system.forces = {Gravity{"", {0.0, 0.0, -10.0}}};
  return system;
}

/// The bead's x: from a turning point at distance 1 down to the corner, up the other side, and so on.
inline double x_of_bead(double t) {
  const double quarter = std::sqrt(2.0 * std::sqrt(2.0) / (10.0 / std::sqrt(2.0)));
  const double turns = std::floor(0.5 * (t / quarter + 1.0));
  const double since = t - 2.0 * quarter * turns;
  return std::cos(M_PI * turns) * (1.0 - 2.5 * since * since);
}

/// Returns the plane x + z = c |t - 0.5| + 0.4 with a rod to another point, as in a scene that was reported.
inline System make_plane_with_corner(const std::string& offset) {
  System system;
  system.positions = {0.0, 0.0, 0.0, 0.6, 0.0, 0.0};
  system.velocities = {0.11538461538461539, 0.0, 0.0, 0.11538461538461539, 0.0, -0.5153846153846153};
  system.masses = {1.0, 1.0};
  system.constraints = {
      Planes{
          .name = "plane", .points = {1}, .normal = Vector3{1.0, 0.0, 1.0}, .offset = ScalarFunction::formula(offset)},
      Rods{.name = "rod", .pairs = {{0, 1}}, .length = 0.6, .offsets = {}}};
  system.forces = {Gravity{"", {0.0, 0.0, -10.0}}};
  return system;
}

}  // namespace tanor
