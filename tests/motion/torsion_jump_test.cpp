/// \file The force of a harmonic torsion jumps where the angle is opposite to its rest.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <tanor/tanor.hpp>

#include "methods.hpp"

namespace tanor {
namespace {

using std::numbers::pi;

/// A point that goes round the middle bond of a torsion on a circle of 1 m.
struct Rotor {
  double stiffness = 2.0, mass = 0.5, rest = 0.5, amplitude = 3.6;  // J/rad^2, kg, rad; above pi it goes round
};

/// The motion of x = phi - rest between -pi and pi, x'' = -w^2 x, which begins at 0 and jumps from pi to -pi.
struct Turning {
  double angle, rate;

  explicit Turning(double t, const Rotor& rotor = {}) {
    const double w = std::sqrt(rotor.stiffness / rotor.mass), half = std::asin(pi / rotor.amplitude) / w;
    const double since = std::fmod(t + half, 2.0 * half) - half;
    angle = rotor.rest + rotor.amplitude * std::sin(w * since);
    rate = rotor.amplitude * w * std::cos(w * since);
  }
};

/// Makes three supports and the point.
System make_rotor(const Rotor& rotor = {}) {
  System system;
  const Turning start(0.0, rotor);
  system.positions = {1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, std::cos(start.angle), std::sin(start.angle), 1.0};
  system.velocities.assign(12, 0.0);
  system.velocities[9] = -start.rate * std::sin(start.angle);
  system.velocities[10] = start.rate * std::cos(start.angle);
  system.masses = {1.0, 1.0, 1.0, rotor.mass};
  system.supports = {{.points = {0, 1, 2}, .displacement = {}}};
  system.constraints = {Circles{
      .name = "way", .points = {3}, .center = Vector3{0.0, 0.0, 1.0}, .normal = Vector3{0.0, 0.0, 1.0}, .radius = 1.0}};
  // The dihedral is positive where the last bond is turned clockwise, seen along the middle one.
  system.forces = {Torsions{.name = "hinge",
                            .quadruples = {{3, 2, 1, 0}},
                            .law = TorsionLaw::Harmonic,
                            .stiffness = rotor.stiffness,
                            .rest = rotor.rest}};
  return system;
}

double miss_of(const Simulation& simulation, const Turning& truth) {
  const double* const r = simulation.positions().data() + 9;
  return std::hypot(r[0] - std::cos(truth.angle), r[1] - std::sin(truth.angle));
}

TEST(TorsionJump, IsPassedInTheMotionThatItsClosedFormHas) {
  constexpr double end = 10.0;  // seven jumps
  const Turning truth(end);
  for (const Method method : with_auto(list_adaptive_methods())) {
    for (const double rtol : {1e-6, 1e-9}) {
      Simulation simulation(make_rotor(), {.method = method, .rtol = rtol});

      ASSERT_TRUE(simulation.advance_to(end).ok()) << name_of(method) << ": " << simulation.outcome().what;

      EXPECT_LT(miss_of(simulation, truth), 2000.0 * rtol) << name_of(method) << ", rtol " << rtol;
      EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), 100.0 * rtol) << name_of(method);
      EXPECT_LT(simulation.report().steps, 6000u) << name_of(method);
    }
  }
}

/// Each jump is located to rounding, so that many of them cost no more than the steps between them.
TEST(TorsionJump, LeavesEightDigitsAfterManyTurns) {
  const Rotor fast{.stiffness = 1.0, .mass = 1.0, .rest = 0.0, .amplitude = 8.0};
  constexpr double end = 60.0;  // some 75 jumps
  for (const Method method : {Method::Auto, Method::Taylor}) {
    Simulation simulation(make_rotor(fast), {.method = method, .rtol = 1e-12});

    ASSERT_TRUE(simulation.advance_to(end).ok()) << name_of(method) << ": " << simulation.outcome().what;

    EXPECT_LT(miss_of(simulation, Turning(end, fast)), 1e-8) << name_of(method);
    EXPECT_LT(simulation.report().steps, 600u) << name_of(method);
    EXPECT_LT(simulation.report().rejected, 250u) << name_of(method);  // two a jump
  }
}

TEST(TorsionJump, OfRandomRotorsIsPassedRight) {
  std::mt19937_64 random(4);
  const auto draw = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  const std::vector<Method> methods = with_auto(list_adaptive_methods());
  for (std::size_t scene = 0; scene < 50; ++scene) {
    const Rotor rotor{.stiffness = draw(0.5, 4.0),
                      .mass = draw(0.3, 3.0),
                      .rest = draw(-3.1, 3.1),
                      .amplitude = pi * (1.0 + std::exp(draw(-6.0, 1.0)))};
    const double end = draw(2.0, 12.0);
    const Method method = methods[scene % methods.size()];
    Simulation simulation(make_rotor(rotor), {.method = method, .rtol = 1e-11, .atol = 1e-13});

    ASSERT_TRUE(simulation.advance_to(end).ok())
        << scene << ", " << name_of(method) << ": " << simulation.outcome().what;

    EXPECT_LT(miss_of(simulation, Turning(end, rotor)), 1e-8) << scene << ", " << name_of(method);
  }
}

/// Fixed steps are divided at jumps, so that explicit ones keep their order: (w h)^order in each radian.
TEST(TorsionJump, LeavesTheOrderOfFixedSteps) {
  constexpr double end = 10.0, w = 2.0;  // seven jumps
  for (const Method method :
       list_methods_that([](const auto& each) { return each.has_fixed_steps && !each.is_implicit; })) {
    for (const double step : {0.02, 0.01, 0.005}) {
      Simulation simulation(make_rotor(), {.method = method, .step = step});

      ASSERT_TRUE(simulation.advance_to(end).ok()) << name_of(method) << ": " << simulation.outcome().what;

      const double of_steps = std::pow(w * step, traits_of(method).order) * w * end;
      EXPECT_LT(miss_of(simulation, Turning(end)), 1e-9 + 30.0 * of_steps) << name_of(method) << ", step " << step;
      EXPECT_EQ(simulation.report().accuracy_warning, "") << name_of(method) << ", step " << step;
    }
  }
}

/// An implicit step whose Newton's iteration meets both sides keeps its length, and warns.
TEST(TorsionJump, IsWarnedOfWhereImplicitStepsPassIt) {
  Simulation simulation(make_rotor(), {.method = Method::GeneralizedAlpha, .step = 0.005});

  ASSERT_TRUE(simulation.advance_to(10.0).ok()) << simulation.outcome().what;

  EXPECT_NE(simulation.report().accuracy_warning, "");
}

/// The same steps are good between jumps.
TEST(TorsionJump, IsNotWarnedOfBetweenJumps) {
  Simulation simulation(make_rotor(), {.method = Method::Rattle, .step = 0.01});

  ASSERT_TRUE(simulation.advance_to(0.4).ok()) << simulation.outcome().what;

  EXPECT_EQ(simulation.report().accuracy_warning, "");
}

}  // namespace
}  // namespace tanor
