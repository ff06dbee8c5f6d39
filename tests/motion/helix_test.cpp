/// A helix is an inclined plane rolled up, on which beads slide.

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "motion/by_method.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

using scenes::g;
constexpr double radius = 0.5, pitch = 0.6, q = pitch / (2.0 * std::numbers::pi);
constexpr double sine2 = q * q / (radius * radius + q * q);  // the squared sine of the slope

/// Makes a bead at rest at (radius, 0, 0) on a wire around the z axis with phase 0.
System bead_on_a_helix() {
  System system;
  scenes::add_point({radius, 0, 0}, &system);
  system.constraints = {Helices{"wire", {0}, {}, {0, 0, 2}, radius, pitch, {}}};
  system.forces = {scenes::gravity};
  return system;
}

void expect_at_height(const Simulation& simulation, double z, double turned, double tolerance) {
  const double angle = z / q + turned;
  EXPECT_NEAR(simulation.positions()[0], radius * std::cos(angle), tolerance);
  EXPECT_NEAR(simulation.positions()[1], radius * std::sin(angle), tolerance);
  EXPECT_NEAR(simulation.positions()[2], z, tolerance);
}

using HelixMotion = MotionByMethod;

/// The bead falls as z = -(1/2) g sin^2 t^2. The wire holds m R omega^2 inwards and m g cos across.
TEST_P(HelixMotion, BeadSlidesDownAsOnAnIncline) {
  constexpr double t_end = 3.0, z = -0.5 * g * sine2 * t_end * t_end, omega = -g * sine2 * t_end / q;

  const Simulation simulation = run(bead_on_a_helix(), t_end);

  expect_at_height(simulation, z, 0.0, 1e-8);
  EXPECT_NEAR(simulation.multipliers()[0], -scenes::mass * radius * omega * omega, 1e-8);
  EXPECT_NEAR(simulation.multipliers()[1], -scenes::mass * g * std::sqrt(1.0 - sine2), 1e-8);
  EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), 1e-9);
}

/// A bead that starts with the speed of a turning screw moves in its frame by gravity alone.
TEST_P(HelixMotion, ScrewCarriesItsBeadRound) {
  System system = bead_on_a_helix();
  std::get<Helices>(system.constraints[0]).phase = ScalarFunction::formula("3*t");
  system.velocities = {0, 3.0 * radius, 0};
  constexpr double t_end = 2.0;

  expect_at_height(run(system, t_end), -0.5 * g * sine2 * t_end * t_end, 3.0 * t_end, 1e-8);
}

/// A wire winds the other way, through a point of another angle, on an axis that rises.
TEST_P(HelixMotion, NegativePitchWindsTheOtherWay) {
  System system;
  scenes::add_point({0, radius, 0}, &system);
  system.velocities = {0, 0, 0.4};
  system.forces = {scenes::gravity};
  const VectorFunction origin(0.0, 0.0, ScalarFunction::formula("0.4*t"));
  system.constraints = {Helices{"wire", {0}, origin, {0, 0, 1}, radius, -pitch, {}}};
  constexpr double t_end = 1.5, z = -0.5 * g * sine2 * t_end * t_end;  // in the frame of the wire

  const Simulation simulation = run(system, t_end);

  EXPECT_NEAR(simulation.positions()[0], radius * std::sin(z / q), 1e-8);
  EXPECT_NEAR(simulation.positions()[1], radius * std::cos(z / q), 1e-8);
  EXPECT_NEAR(simulation.positions()[2], z + 0.4 * t_end, 1e-8);
}

INSTANTIATE_TEST_SUITE_P(Methods, HelixMotion, series_and_kernels, name_method);

/// A helix is a guide: with -c v along the wire, z'' = -g sin^2 - k z' with k = c/m.
TEST(Helix, ViscousFrictionSlowsTheBead) {
  System system = bead_on_a_helix();
  system.friction = {Viscous{"oil", {"wire"}, 0.2}};
  Simulation simulation(system, {.rtol = 1e-11, .atol = 1e-12});
  constexpr double t_end = 2.0, k = 0.2 / scenes::mass;
  const double z = -g * sine2 / (k * k) * (k * t_end - 1.0 + std::exp(-k * t_end));

  ASSERT_TRUE(simulation.advance_to(t_end).ok());

  expect_at_height(simulation, z, 0.0, 1e-8);
}

/// A rough wire holds a bead while mu is at least the tangent of its slope.
TEST(Helix, RoughWireHoldsItsBead) {
  const double slope = q / radius;
  for (const double mu : {1.01 * slope, 0.99 * slope}) {
    System system = bead_on_a_helix();
    system.friction = {Coulomb{.name = "rough", .at = {"wire"}, .coefficient = mu}};
    Simulation simulation(system, {.rtol = 1e-9, .atol = 1e-11});

    ASSERT_TRUE(simulation.advance_to(0.5).ok());

    if (mu > slope)
      EXPECT_EQ(simulation.positions()[2], 0.0);
    else
      EXPECT_LT(simulation.positions()[2], -1e-6);
  }
}

/// Two equal wires have the same points, so that two of their four rows are redundant.
TEST(Helix, SecondEqualWireIsRedundant) {
  System system = bead_on_a_helix();
  system.constraints.push_back(Helices{"", {0}, {}, {0, 0, 1}, radius, pitch, 0.0});

  EXPECT_EQ(Simulation(system).rank().rank, 2u);
}

}  // namespace
}  // namespace tanor
