#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <tanor/tanor.hpp>

#include "base/parallel.hpp"

/// \file Many contacts at rest choose together which of them begin to slide. The law is written down here once
/// more, for accelerations, friction and normal forces as tanor reports them:
///
///   |tau_c| <= mu |N_c|,   tau_c = -mu |N_c| a_c/|a_c| where a_c is not 0
namespace tanor {
using namespace detail;
namespace {

constexpr double mu = 0.25;

/// Makes a chain of beads at rest with random forces. On a plane friction changes no normal force; in a ball of radius
/// 1
/// rods push into the guide, with either sign.
System make_rough_chain(std::size_t count, bool in_ball, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> turn(-1.0, 1.0);
  System system;
  Rods rods{"rods", {}, {}, {}};
  std::vector<Index> all;
  double x = -0.5, y = 0.0, angle = 0.0;
  const double strength = std::exp(turn(random));
  ConstantForce forces{"", {}, {}};
  for (std::size_t k = 0; k < count; ++k) {
    const double z = in_ball ? -std::sqrt(1.0 - x * x - y * y) : 0.0;
    system.positions.insert(system.positions.end(), {x, y, z});
    system.masses.push_back(std::exp(turn(random)));
    all.push_back(static_cast<Index>(k));
    if (k > 0) rods.pairs.push_back({static_cast<Index>(k) - 1, static_cast<Index>(k)});
    angle = 0.7 * angle + 0.6 * turn(random);
    x += 1.0 / static_cast<double>(count) * std::cos(angle);
    y += 1.0 / static_cast<double>(count) * std::sin(angle);
    const Vector3 force{strength * normal(random), strength * normal(random), strength * normal(random)};
    system.forces.push_back(ConstantForce{"", {static_cast<Index>(k)}, force});
  }
  system.forces.push_back(Gravity{"", {0.0, 0.0, -10.0}});
  system.velocities.assign(3 * count, 0.0);
  system.constraints.push_back(rods);
  if (in_ball)
    system.constraints.push_back(Spheres{"guide", all, Vector3{}, 1.0});
  else
    system.constraints.push_back(Planes{"guide", all, Vector3{0.0, 0.0, 1.0}, 0.0});
  system.friction = {Coulomb{.name = "", .at = {"guide"}, .coefficient = mu}};
  return system;
}

/// Returns the largest violation of the law over the largest limit. `moving` becomes the number of points that
/// accelerate.
double miss(const System& system, const std::vector<double>& w, const std::vector<double>& lambda,
            const std::vector<double>& tau, std::size_t* moving) {
  const std::size_t count = system.masses.size();
  double worst = 0.0, largest = 0.0, fastest = 0.0;
  for (const double a : w) fastest = std::max(fastest, std::abs(a));
  *moving = 0;
  for (std::size_t c = 0; c < count; ++c) {
    const double limit = mu * std::abs(lambda[count - 1 + c]);
    const double a = std::hypot(w[3 * c], w[3 * c + 1], w[3 * c + 2]);
    const double size = std::hypot(tau[3 * c], tau[3 * c + 1], tau[3 * c + 2]);
    largest = std::max(largest, limit);
    worst = std::max(worst, size - limit);
    if (a <= 1e-9 * std::max(fastest, 10.0)) continue;
    ++*moving;
    for (std::size_t i = 0; i < 3; ++i) worst = larger(worst, std::abs(tau[3 * c + i] + limit * w[3 * c + i] / a));
  }
  return worst / largest;
}

TEST(ManyContacts, FoundFrictionObeysTheLaw) {
  for (const bool in_ball : {false, true}) {
    std::size_t some_of_both = 0, found = 0, tried = 0;
    for (unsigned seed = 1; seed <= 40; ++seed) {
      const std::size_t count = 11 + 2 * (seed % 12);
      const System system = make_rough_chain(count, in_ball, seed);
      Dynamics dynamics(system);
      std::vector<double> w(3 * count), lambda(num_equations(system)), tau(3 * count);

      const SolveReport report =
          dynamics.solve({.time = 0.0, .positions = system.positions, .velocities = system.velocities},
                         {.accelerations = w, .multipliers = lambda, .friction_forces = tau});

      ++tried;
      if (!report.outcome.ok()) {
        ADD_FAILURE() << (in_ball ? "ball" : "plane") << ", seed " << seed << ": " << report.outcome.what;
        continue;
      }
      ++found;
      std::size_t moving = 0;
      EXPECT_LE(miss(system, w, lambda, tau, &moving), 1e-7) << (in_ball ? "ball" : "plane") << ", seed " << seed;
      some_of_both += moving > 0 && moving < count ? 1 : 0;
    }
    EXPECT_EQ(found, tried);
    EXPECT_GE(some_of_both, 5u) << (in_ball ? "ball" : "plane");
  }
}

/// Beads are joined by rods along x on rough lines along y, so that each accelerates by itself, by (F_y - mu F_z)/m.
TEST(ManyContacts, ThoseThatHoldTooMuchAreReleasedWhereverTheyAreInARowTooLongToCount) {
  constexpr std::size_t count = 300;
  System system;
  Rods rods{"rods", {}, {}, {}};
  for (std::size_t k = 0; k < count; ++k) {
    const auto bead = static_cast<Index>(k);
    const std::string name = "l" + std::to_string(k);
    const Vector3 r{static_cast<double>(k), 0.0, 0.0};
    system.positions.insert(system.positions.end(), r.begin(), r.end());
    system.masses.push_back(2.0);
    system.forces.push_back(
        ConstantForce{"", {bead}, Vector3{0.0, k % 3 == 0 ? 0.3 + 0.01 * static_cast<double>(k % 50) : 0.2, 1.0}});
    system.constraints.push_back(Lines{name, {bead}, r, Vector3{0.0, 1.0, 0.0}});
    system.friction.push_back(Coulomb{.name = "", .at = {name}, .coefficient = mu});
    if (k > 0) rods.pairs.push_back({bead - 1, bead});
  }
  system.velocities.assign(3 * count, 0.0);
  system.constraints.push_back(rods);
  Dynamics dynamics(system);
  std::vector<double> w(3 * count);

  const SolveReport report = dynamics.solve(
      {.time = 0.0, .positions = system.positions, .velocities = system.velocities}, {.accelerations = w});

  ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
  EXPECT_EQ(report.friction.sticking, 2 * count / 3);
  for (std::size_t k = 0; k < count; ++k) {
    const double excess = k % 3 == 0 ? 0.05 + 0.01 * static_cast<double>(k % 50) : 0.0;
    EXPECT_NEAR(w[3 * k + 1], excess / 2.0, 1e-12) << k;
  }
}

}  // namespace
}  // namespace tanor
