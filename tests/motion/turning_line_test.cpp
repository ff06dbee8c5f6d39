/// Beads on straight wires that turn have two multipliers, functions of the instant whatever steps were taken.

#include <cmath>

#include <gtest/gtest.h>
#include <tanor/motion.hpp>

namespace tanor {
namespace {

ScalarFunction f(const char* text) {
  return ScalarFunction::formula(text);
}

constexpr double bead_mass = 2.0, gravity = 9.81;

/// Makes a bead on the wire d = (cos t, sin t, 0) through the origin, from rest at 1 m: s'' = s, s = cosh t.
///
///   K lambda = m g e_z + 2 m s' e_t;  e1 = e_z, e2 = d x e1 = -e_t
System make_turning_wire(bool with_coordinates) {
  System system;
  system.positions = {1.0, 0.0, 0.0};
  system.velocities = {0.0, 1.0, 0.0};
  system.masses = {bead_mass};
  const VectorFunction direction(f("cos(t)"), f("sin(t)"), 0.0);
  system.constraints = {Lines{"wire", {0}, Vector3{}, direction}};
  system.forces = {Gravity{"", {0.0, 0.0, -gravity}}};
  if (with_coordinates) system.coordinates = {LineCoordinates{"wire", {0}, Vector3{}, direction}};
  return system;
}

/// A method and how exact its multipliers are.
struct KnownAccuracy {
  MotionOptions motion;
  double error;  // of a multiplier, over the largest one
};

const KnownAccuracy methods_to_compare[] = {{{.method = Method::Taylor, .rtol = 1e-11, .atol = 1e-12}, 1e-8},
                                            {{.method = Method::Dop853, .rtol = 1e-11, .atol = 1e-12}, 1e-8},
                                            {{.method = Method::Dopri5, .rtol = 1e-9, .atol = 1e-11}, 1e-6},
                                            {{.method = Method::Rk4, .step = 0.005}, 1e-6},
                                            {{.method = Method::Radau5, .rtol = 1e-9, .atol = 1e-11}, 1e-6},
                                            {{.method = Method::Rattle, .step = 0.001}, 1e-3},
                                            {{.method = Method::GeneralizedAlpha, .step = 0.001}, 1e-3}};

TEST(TurningLine, MultipliersAreThoseOfTheClosedFormByEveryMethod) {
  for (const KnownAccuracy& each : methods_to_compare) {
    Simulation simulation(make_turning_wire(false), each.motion);
    for (const double t : {0.5, 1.0, 1.5, 2.0, 3.0}) {
      ASSERT_TRUE(simulation.advance_to(t).ok()) << simulation.outcome().what;

      const double scale = bead_mass * (gravity + 2.0 * std::sinh(t));
      EXPECT_NEAR(simulation.multipliers()[0], bead_mass * gravity, each.error * scale) << name_of(each.motion.method);
      EXPECT_NEAR(simulation.multipliers()[1], -2.0 * bead_mass * std::sinh(t), each.error * scale)
          << name_of(each.motion.method) << " at " << t;
      EXPECT_TRUE(simulation.certify().passed()) << simulation.certify().line();
    }
  }
}

TEST(TurningLine, BothFormsAreCertifiedAfterEveryStep) {
  for (const Form form : {Form::Normal, Form::Tangent, Form::Both}) {
    Simulation simulation(make_turning_wire(true), {.method = Method::Dop853}, {.form = form});
    const Outcome outcome = simulation.advance_to(3.0, [&](const MotionReport&) {
      const Certificate certificate = simulation.certify();
      EXPECT_TRUE(certificate.passed()) << simulation.time() << ": " << certificate.line();
      return true;
    });
    EXPECT_TRUE(outcome.ok()) << outcome.what;
  }
}

/// The unit vectors of a wire that wobbles around z jump four times in a turn. Methods, tolerances and the number of
/// advances make no difference to the multipliers.
TEST(TurningLine, MultipliersDoNotDependOnTheStepsTaken) {
  System system;
  system.positions = {0.0, 0.0, 0.0, 0.5, 0.0, 0.0};
  system.velocities.assign(6, 0.0);
  system.masses = {bead_mass, 1.0};
  system.constraints = {Lines{"wire", {0}, Vector3{}, VectorFunction(f("0.4*cos(3*t)"), f("0.4*sin(3*t)"), 1.0)},
                        Rods{"rod", {{0, 1}}, {}, {}}};
  system.forces = {Gravity{"", {1.0, 0.5, -gravity}}};
  Simulation reference(system, {.method = Method::Dop853, .rtol = 1e-12, .atol = 1e-13});
  std::vector<Simulation> others;
  for (const KnownAccuracy& each : methods_to_compare) others.emplace_back(system, each.motion);
  for (int k = 1; k <= 20; ++k) {
    ASSERT_TRUE(reference.advance_to(0.1 * k).ok());
    for (std::size_t w = 0; w < std::size(methods_to_compare); ++w) {
      if (k % 5 != 0 && w % 2 == 0) continue;  // some of them in fewer, longer advances
      ASSERT_TRUE(others[w].advance_to(0.1 * k).ok()) << others[w].outcome().what;
      for (std::size_t a = 0; a < 3; ++a) {
        EXPECT_NEAR(others[w].multipliers()[a], reference.multipliers()[a], 1e3 * methods_to_compare[w].error)
            << name_of(methods_to_compare[w].motion.method) << " at " << 0.1 * k;
      }
    }
  }
  EXPECT_EQ(reference.report().singular_passages.count, 0u) << "a jump of unit vectors is no singular configuration";
}

/// A direction of any length tumbles, so that each axis is the farthest one for a while.
TEST(TurningLine, SeriesFollowALineThatTumbles) {
  System system = make_turning_wire(false);
  system.positions = {1.0, 0.0, 0.0};
  const VectorFunction direction(f("2*cos(t)*cos(0.7*t)"), f("2*sin(t)*cos(0.7*t)"), f("2*sin(0.7*t)"));
  system.velocities = {0.0, 1.0, 0.7};
  system.constraints = {Lines{"wire", {0}, Vector3{}, direction}};
  Simulation series(system, {.method = Method::Taylor, .rtol = 1e-11, .atol = 1e-12});
  Simulation stages(system, {.method = Method::Dop853, .rtol = 1e-12, .atol = 1e-13});

  for (int k = 1; k <= 20; ++k) {
    ASSERT_TRUE(series.advance_to(0.1 * k).ok()) << series.outcome().what;
    ASSERT_TRUE(stages.advance_to(0.1 * k).ok()) << stages.outcome().what;

    for (std::size_t i = 0; i < 3; ++i) {
      const double size = std::hypot(stages.positions()[0], stages.positions()[1], stages.positions()[2]);
      EXPECT_NEAR(series.positions()[i], stages.positions()[i], 1e-9 * size) << k;
      const double force = std::hypot(stages.reactions()[0], stages.reactions()[1], stages.reactions()[2]);
      EXPECT_NEAR(series.reactions()[i], stages.reactions()[i], 1e-8 * force) << k;
    }
  }
  EXPECT_LT(2 * series.report().steps, stages.report().steps);
}

}  // namespace
}  // namespace tanor
