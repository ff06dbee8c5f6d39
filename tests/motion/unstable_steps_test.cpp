/// Explicit steps of a fixed length that are too long for a stiff system: velocities grow without end, and no energy
/// comes from anywhere.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <tanor/tanor.hpp>

namespace tanor {
namespace {

/// Makes a block of 1 kg that slides at 1 m/s on an oiled floor, which moves at `speed`.
System make_oiled_block(double coefficient, double speed) {
  System system;
  system.positions = {0.0, 0.0, 0.0};
  system.velocities = {1.0, 0.0, 0.0};
  system.masses = {1.0};
  system.constraints = {Planes{"floor", {0}, Vector3{0.0, 0.0, 1.0}, 0.0}};
  system.friction = {
      Viscous{.name = "oil", .at = {"floor"}, .coefficient = coefficient, .velocity = Vector3{speed, 0.0, 0.0}}};
  return system;
}

/// Makes a bead of 1 kg at rest on a spring that is stretched by 0.1 m.
System make_spring(double stiffness) {
  System system;
  system.positions = {0.0, 0.0, 0.0, 1.1, 0.0, 0.0};
  system.velocities.assign(6, 0.0);
  system.masses = {1.0, 1.0};
  system.supports = {{"wall", {0}, {}}};
  system.forces = {Springs{.name = "spring", .pairs = {{0, 1}}, .stiffness = stiffness, .rest_length = 1.0}};
  return system;
}

/// A step multiplies the velocity by 1 - z + z^2/2 - z^3/6 + z^4/24 = 291 at z = c h/m = 10.
TEST(UnstableSteps, EndByName) {
  for (const double speed : {0.0, 0.3}) {
    for (const Method method : {Method::Rk4, Method::Rattle}) {
      SCOPED_TRACE(std::string(name_of(method)) + " " + std::to_string(speed));
      Simulation simulation(make_oiled_block(1e3, speed), {.method = method, .step = 0.01});

      const Outcome outcome = simulation.advance_to(1.0);

      EXPECT_EQ(outcome.status, Status::NotFinite);
      EXPECT_NE(outcome.what.find("steps of a fixed length are unstable: the kinetic energy has grown"),
                std::string::npos)
          << outcome.what;
      EXPECT_LT(simulation.time(), 0.05);
      EXPECT_FALSE(simulation.advance_to(2.0).ok());
    }
  }
}

/// The energy that a spring keeps is no supply. It grows with the error.
TEST(UnstableSteps, OfASpringEndByName) {
  for (const Method method : {Method::Rk4, Method::Rattle}) {
    Simulation simulation(make_spring(1e6), {.method = method, .step = 0.01});

    const Outcome outcome = simulation.advance_to(1.0);

    EXPECT_NE(outcome.what.find("steps of a fixed length are unstable"), std::string::npos)
        << name_of(method) << ": " << outcome.what;
  }
}

/// Steps that are stable go on: v = u + (1 - u) exp(-c t/m), also where a floor drags the block from rest.
TEST(UnstableSteps, AreNotFoundWhereStepsAreStable) {
  for (const double speed : {0.0, 50.0}) {
    Simulation simulation(make_oiled_block(20.0, speed), {.method = Method::Rk4, .step = 0.01});

    const Outcome outcome = simulation.advance_to(0.5);

    ASSERT_TRUE(outcome.ok()) << outcome.what;
    EXPECT_NEAR(simulation.velocities()[0], speed + (1.0 - speed) * std::exp(-10.0), 1e-4 * (1.0 + speed));
  }
  Simulation spring(make_spring(100.0), {.method = Method::Rk4, .step = 0.01});
  ASSERT_TRUE(spring.advance_to(5.0).ok()) << spring.outcome().what;
  EXPECT_NEAR(spring.positions()[3], 1.0 + 0.1 * std::cos(50.0), 1e-3);
}

}  // namespace
}  // namespace tanor
