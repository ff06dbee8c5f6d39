#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <tanor/tanor.hpp>

#include "long_tests.hpp"

/// \file Beads on rough lines and planes, joined by rods, that begin at rest with static coefficients above the kinetic
/// ones. Who gives way follows from forces and limits alone, so that nothing depends on how the motion is computed.
namespace tanor {
namespace {

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "(%.17g)", x);
  return text;
}

/// Makes two or three beads in a row at rest, each on a line or a plane of its own, under forces that swing.
System make_row(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-2.0, 2.0), mass(0.2, 1.5), size(-20.0, 20.0), rate(4.0, 12.0),
      phase(0.0, 6.283185307179586), mu(0.1, 0.5), above(1.0, 1.6), share(0.0, 1.0);
  const std::size_t count = share(random) < 0.5 ? 2 : 3;
  System system;
  Rods rods{"rods", {}, {}, {}};
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3 r{place(random), place(random), place(random)}, d{place(random), place(random), place(random)};
    const auto index = static_cast<Index>(i);
    const std::string guide = "g" + std::to_string(i);
    system.positions.insert(system.positions.end(), r.begin(), r.end());
    system.masses.push_back(mass(random));
    const bool on_plane = count == 2 ? share(random) < 0.5 : i == 1;
    if (on_plane)
      system.constraints.push_back(Planes{guide, {index}, d, d[0] * r[0] + d[1] * r[1] + d[2] * r[2]});
    else
      system.constraints.push_back(Lines{guide, {index}, r, d});
    const double w = rate(random);
    VectorFunction force;
    for (ScalarFunction& component : force.components) {
      const std::string amplitude = number(size(random)), shift = number(phase(random));
      component = ScalarFunction::formula(amplitude + "*sin(" + number(w) + "*t+" + shift + ")");
    }
    system.forces.push_back(ConstantForce{"", {index}, force});
    const double kinetic = mu(random);
    system.friction.push_back(
        Coulomb{.name = "", .at = {guide}, .coefficient = kinetic, .static_coefficient = kinetic * above(random)});
    if (i > 0) rods.pairs.push_back({index - 1, index});
  }
  system.constraints.push_back(rods);
  system.velocities.assign(system.positions.size(), 0.0);
  return system;
}

/// A bead on a plane between two on lines, whose forces once let two of them reach their limits together.
System make_lottery() {
  System system;
  system.positions = {1.1515318260947833,  0.5043733859186839,  1.5971515421199312,
                      0.04749803941069287, -0.9528877821368361, -0.4073579435521079,
                      -1.758956564735587,  1.7189595688341035,  1.8684674841492495};
  system.masses = {0.9068213196027068, 0.3988282747640397, 0.4168811821292061};
  system.velocities.assign(9, 0.0);
  system.constraints = {
      Lines{"g0",
            {0},
            Vector3{1.1515318260947833, 0.5043733859186839, 1.5971515421199312},
            Vector3{-1.7526204072855232, -0.5842925586448443, 0.34983044492818305}},
      Planes{"g1", {1}, Vector3{-0.7423522681112622, 0.016746821504532404, 0.5367744560846018}, -0.269877457470586},
      Lines{"g2",
            {2},
            Vector3{-1.758956564735587, 1.7189595688341035, 1.8684674841492495},
            Vector3{-1.183595264508432, -1.3249890660738992, -1.5468174941983626}},
      Rods{"r0", {{0, 1}}, 2.7130350149254863, {}}, Rods{"r1", {{1, 2}}, 3.9473317419623837, {}}};
  const auto force = [](Index bead, const std::array<const char*, 3>& formulas) {
    const auto part = [&](std::size_t c) { return ScalarFunction::formula(formulas[c]); };
    return ConstantForce{"", {bead}, VectorFunction{part(0), part(1), part(2)}};
  };
  system.forces = {force(0, {"1.8056992190375831*sin(10.965948360150986*t+5.788506922097961)",
                             "7.957067411574452*sin(10.965948360150986*t+2.555335929744304)",
                             "-12.13215667426253*sin(10.965948360150986*t+4.9625713486448415)"}),
                   force(1, {"-17.001932937601968*sin(7.025544182948782*t+4.086467980988535)",
                             "-7.554227689011912*sin(7.025544182948782*t+4.66478765133596)",
                             "-0.6264294655244147*sin(7.025544182948782*t+4.286439871187646)"}),
                   force(2, {"12.990359793160247*sin(7.794069527972532*t+4.464066530039771)",
                             "4.289430476766911*sin(7.794069527972532*t+2.7451303316975704)",
                             "-12.184616798269042*sin(7.794069527972532*t+0.6047156391422972)"})};
  system.friction = {
      Coulomb{.name = "", .at = {"g0"}, .coefficient = 0.21212527523911234, .static_coefficient = 0.25239407027185107},
      Coulomb{.name = "", .at = {"g1"}, .coefficient = 0.389075597072466, .static_coefficient = 0.5115405439558679},
      Coulomb{.name = "", .at = {"g2"}, .coefficient = 0.33193097216716483}};
  return system;
}

