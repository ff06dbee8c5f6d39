#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <tanor/tanor.hpp>

#include "motion/rough_guides.hpp"

/// \file A rope of beads and rods around a rough cylinder (Euler, Eytelwein). Rods make the angle D/2 with the
/// tangents:
///
///   (T' - T) cos(D/2) = mu N,   N = (T + T') sin(D/2),   T'/T = (1 + mu tan(D/2))/(1 - mu tan(D/2)) -> e^(mu D)
namespace tanor {
namespace {

constexpr double radius = 0.3, mu = 0.3;

double ratio(double D) {
  return (1.0 + mu * std::tan(0.5 * D)) / (1.0 - mu * std::tan(0.5 * D));
}

/// Makes `count` beads that go half around. The ends are pulled along the rods that would come next, the first by 1 N.
System make_rope(std::size_t count, double speed, double pull) {
  const double D = std::numbers::pi / static_cast<double>(count);
  System system;
  Circles cylinder{"cylinder", {}, Vector3{}, Vector3{0.0, 0.0, 1.0}, radius};
  Rods rods{"rods", {}, {}, {}};
  const auto place = [&](double k) { return Vector3{radius * std::cos(k * D), radius * std::sin(k * D), 0.0}; };
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3 r = place(static_cast<double>(k));
    system.positions.insert(system.positions.end(), r.begin(), r.end());
    system.velocities.insert(system.velocities.end(), {-speed * r[1] / radius, speed * r[0] / radius, 0.0});
    system.masses.push_back(0.1);
    cylinder.points.push_back(static_cast<Index>(k));
    if (k > 0) rods.pairs.push_back({static_cast<Index>(k) - 1, static_cast<Index>(k)});
  }
  const auto pull_at = [&](double from, double to, double force) {
    const Vector3 a = place(from), b = place(to);
    const double f = force / std::hypot(b[0] - a[0], b[1] - a[1]);
    return Vector3{f * (b[0] - a[0]), f * (b[1] - a[1]), 0.0};
  };
  const double last = static_cast<double>(count) - 1.0;
  system.constraints = {cylinder, rods};
  system.forces = {ConstantForce{"slack end", {0}, pull_at(0.0, -1.0, 1.0)},
                   ConstantForce{"pulled end", {static_cast<Index>(count) - 1}, pull_at(last, last + 1.0, pull)}};
  system.friction = {Coulomb{.name = "", .at = {"cylinder"}, .coefficient = mu}};
  return system;
}

TEST(Rope, EachBeadMultipliesTheTensionByTheClosedForm) {
  double last_error = 0.0;
  for (const std::size_t count : {10u, 20u, 40u}) {
    const double D = std::numbers::pi / static_cast<double>(count), step = ratio(D);
    const double total = std::pow(step, static_cast<double>(count));
    const System system = make_rope(count, 1e-9, total);
    Dynamics dynamics(system);
    std::vector<double> w(3 * count), lambda(num_equations(system));
    const SolveReport report =
        dynamics.solve({.time = 0.0, .positions = system.positions, .velocities = system.velocities},
                       {.accelerations = w, .multipliers = lambda});
    ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
    for (const double a : w) EXPECT_NEAR(a, 0.0, 1e-11) << count;
    double tension = 1.0;
    for (std::size_t k = 0; k + 1 < count; ++k) {
      tension *= step;
      EXPECT_NEAR(-lambda[2 * count + k], tension, 1e-12 * tension) << count << " beads, rod " << k;
    }
    // Since (1 + mu tan(D/2))/(1 - mu tan(D/2)) = e^(mu D + O(D^3)), twice as many beads leave a quarter of the error.
    const double error = total - std::exp(mu * std::numbers::pi);
    if (count == 10) {
      EXPECT_NEAR(total, 2.5884, 5e-5);
    }
    if (last_error > 0.0) {
      EXPECT_NEAR(last_error / error, 4.0, 0.05);
    }
    last_error = error;
  }
  EXPECT_NEAR(std::exp(mu * std::numbers::pi), 2.5663, 5e-5);
}

TEST(Rope, HoldsUpToTheRatioAndRunsBeyondIt) {
  for (const std::size_t count : {2u, 3u, 10u}) {
    const double total = std::pow(ratio(std::numbers::pi / static_cast<double>(count)), static_cast<double>(count));
    for (const auto& [pull, sense] : {std::pair{total * (1.0 + 1e-6), 1},
                                      {total * (1.0 - 1e-6), 0},
                                      {1.0, 0},
                                      {(1.0 + 1e-6) / total, 0},
                                      {(1.0 - 1e-6) / total, -1}}) {
      Simulation simulation(make_rope(count, 0.0, pull), {.rtol = 1e-9, .atol = 1e-12});
      ASSERT_TRUE(simulation.advance_to(0.01).ok())
          << count << " beads, pull " << pull << ": " << simulation.outcome().what;
      const double v = simulation.velocities()[1];
      if (sense == 0) {
        EXPECT_NEAR(v, 0.0, 1e-14) << count << " beads, pull " << pull;
      } else {
        // The acceleration is about excess/(m count) times the cosine of half the angle.
        EXPECT_GT(v * sense, 1e-9) << count << " beads, pull " << pull;
      }
    }
  }
}

}  // namespace
}  // namespace tanor
