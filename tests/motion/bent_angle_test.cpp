/// Angles that are nearly straight are held as precisely as their points tell them, since their cosine cannot.

#include <cmath>

#include <gtest/gtest.h>
#include <tanor/motion.hpp>

#include "methods.hpp"

namespace tanor {
namespace {

/// Makes three beads on two rods, bent by `angle` in the plane y = 0, falling and turning in it.
System make_bent_rods(double angle) {
  System system;
  system.positions = {0, 0, 0, 1, 0, 0, 1 + std::cos(angle), 0, -std::sin(angle)};
  system.velocities = {0, 0, 0, 0, 0, -3, -3 * std::sin(angle), 0, -3 * (1 + std::cos(angle))};
  system.masses = {1, 1, 2};
  system.supports = {{"", {0}, {}}};
  system.constraints = {Rods{"rods", {{0, 1}, {1, 2}}, {}, {}}, Angles{"knee", {{0, 1, 2}}, {}},
                        Planes{"page", {1, 2}, Vector3{0, 1, 0}, 0.0}};
  system.forces = {Gravity{"", {0, 0, -9.81}}};
  return system;
}

TEST(BentAngle, IsHeldDownToATenMillionth) {
  for (const double angle : {1e-2, 1e-4, 1e-5, 1e-6, 1e-7}) {
    for (const Method method : list_explicit_adaptive_methods()) {
      const System system = make_bent_rods(angle);
      Simulation simulation(system, {.method = method, .rtol = 1e-9, .atol = 1e-11});
      ASSERT_TRUE(simulation.outcome().ok()) << angle << ": " << simulation.outcome().what;

      const Outcome outcome = simulation.advance_to(1.0);

      ASSERT_TRUE(outcome.ok()) << angle << " by " << name_of(method) << ": " << outcome.what;
      const std::span<const double> r = simulation.positions();
      const double ax = r[3], az = r[5], bx = r[6] - r[3], bz = r[8] - r[5];
      // In double precision the cosine at the start determines the angle to eps/angle.
      EXPECT_NEAR(std::atan2(ax * bz - az * bx, ax * bx + az * bz), -angle, 1e-15 + 3e-16 / angle) << angle;
      EXPECT_LT(simulation.report().steps, 400u) << "it moves as a rigid body does, however little it is bent";
      EXPECT_TRUE(simulation.certify().passed()) << angle << ": " << simulation.certify().line();
    }
  }
}

}  // namespace
}  // namespace tanor
