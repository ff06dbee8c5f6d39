/// Beads on ellipsoids follow closed forms and the motion on the same surface given as a formula.

#include <cmath>

#include <gtest/gtest.h>

#include "motion/by_method.hpp"

namespace tanor {
namespace {

using EllipsoidMotion = MotionByMethod;

/// Nothing pulls a bead out of the equator. It goes round at constant speed, held by the force m v^2/a.
TEST_P(EllipsoidMotion, EquatorIsACircle) {
  System system;
  scenes::add_point({2, 0, 0}, &system);
  system.velocities = {0, 3, 0};
  system.constraints = {Ellipsoids{"egg", {0}, {}, {2.0, 2.0, 0.5}}};
  constexpr double t_end = 2.0, angle = 3.0 / 2.0 * t_end;

  const Simulation simulation = run(system, t_end);

  EXPECT_NEAR(simulation.positions()[0], 2.0 * std::cos(angle), 1e-9);
  EXPECT_NEAR(simulation.positions()[1], 2.0 * std::sin(angle), 1e-9);
  EXPECT_NEAR(simulation.positions()[2], 0.0, 1e-12);
  EXPECT_NEAR(simulation.multipliers()[0], -scenes::mass * 9.0 / 2.0, 1e-9);
}

/// An ellipsoid with equal radii gives the positions and the force of a sphere.
TEST_P(EllipsoidMotion, EqualRadiiMakeASphere) {
  System ball;
  scenes::add_point({1.2, 0, 0.5}, &ball);
  ball.velocities = {0, 2, 0};
  ball.forces = {scenes::gravity};
  System egg = ball;
  const VectorFunction center(ScalarFunction::formula("0.1*sin(2*t)"), 0.0, 0.0);
  ball.velocities[0] = egg.velocities[0] = 0.2;
  ball.constraints = {Spheres{"ball", {0}, center, 1.3}};
  egg.constraints = {Ellipsoids{"egg", {0}, center, {1.3, 1.3, 1.3}, {Vector3{1, 1, 0}, Vector3{0, 1, 3}}}};

  const Simulation expected = run(ball, 1.0), simulation = run(egg, 1.0);

  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(simulation.positions()[i], expected.positions()[i], 1e-8);
  EXPECT_NEAR(simulation.multipliers()[0], expected.multipliers()[0], 1e-7);
}

/// The surface x^2/4 + y^2 + z^2/9 = 1 gives the same motion as a kind and as a formula, and the energy stays.
TEST_P(EllipsoidMotion, AgreesWithTheSurfaceAsAFormula) {
  System egg;
  const double x = 2.0 * 0.6, z = 3.0 * 0.8;
  scenes::add_point({x, 0, z}, &egg);
  egg.velocities = {0, 1.5, 0};
  egg.forces = {scenes::gravity};
  System formula = egg;
  egg.constraints = {Ellipsoids{"egg", {0}, {}, {3.0, 2.0, 1.0}, {Vector3{0, 0, 1}, Vector3{1, 0, 0}}}};
  formula.constraints = {UserConstraints{"egg", {{0}}, formula_constraint("x1^2/4 + y1^2 + z1^2/9 - 1", 1)}};

  const Simulation simulation = run(egg, 2.0), expected = run(formula, 2.0);

  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(simulation.positions()[i], expected.positions()[i], 1e-7);
    EXPECT_NEAR(simulation.reactions()[i], expected.reactions()[i], 1e-5);
  }
  // The gradient has unit length on the surface, so that lambda is the size of the force.
  const auto eta = simulation.reactions();
  EXPECT_NEAR(std::abs(simulation.multipliers()[0]), std::hypot(eta[0], eta[1], eta[2]), 1e-10);
  EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Methods, EllipsoidMotion, series_and_kernels, name_method);

/// The same surface is given twice, so that one row is redundant, and the multipliers share the load.
TEST(Ellipsoid, SecondEqualSurfaceIsRedundant) {
  System system;
  scenes::add_point({0, 0, 0.5}, &system);
  system.forces = {scenes::gravity};
  const Ellipsoids egg{"", {0}, {}, {2.0, 1.0, 0.5}};
  system.constraints = {egg, egg};

  Simulation simulation(system);

  EXPECT_EQ(simulation.rank().rank, 1u);
  EXPECT_NEAR(simulation.multipliers()[0], 0.5 * scenes::mass * 9.81, 1e-12);
  EXPECT_NEAR(simulation.multipliers()[1], 0.5 * scenes::mass * 9.81, 1e-12);
}

}  // namespace
}  // namespace tanor
