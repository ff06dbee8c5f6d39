#include <gtest/gtest.h>

#include <cmath>
#include <tanor/tanor.hpp>

#include "scenes.hpp"

/// \file Motions do not depend on the unit of length, and warnings say where one may be wrong.
namespace tanor {
namespace {

using scenes::g;

/// Makes a pendulum that is released horizontally, on a rod or on a sphere.
System make_pendulum(double length, bool has_rod) {
  if (has_rod) return scenes::make_pendulum({length, 0.0, 0.0}, 1.0);
  System system;
  system.positions = {length, 0.0, 0.0};
  system.masses = {1.0};
  system.constraints = {Spheres{"bowl", {0}, Vector3{}, length}};
  system.forces = {Gravity{"", {0.0, 0.0, -g}}};
  return system;
}

/// Returns x/length and z/length after ten times sqrt(length/g).
std::array<double, 2> swing(double length, bool has_rod, Method method, MotionReport* report) {
  Simulation simulation(make_pendulum(length, has_rod), {.method = method});
  const Outcome outcome = simulation.advance_to(10.0 * std::sqrt(length / g));
  EXPECT_TRUE(outcome.ok()) << outcome.what;
  *report = simulation.report();
  const auto r = simulation.positions();
  return {r[r.size() - 3] / length, r[r.size() - 1] / length};
}

TEST(Scale, APendulumOfAnyLengthHasTheSameDigits) {
  for (const Method method : {Method::Auto, Method::Dopri5, Method::Dop853, Method::Radau5}) {
    for (const bool has_rod : {true, false}) {
      MotionReport usual, report;
      const auto [x, z] = swing(0.5, has_rod, method, &usual);
      for (const double length : {5e-10, 1e-12, 5e8}) {
        const auto [other_x, other_z] = swing(length, has_rod, method, &report);
        EXPECT_NEAR(other_x, x, 1e-10) << length << ", " << name_of(method);
        EXPECT_NEAR(other_z, z, 1e-10) << length << ", " << name_of(method);
        EXPECT_NEAR(static_cast<double>(report.steps), static_cast<double>(usual.steps), 3.0);
        EXPECT_EQ(report.accuracy_warning, "");
        EXPECT_LT(std::abs(report.energy.drift_relative()), 1e-7);
      }
    }
  }
}

TEST(Scale, ACoarseAbsoluteToleranceIsWarnedOf) {
  const auto warning = [](double length, double atol) {
    return Simulation(make_pendulum(length, true), {.method = Method::Dopri5, .atol = atol}).report().accuracy_warning;
  };
  EXPECT_NE(warning(5e-10, 1e-10).find("of the size of what moves"), std::string::npos) << warning(5e-10, 1e-10);
  EXPECT_NE(warning(0.5, 1e-4), "");
  EXPECT_EQ(warning(0.5, 2e-5), "");
  EXPECT_EQ(warning(5e-10, 1e-14), "");
  EXPECT_EQ(warning(5e-10, 0.0), "");
}

TEST(Scale, EachPendulumHasTheToleranceOfItsOwnLength) {
  // A pendulum of a micrometre hangs beside one of 10 km.
  System system = make_pendulum(1e-6, true);
  const System large = make_pendulum(1e4, true);
  for (std::size_t k = 0; k < 6; ++k) system.positions.push_back(large.positions[k] + (k % 3 == 1 ? 1e4 : 0.0));
  system.masses.insert(system.masses.end(), {1.0, 1.0});
  system.supports.push_back({"other hook", {2}, {}});
  system.constraints.push_back(Rods{"other rod", {{2, 3}}});
  MotionReport report;
  const auto [x, z] = swing(1e-6, true, Method::Dopri5, &report);
  Simulation both(system, {.method = Method::Dopri5});
  ASSERT_TRUE(both.advance_to(10.0 * std::sqrt(1e-6 / g)).ok());
  EXPECT_NEAR(both.positions()[3] / 1e-6, x, 1e-10);
  EXPECT_NEAR(both.positions()[5] / 1e-6, z, 1e-10);
}

/// Makes a chain whose rods name their points outwards or inwards.
System make_named_chain(bool outwards) {
  System system = scenes::make_chain(20);
  if (outwards) return system;
  for (auto& [i, j] : std::get<Rods>(system.constraints[0]).pairs) std::swap(i, j);
  return system;
}

TEST(Scale, TheOrderOfARodsPointsChangesNothing) {
  // An error of 2e-5 m is large beside a rod and small beside the chain.
  for (const double atol : {0.0, 2e-5}) {
    const MotionOptions options{.method = Method::Dopri5, .atol = atol};
    Simulation outwards(make_named_chain(true), options), inwards(make_named_chain(false), options);
    for (Simulation* const each : {&outwards, &inwards}) {
      ASSERT_TRUE(each->advance_to(0.2).ok());
      EXPECT_EQ(each->report().accuracy_warning, "");
    }
    EXPECT_EQ(outwards.report().steps, inwards.report().steps);
    for (std::size_t k = 0; k < outwards.positions().size(); ++k)
      EXPECT_NEAR(outwards.positions()[k], inwards.positions()[k], 1e-12);
  }
}

// ---- accuracy warnings ----

TEST(AccuracyWarning, IsGivenForALooseToleranceThatLosesEnergy) {
  Simulation simulation(make_pendulum(0.5, true), {.method = Method::Dopri5, .rtol = 0.03, .atol = 0.03});
  ASSERT_TRUE(simulation.advance_to(100.0).ok());
  EXPECT_GT(std::abs(simulation.report().energy.drift_relative()), 1e-2);
  EXPECT_NE(simulation.report().accuracy_warning, "");
}

TEST(AccuracyWarning, IsNotGivenForATightTolerance) {
  for (const Method method : list_adaptive_methods()) {
    Simulation simulation(make_pendulum(0.5, true), {.method = method});
    ASSERT_TRUE(simulation.advance_to(20.0).ok());
    EXPECT_EQ(simulation.report().accuracy_warning, "") << name_of(method);
  }
}

/// Makes a block at a spring on a belt. All energy but that of its start comes from the belt, and goes into friction.
System make_stick_slip(double u) {
  System system;
  system.positions = {-1.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  system.velocities = {0.0, 0.0, 0.0, u, 0.0, 0.0};
  system.masses = {1.0, 0.5};
  system.supports = {{"wall", {0}, {}}};
  system.constraints = {Lines{"belt", {1}, Vector3{}, Vector3{1.0, 0.0, 0.0}}};
  system.forces = {Gravity{"", {0.0, -g, 0.0}}, Springs{"spring", {{0, 1}}, 20.0, 0.0, 1.0}};
  system.friction = {Coulomb{
      .name = "", .at = {"belt"}, .coefficient = 0.2, .static_coefficient = 0.35, .velocity = Vector3{u, 0.0, 0.0}}};
  return system;
}

TEST(AccuracyWarning, IsNotGivenForStickSlip) {
  for (const double u : {0.3, 0.03, 0.003}) {
    for (const Method method : with_auto(sampled_methods)) {
      MotionOptions options{.method = method};
      if (has_fixed_steps(method)) options.step = 1e-2;
      Simulation simulation(make_stick_slip(u), options);
      ASSERT_TRUE(simulation.advance_to(10.0).ok()) << simulation.outcome().what;
      EXPECT_EQ(simulation.report().accuracy_warning, "") << u << ", " << name_of(method);
      EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), method == Method::Rattle ? 1e-2 : 1e-4)
          << u << ", " << name_of(method);
    }
  }
}

/// A force that grows from 0 moves a point from rest. Nothing turns there, and no step is too long.
TEST(AccuracyWarning, IsNotGivenForAStartFromRest) {
  for (const Method method : {Method::Rk4, Method::Rattle, Method::Rattle6, Method::GeneralizedAlpha}) {
    for (const double step : {1e-2, 1e-3}) {
      System system;
      system.positions = {0.0, 0.0, 0.0};
      system.masses = {1.0};
      system.forces = {ConstantForce{.points = {0}, .force = {ScalarFunction::formula("t"), 0.0, 0.0}}};
      Simulation simulation(system, {.method = method, .step = step});
      ASSERT_TRUE(simulation.advance_to(2.0).ok()) << simulation.outcome().what;
      EXPECT_EQ(simulation.report().accuracy_warning, "") << name_of(method) << ", step " << step;
    }
  }
}

/// A block sticks and slides under 3 sin(10 t), with 127 events.
TEST(AccuracyWarning, IsNotGivenForABlockThatIsPushedToAndFro) {
  System system;
  system.positions = {0.0, 0.0, 0.0};
  system.masses = {1.0};
  system.constraints = {Lines{.name = "rail", .points = {0}, .origin = Vector3{}, .direction = Vector3{1.0, 0.0, 0.0}}};
  system.forces = {Gravity{.acceleration = {0.0, 0.0, -10.0}},
                   ConstantForce{.points = {0}, .force = {ScalarFunction::formula("3*sin(10*t)"), 0.0, 0.0}}};
  system.friction = {Coulomb{.at = {"rail"}, .coefficient = 0.2}};
  for (const double step : {1e-2, 1e-3}) {
    Simulation simulation(system, {.method = Method::Rk4, .step = step});
    ASSERT_TRUE(simulation.advance_to(20.0).ok()) << simulation.outcome().what;
    EXPECT_EQ(simulation.report().accuracy_warning, "") << step;
    EXPECT_NEAR(simulation.positions()[0], 0.0103858, 1e-6);
  }
}

/// The drift is relative to the energy that flows. It is the same far above the ground, where the potential is large.
TEST(AccuracyWarning, TheDriftDoesNotDependOnTheHeight) {
  const auto drift = [](double height) {
    System system = make_pendulum(0.5, true);
    for (std::size_t k = 2; k < system.positions.size(); k += 3) system.positions[k] += height;
    Simulation simulation(system, {.method = Method::Rk4, .step = 0.02});
    EXPECT_TRUE(simulation.advance_to(2.0).ok());
    return simulation.report().energy.drift_relative();
  };
  const double low = drift(0.0);
  EXPECT_GT(std::abs(low), 1e-6);
  EXPECT_NEAR(drift(1e4), low, 1e-3 * std::abs(low));
}

/// Nothing flows in a chain that hangs at rest, and rounding is no drift.
TEST(AccuracyWarning, IsNotGivenForAChainAtRest) {
  const System system = scenes::hang(scenes::make_chain_along(20, {0.0, 0.0, -0.1}), {0});
  for (const Method method : with_auto(sampled_methods)) {
    MotionOptions options{.method = method};
    if (has_fixed_steps(method)) options.step = 1e-2;
    Simulation simulation(system, options);
    ASSERT_TRUE(simulation.advance_to(1.0).ok());
    EXPECT_EQ(simulation.report().accuracy_warning, "") << name_of(method);
    EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), 1e-6);
  }
}

}  // namespace
}  // namespace tanor
