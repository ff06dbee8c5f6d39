/// \file The force of a harmonic torsion jumps where the angle is opposite to its rest.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include <tanor/tanor.hpp>

#include "methods.hpp"

namespace tanor {
namespace {

using std::numbers::pi;
constexpr double stiffness = 2.0, mass = 0.5, rest = 0.5, amplitude = 3.6;  // J/rad^2, kg, rad; above pi it goes round

/// The motion of x = phi - rest between -pi and pi, x'' = -w^2 x, which begins at 0 and jumps from pi to -pi.
struct Turning {
  double angle, rate;

  explicit Turning(double t) {
    const double w = std::sqrt(stiffness / mass), half = std::asin(pi / amplitude) / w;
    const double since = std::fmod(t + half, 2.0 * half) - half;
    angle = rest + amplitude * std::sin(w * since);
    rate = amplitude * w * std::cos(w * since);
  }
};

/// Makes three supports and a point that goes round the middle bond on a circle of 1 m.
System make_rotor() {
  System system;
  const Turning start(0.0);
  system.positions = {1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, std::cos(start.angle), std::sin(start.angle), 1.0};
  system.velocities.assign(12, 0.0);
  system.velocities[9] = -start.rate * std::sin(start.angle);
  system.velocities[10] = start.rate * std::cos(start.angle);
  system.masses = {1.0, 1.0, 1.0, mass};
  system.supports = {{.points = {0, 1, 2}, .displacement = {}}};
  system.constraints = {Circles{
      .name = "way", .points = {3}, .center = Vector3{0.0, 0.0, 1.0}, .normal = Vector3{0.0, 0.0, 1.0}, .radius = 1.0}};
  // The dihedral is positive where the last bond is turned clockwise, seen along the middle one.
  system.forces = {Torsions{.name = "hinge",
                            .quadruples = {{3, 2, 1, 0}},
                            .law = TorsionLaw::Harmonic,
                            .stiffness = stiffness,
                            .rest = rest}};
  return system;
}

TEST(TorsionJump, IsPassedInTheMotionThatItsClosedFormHas) {
  constexpr double end = 10.0;  // seven jumps
  const Turning truth(end);
  for (const Method method : with_auto(list_adaptive_methods())) {
    for (const double rtol : {1e-6, 1e-9}) {
      Simulation simulation(make_rotor(), {.method = method, .rtol = rtol});

      ASSERT_TRUE(simulation.advance_to(end).ok()) << name_of(method) << ": " << simulation.outcome().what;

      const double* const r = simulation.positions().data() + 9;
      const double miss = std::hypot(r[0] - std::cos(truth.angle), r[1] - std::sin(truth.angle));
      EXPECT_LT(miss, 2000.0 * rtol) << name_of(method) << ", rtol " << rtol;
      EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), 100.0 * rtol) << name_of(method);
      EXPECT_LT(simulation.report().steps, 6000u) << name_of(method);
    }
  }
}

/// A fixed step stays as it was asked for, with a warning where the jump costs more than a thousandth of the energy.
TEST(TorsionJump, IsWarnedOfWhereFixedStepsPassTheJump) {
  for (const Method method : {Method::Rk4, Method::Rattle}) {
    for (const double step : {0.2, 0.05, 0.02, 0.01}) {
      Simulation simulation(make_rotor(), {.method = method, .step = step});

      ASSERT_TRUE(simulation.advance_to(10.0).ok()) << simulation.outcome().what;

      EXPECT_NE(simulation.report().accuracy_warning, "")
          << name_of(method) << " " << step << ": " << simulation.report().energy.drift_relative();
    }
  }
}

/// The same steps are good between jumps.
TEST(TorsionJump, IsNotWarnedOfBetweenJumps) {
  Simulation simulation(make_rotor(), {.method = Method::Rattle, .step = 0.01});

  ASSERT_TRUE(simulation.advance_to(0.4).ok()) << simulation.outcome().what;

  EXPECT_EQ(simulation.report().accuracy_warning, "");
}

}  // namespace
}  // namespace tanor
