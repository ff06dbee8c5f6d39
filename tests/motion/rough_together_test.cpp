#include <gtest/gtest.h>

#include <cmath>
#include <tanor/tanor.hpp>

#include "motion/rough_guides.hpp"
#include "motion/saved.hpp"
#include "scenes.hpp"

/// \file Contacts that stick and slide at the same instant.
namespace tanor {
namespace {

using scenes::g;

void add_bead(double x, double v, double mass, System* system) {
  system->positions.insert(system->positions.end(), {x, 0.0, 0.0});
  system->velocities.insert(system->velocities.end(), {v, 0.0, 0.0});
  system->masses.push_back(mass);
  std::get<Lines>(system->constraints[0]).points.push_back(static_cast<Index>(system->masses.size() - 1));
}

System make_line(double mu, double mu_s) {
  System system;
  system.constraints = {Lines{"line", {}, Vector3{}, Vector3{1.0, 0.0, 0.0}}};
  system.forces = {Gravity{"", {0.0, -g, 0.0}}};
  system.friction = {Coulomb{.name = "", .at = {"line"}, .coefficient = mu, .static_coefficient = mu_s}};
  return system;
}

TEST(Together, MirroredBeadsStopAtOneInstant) {
  // A spring pulls the beads together while they move apart. They slide until the first stop, then they are held.
  for (const Method method : sampled_methods) {
    System system = make_line(0.4, 0.4);
    add_bead(-0.5, -1.0, 0.7, &system);
    add_bead(0.5, 1.0, 0.7, &system);
    system.forces.push_back(Springs{"", {{0, 1}}, 1.0, 0.0, 1.0});
    MotionOptions options{.method = method, .rtol = 1e-10, .atol = 1e-12};
    if (has_fixed_steps(method)) options.step = 1e-3;
    Simulation simulation(system, options);
    const std::vector<double> events = advance_and_list_events(&simulation, 1.0);
    ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
    ASSERT_EQ(events.size(), 1u) << name_of(method);
    // With y = x - 1/2, y_ddot = -w^2 y - mu g and w^2 = 2 k/m, so that v = 0 at tan(w t) = w/(mu g).
    const double w = std::sqrt(2.0 / 0.7), stop = std::atan(w * 1.0 / (0.4 * g)) / w;
    EXPECT_NEAR(events[0], stop, method == Method::Rattle ? 1e-6 : 1e-11) << name_of(method);
    for (const double v : simulation.velocities()) EXPECT_NEAR(v, 0.0, 1e-16);
    EXPECT_NEAR(simulation.positions()[0], -simulation.positions()[3], 1e-15);
    EXPECT_EQ(open_saved(simulation).discrete_state, (std::vector<int>{1, 1}));
  }
}

TEST(Together, ARowOfBeadsStopsRestsAndLeavesAsOne) {
  // The row is pulled at its end by F = b t. It stops by mu and leaves at b t = mu_s M g.
  const double mu = 0.3, mu_s = 0.4, b = 4.0;
  for (const std::size_t count : {2u, 5u}) {
    for (const bool has_equal_masses : {true, false}) {
      System system = make_line(mu, mu_s);
      Rods rods{"rods", {}, {}, {}};
      double M = 0.0;
      for (std::size_t k = 0; k < count; ++k) {
        const double m = has_equal_masses ? 0.5 : 0.3 + 0.1 * static_cast<double>(k);
        add_bead(0.2 * static_cast<double>(k), -0.8, m, &system);
        if (k > 0) rods.pairs.push_back({static_cast<Index>(k) - 1, static_cast<Index>(k)});
        M += m;
      }
      system.constraints.push_back(rods);
      const VectorFunction pull{ScalarFunction::formula("4*t"), 0.0, 0.0};
      system.forces.push_back(ConstantForce{"pull", {static_cast<Index>(count) - 1}, pull});
      // The row stops where M v = -0.8 M + (mu M g t + b t^2/2) is 0.
      const double stop = static_cast<double>(
          find_root([&](long double t) { return -0.8L * M + mu * M * g * t + 0.5L * b * t * t; }, 0.0L, 5.0L));
      const double leave = mu_s * M * g / b;
      ASSERT_LT(stop, leave);
      for (const Method method : sampled_methods) {
        MotionOptions options{.method = method, .rtol = 1e-10, .atol = 1e-12};
        if (has_fixed_steps(method)) options.step = 2e-3;
        Simulation simulation(system, options);
        std::vector<double> events = advance_and_list_events(&simulation, 0.5 * (stop + leave));
        ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
        ASSERT_FALSE(events.empty()) << name_of(method) << " " << count;
        EXPECT_NEAR(events[0], stop, 1e-10) << name_of(method) << " " << count;
        events = advance_and_list_events(&simulation, leave + 0.3);
        ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
        ASSERT_FALSE(events.empty());
        EXPECT_NEAR(events.back(), leave, 1e-9) << name_of(method) << " " << count;
        // It then moves with M v = b (t^2 - leave^2)/2 - mu M g (t - leave).
        const double t = leave + 0.3;
        const double v = (0.5 * b * (t * t - leave * leave) - mu * M * g * 0.3) / M;
        for (std::size_t k = 0; k < count; ++k)
          EXPECT_NEAR(simulation.velocities()[3 * k], v, 1e-8) << name_of(method) << " " << count;
        EXPECT_LE(std::abs(simulation.report().energy.drift_relative()), method == Method::Rattle ? 5e-5 : 1e-8);
      }
    }
  }
}

}  // namespace
}  // namespace tanor
