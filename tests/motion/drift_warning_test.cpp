#include <gtest/gtest.h>

#include <cmath>
#include <tanor/equilibrium.hpp>
#include <tanor/tanor.hpp>

#include "scenes.hpp"

/// \file The drift of the energy is measured relative to all energy that has flowed, and not before any has.
namespace tanor {
namespace {

ScalarFunction make_pulse(double height, double middle, double width) {
  return ScalarFunction::formula(std::to_string(height) + "*exp(-((t-" + std::to_string(middle) + ")/" +
                                 std::to_string(width) + ")^2)");
}

/// Makes a block of 1 kg on a floor that is lifted.
System make_lifted_block(const ScalarFunction& height) {
  System system;
  system.positions = {0.0, 0.0, 0.0};
  system.velocities = {0.0, 0.0, 0.0};
  system.masses = {1.0};
  system.constraints = {Planes{"floor", {0}, Vector3{0.0, 0.0, 1.0}, height}};
  system.forces = {Gravity{"", {0.0, 0.0, -10.0}}};
  return system;
}

/// Makes a bob of 1 kg whose support is lifted.
System make_lifted_bob(const ScalarFunction& height) {
  System system = scenes::make_pendulum({0.0, 0.0, -1.0}, 1.0);
  system.supports[0].displacement = {0.0, 0.0, height};
  system.forces = {Gravity{"", {0.0, 0.0, -10.0}}};
  return system;
}

TEST(DriftWarning, IsNotGivenWhileNothingFlows) {
  struct Draw {
    Method method;
    double height, middle, width, rtol;
  };
  for (const Draw& draw :
       {Draw{Method::Dopri5, 4.5e-4, 8.598, 0.2134, 4.4e-11}, Draw{Method::Dopri5, 0.107, 7.7, 0.109, 2.1e-10},
        Draw{Method::Dopri5, 8.49, 6.83, 0.497, 1e-8}, Draw{Method::Radau5, 0.21, 3.9, 0.25, 1e-6},
        Draw{Method::Radau5, 0.04, 6.686, 0.0101, 5.3e-11}}) {
    for (const bool is_bob : {false, true}) {
      SCOPED_TRACE(std::string(name_of(draw.method)) + (is_bob ? ", bob, " : ", block, ") +
                   std::to_string(draw.middle));
      const ScalarFunction pulse = make_pulse(draw.height, draw.middle, draw.width);
      Simulation simulation(is_bob ? make_lifted_bob(pulse) : make_lifted_block(pulse),
                            {.method = draw.method, .rtol = draw.rtol});

      const Outcome outcome = simulation.advance_to(10.0, [&](const MotionReport& report) {
        EXPECT_EQ(report.accuracy_warning, "") << report.time;
        return report.accuracy_warning.empty();
      });

      ASSERT_TRUE(outcome.ok()) << outcome.what;
      EXPECT_LE(std::abs(simulation.report().energy.drift_relative()), 100.0 * draw.rtol + 1e-7);
    }
  }
}

/// Steps that are too long for a small early pulse miss half of it. Later forces move 1e7 times as much energy.
TEST(DriftWarning, IsTakenBackWhereMuchMoreFlowsLater) {
  System system;
  system.positions = {0.0, 0.0, 0.0};
  system.velocities = {0.0, 0.0, 0.0};
  system.masses = {1.0};
  const std::string force = "0.1*exp(-((t-0.503)/0.004)^2) + 10*exp(-((t-2)/0.3)^2)";
  system.forces = {ConstantForce{"pull", {0}, VectorFunction{ScalarFunction::formula(force), 0.0, 0.0}}};
  Simulation simulation(system, {.method = Method::Rk4, .step = 0.01});

  ASSERT_TRUE(simulation.advance_to(0.6).ok());
  const std::string early = simulation.report().accuracy_warning;
  ASSERT_TRUE(simulation.advance_to(4.0).ok());

  EXPECT_NE(early.find("the energy drifts by"), std::string::npos) << early;
  EXPECT_EQ(simulation.report().accuracy_warning, "");
  EXPECT_LE(std::abs(simulation.report().energy.drift_relative()), 1e-5);
}

/// The energies of a molecule at rest are 0 but for rounding. Nothing flows, so that no part of a flow can be missed.
TEST(DriftWarning, IsNotGivenWhereAMoleculeRests) {
  System system;
  Bonds bonds{"bonds", {}, BondLaw::Harmonic, 300.0, 1.0};
  Bendings angles{"angles", {}, BendingLaw::Harmonic, 30.0, 1.9};
  for (int i = 0; i < 10; ++i) {
    system.positions.insert(system.positions.end(), {0.9 * i, 0.5 * (i % 2), 0.1 * std::sin(3.0 * i)});
    system.masses.push_back(1.0);
    if (i > 0) bonds.pairs.push_back({i - 1, i});
    if (i > 1) angles.triples.push_back({i - 2, i - 1, i});
  }
  system.forces = {bonds, angles};
  const EquilibriumResult rest = find_equilibrium(system, {.accept = AcceptedEquilibria::Any});
  ASSERT_TRUE(rest.outcome.ok()) << rest.outcome.what;
  system.positions = rest.positions;
  system.velocities.assign(system.positions.size(), 0.0);
  for (const Method method : {Method::Taylor, Method::Dop853, Method::Radau5}) {
    Simulation simulation(system, {.method = method});

    ASSERT_TRUE(simulation.advance_to(0.2).ok());

    const std::string warning = simulation.report().accuracy_warning;
    EXPECT_EQ(warning.find("energy drifts"), std::string::npos) << warning;
    EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), 1e-3) << name_of(method);
  }
}

}  // namespace
}  // namespace tanor
