#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <tanor/tanor.hpp>

#include "motion/rough_guides.hpp"
#include "scenes.hpp"

/// \file Beads that slide in two dimensions.
namespace tanor {
namespace {

using scenes::g;

/// Expects with each method that the stop is the only event, then calls expect(simulation, method) for the place of the
/// stop. The direction turns faster at a stop than fixed steps can follow, so that its instant lies within one of them.
template <class Expect>
void expect_stop(const System& system, double stop, const Expect& expect) {
  for (const Method method : sampled_methods) {
    MotionOptions options{.method = method, .rtol = 1e-11, .atol = 1e-13};
    if (has_fixed_steps(method)) options.step = 1e-3;
    Simulation simulation(system, options);
    const std::vector<double> events = advance_and_list_events(&simulation, stop + 1.0);
    ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
    ASSERT_EQ(events.size(), 1u) << name_of(method);
    EXPECT_NEAR(events[0], stop, method == Method::Dopri5 ? 1e-9 : 1e-3) << name_of(method);
    expect(simulation, method);
  }
}

/// A bead starts across a force on a rough plane. With a = F/m, b = mu g, k = b/a, psi the angle from the force to v
/// and u = tan(psi/2), the hodograph is |v| = C u^k/sin psi, and the bead stops at u = 0:
///
///   t = C/(2 a) [u^(k-1)/(k-1) + u^(k+1)/(k+1)],   x = C^2/(4 a) [u^(2k-2)/(2k-2) - u^(2k+2)/(2k+2)],
///   y = C^2/(2 a) [u^(2k-1)/(2k-1) + u^(2k+1)/(2k+1)]
TEST(RoughPlane, ABeadAcrossAForceFollowsTheHodographAndStops) {
  for (const double k : {1.3, 2.0, 3.7}) {
    const double mu = 0.5, b = mu * g, a = b / k, v0 = 2.0, C = v0;  // psi = pi/2, u = 1
    const double stop = C / (2.0 * a) * (1.0 / (k - 1.0) + 1.0 / (k + 1.0));
    const double x = C * C / (4.0 * a) * (1.0 / (2.0 * k - 2.0) - 1.0 / (2.0 * k + 2.0));
    const double y = C * C / (2.0 * a) * (1.0 / (2.0 * k - 1.0) + 1.0 / (2.0 * k + 1.0));
    System system;
    system.positions = {0.0, 0.0, 0.0};
    system.velocities = {0.0, v0, 0.0};
    system.masses = {0.4};
    system.constraints = {Planes{"floor", {0}, Vector3{0.0, 0.0, 1.0}, 0.0}};
    system.forces = {Gravity{"", {a, 0.0, -g}}};
    system.friction = {Coulomb{.name = "", .at = {"floor"}, .coefficient = mu}};
    SCOPED_TRACE(k);
    expect_stop(system, stop, [&](const Simulation& simulation, Method method) {
      const double allowed = method == Method::Dopri5 ? 1e-9 : 1e-6;
      EXPECT_NEAR(simulation.positions()[0], x, allowed) << name_of(method);
      EXPECT_NEAR(simulation.positions()[1], y, allowed) << name_of(method);
    });
  }
}

/// A bead in a bowl obeys m r_ddot = m g_ + lambda n - mu |lambda| v/|v| on a sphere around the origin.
TEST(RoughSphere, ABeadInABowlSpiralsDownAndStops) {
  const double R = 1.2, mu = 0.25;
  using Real = long double;
  const auto slope = [&](const std::array<Real, 6>& s) {
    const Real r2 = s[0] * s[0] + s[1] * s[1] + s[2] * s[2], v2 = s[3] * s[3] + s[4] * s[4] + s[5] * s[5];
    // As N = v^2/R - g.n with n = r/|r|, lambda = -(v^2 + g_.r)/R.
    const Real radius = std::sqrt(r2), lambda = -(v2 - static_cast<Real>(g) * s[2]) / radius, speed = std::sqrt(v2);
    std::array<Real, 6> d{s[3], s[4], s[5], 0, 0, 0};
    for (std::size_t c = 0; c < 3; ++c)
      d[3 + c] = lambda * s[c] / radius - static_cast<Real>(mu) * std::abs(lambda) * s[3 + c] / speed;
    d[5] -= g;
    return d;
  };
  System system;
  system.positions = {R * std::sin(1.1), 0.0, -R * std::cos(1.1)};
  system.velocities = {0.0, 2.5, 0.0};
  system.masses = {0.9};
  system.constraints = {Spheres{"bowl", {0}, Vector3{}, R}};
  system.forces = {Gravity{"", {0.0, 0.0, -g}}};
  system.friction = {Coulomb{.name = "", .at = {"bowl"}, .coefficient = mu}};
  std::array<Real, 6> s{};
  for (std::size_t c = 0; c < 3; ++c) s[c] = system.positions[c], s[3 + c] = system.velocities[c];
  Real t = 0.0L;
  const auto speed = [&] { return std::sqrt(s[3] * s[3] + s[4] * s[4] + s[5] * s[5]); };
  Real deceleration = 1.0L;
  while (speed() > 1e-7L) {
    const Real h = std::min(1e-4L, 0.02L * speed() / deceleration);
    const auto at = [&](const std::array<Real, 6>& k, Real f) {
      std::array<Real, 6> x = s;
      for (std::size_t i = 0; i < 6; ++i) x[i] += f * k[i];
      return x;
    };
    const auto k1 = slope(s), k2 = slope(at(k1, h / 2)), k3 = slope(at(k2, h / 2)), k4 = slope(at(k3, h));
    const Real before = speed();
    for (std::size_t i = 0; i < 6; ++i) s[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
    deceleration = std::max(std::abs(speed() - before) / h, 0.1L);
    t += h;
  }
  const auto stop = static_cast<double>(t + speed() / deceleration);
  expect_stop(system, stop, [&](const Simulation& simulation, Method method) {
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(simulation.positions()[c], static_cast<double>(s[c]), method == Method::Dopri5 ? 1e-10 : 1e-6);
    EXPECT_LE(std::abs(simulation.report().energy.drift_relative()), method == Method::Dopri5 ? 1e-9 : 1e-5);
  });
}

}  // namespace
}  // namespace tanor
