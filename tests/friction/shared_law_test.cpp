/// Many contacts of one law are evaluated together, each with its own multipliers.

#include <gtest/gtest.h>
#include <tanor/dynamics.hpp>
#include <tanor/user_kernel.hpp>

namespace tanor {
namespace {

/// Beads slide along x under a weight of 3 m and 9 m N in y and z. Each is slowed by 0.1 lambda_1 + 0.2 lambda_2 = 2.1
/// m, so its mass must not matter.
TEST(SharedLaw, EachContactReadsItsOwnMultipliers) {
  constexpr int count = 150;  // more than one batch
  System system;
  Lines lines{"wires", {}, Vector3{}, Vector3{1.0, 0.0, 0.0}};
  for (Index i = 0; i < count; ++i) {
    system.positions.insert(system.positions.end(), {0.1 * i, 0.0, 0.0});
    system.velocities.insert(system.velocities.end(), {1.0 + 0.02 * i, 0.0, 0.0});
    system.masses.push_back(0.5 + 0.01 * i);
    lines.points.push_back(i);
  }
  system.constraints = {lines};
  system.forces = {Gravity{"", {0.0, -3.0, -9.0}}};
  UserFriction law{.name = "drag", .at = {"wires"}};
  law.kernel = make_friction_kernel<2>([](const Vector3&, const Vector3&, double, const auto& lambda) {
    const auto size = 0.1 * lambda[0] + 0.2 * lambda[1];
    return std::array{-size, 0.0 * size, 0.0 * size};
  });
  system.friction = {law};
  Dynamics dynamics(system);
  std::vector<double> w(3 * count), lambda(2 * count);

  const SolveReport report =
      dynamics.solve({.time = 0.0, .positions = system.positions, .velocities = system.velocities},
                     {.accelerations = w, .multipliers = lambda});

  ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_NEAR(w[3 * i], -2.1, 1e-14);
    EXPECT_NEAR(lambda[2 * i], 3.0 * system.masses[i], 1e-13);
    EXPECT_NEAR(lambda[2 * i + 1], 9.0 * system.masses[i], 1e-13);
  }
}

}  // namespace
}  // namespace tanor