struct Arrival {
  Outcome outcome;
  std::vector<double> positions;
  FrictionSummary friction;
};

/// Runs to t_end, with an output after each of `pieces` equal pieces.
Arrival run(const System& system, Method method, double rtol, double t_end, int pieces) {
  Simulation simulation(system, {.method = method, .rtol = rtol, .atol = 1e-2 * rtol});
  for (int k = 1; k <= pieces && simulation.outcome().ok(); ++k) (void)simulation.advance_to(t_end * k / pieces);
  return {simulation.outcome(),
          {simulation.positions().begin(), simulation.positions().end()},
          simulation.report().friction};
}

double distance(const Arrival& a, const Arrival& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.positions.size(); ++i)
    largest = std::max(largest, std::abs(a.positions[i] - b.positions[i]));
  return largest;
}

/// The lottery has several motions, and is run at rtol 1e-7. This is how well its ends are known there, m.
constexpr double known_to = 2e-5;

TEST(StaticFriction, TheEndOfALotteryDependsOnNothingButForcesAndLimits) {
  const System system = make_lottery();
  const Arrival best = run(system, Method::Dop853, 1e-11, 0.6, 1);
  ASSERT_TRUE(best.outcome.ok()) << best.outcome.what;
  for (const Method method : {Method::Dop853, Method::Dopri5}) {
    for (const double rtol : {1e-7, 1e-10}) {
      for (const int pieces : {1, 20}) {
        const Arrival other = run(system, method, rtol, 0.6, pieces);
        ASSERT_TRUE(other.outcome.ok()) << other.outcome.what;
        EXPECT_LE(distance(best, other), known_to) << name_of(method) << " " << rtol << " " << pieces;
      }
    }
  }
}

TEST(StaticFriction, EndsOfRandomRowsDependOnNothingButForcesAndLimits) {
  const int all = num_draws(2000);
  int arrived = 0;
  for (int seed = 1; seed <= all; ++seed) {
    const System system = make_row(static_cast<unsigned>(seed));
    const Arrival best = run(system, Method::Dop853, 1e-12, 0.15, 1);
    const Arrival other = seed % 2 == 0 ? run(system, Method::Dopri5, 1e-11, 0.15, 1 + seed % 7)
                                        : run(system, Method::Dop853, 1e-11, 0.15, 1 + seed % 7);
    EXPECT_EQ(other.outcome.ok(), best.outcome.ok()) << "seed " << seed << " " << other.outcome.what;
    if (!best.outcome.ok() || !other.outcome.ok()) continue;
    ++arrived;
    if (best.friction.several == 0 && other.friction.several == 0) {
      EXPECT_LE(distance(best, other), 1e-8) << "seed " << seed;
    }
  }
  EXPECT_GT(arrived, all * 8 / 10);
}

/// Rows in which several motions obey the law for a while, before some bead gives way. It has the smaller friction from
/// then on, whichever of the motions is the nearest one.
TEST(StaticFriction, RowsWithSeveralMotionsArriveByEachMethod) {
  for (const unsigned seed : {853u, 1544u}) {
    for (const Method method : {Method::Dop853, Method::Dopri5}) {
      for (const double rtol : {1e-12, 1e-11, 1e-10}) {
        const Arrival arrival = run(make_row(seed), method, rtol, 0.15, 1);
        EXPECT_TRUE(arrival.outcome.ok())
            << seed << " " << name_of(method) << " " << rtol << " " << arrival.outcome.what;
      }
    }
  }
}

}  // namespace
}  // namespace tanor
