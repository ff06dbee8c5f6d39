/// A block that friction brings to rest where a motion ends.

#include <cmath>

#include <gtest/gtest.h>

#include "motion/by_method.hpp"

namespace tanor {
namespace {

/// Returns a block on a plane that slides at `speed` and is slowed down at `coefficient` times `gravity`.
System make_viscous_block(double speed, double coefficient, double gravity) {
  System system;
  system.add_point({.position = {0, 0, 0}, .velocity = {speed, 0, 0}, .mass = 1.0});
  system.constraints = {Planes{.name = "a", .points = {0}, .normal = {0, 0, 1}, .offset = 0.0}};
  system.forces = {Gravity{"gravity", {0, 0, -gravity}}};
  system.friction = {Coulomb{.at = {"a"}, .coefficient = coefficient}};
  return system;
}

class StopAtEnd : public testing::TestWithParam<Method> {};

TEST_P(StopAtEnd, IsCertifiedWhicheverComesFirst) {
  struct Case {
    double speed, coefficient, gravity;
  };
  for (const auto& [speed, coefficient, gravity] :
       {Case{1.0, 0.1, 10.0}, Case{1.3, 0.23, 9.81}, Case{0.017, 0.4, 9.81}}) {
    const double stop = speed / (coefficient * gravity), way = 0.5 * speed * stop;
    for (const double apart : {0.0, 1e-16, 3e-16, 1e-15, 1e-14, 1e-13, 5e-13, 1e-12, 3e-12, 1e-11, 1e-9}) {
      for (const double sign : {1.0, -1.0}) {
        const double t_end = stop * (1.0 + sign * apart);
        MotionOptions options;
        options.method = GetParam();
        if (has_fixed_steps(options.method)) options.step = 0.01 * stop;
        Simulation simulation(make_viscous_block(speed, coefficient, gravity), options);

        ASSERT_TRUE(simulation.advance_to(t_end).ok()) << simulation.outcome().what;

        const Certificate certificate = simulation.certify();
        EXPECT_TRUE(certificate.passed()) << sign * apart << ": " << certificate.line();
        EXPECT_NEAR(simulation.positions()[0], way, 1e-9 * way);
        ASSERT_TRUE(simulation.advance_to(2.0 * t_end).ok());
        EXPECT_NEAR(simulation.positions()[0], way, 1e-9 * way);
        EXPECT_LT(std::abs(simulation.velocities()[0]), 1e-10 * speed);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, StopAtEnd,
                         testing::Values(Method::Auto, Method::Dop853, Method::Dopri5, Method::Rk4, Method::Rattle),
                         name_method);

}  // namespace
}  // namespace tanor
