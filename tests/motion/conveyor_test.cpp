#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <tanor/tanor.hpp>

#include "motion/rough_guides.hpp"
#include "scenes.hpp"

/// \file Guides that move: belts, planes that tilt, and a belt that pulls a mass at its spring.
namespace tanor {
namespace {

using scenes::g;

TEST(Conveyor, ABeadReachesTheBeltAndGoesAlong) {
  // The speed grows as v = v0 + mu g t up to u; from then on r = r1 + u (t - t1).
  const double mu = 0.35, u = 2.0, v0 = -0.7, t1 = (u - v0) / (mu * g), r1 = 0.5 * (u + v0) * t1;
  for (const Method method : sampled_methods) {
    System system;
    system.positions = {0.0, 0.0, 0.0};
    system.velocities = {v0, 0.0, 0.0};
    system.masses = {0.8};
    system.constraints = {Lines{"belt", {0}, Vector3{}, Vector3{1.0, 0.0, 0.0}}};
    system.forces = {Gravity{"", {0.0, 0.0, -g}}};
    system.friction = {Coulomb{.name = "", .at = {"belt"}, .coefficient = mu, .velocity = Vector3{u, 0.0, 0.0}}};
    MotionOptions options{.method = method};
    if (has_fixed_steps(method)) options.step = 0.01;
    Simulation simulation(system, options);
    const std::vector<double> events = advance_and_list_events(&simulation, 100.0);
    ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
    ASSERT_EQ(events.size(), 1u);
    EXPECT_NEAR(events[0], t1, 1e-13) << name_of(method);
    EXPECT_NEAR(simulation.velocities()[0], u, 1e-15);
    EXPECT_NEAR(simulation.positions()[0], r1 + u * (100.0 - t1), 1e-11);
    // The work of friction is mu m g times the path of the bead.
    EXPECT_NEAR(simulation.report().energy.work_of_friction, mu * 0.8 * g * r1, 1e-12);
    EXPECT_LE(std::abs(simulation.report().energy.drift_relative()), 1e-12);
  }
}

TEST(Conveyor, AVelocityThatChangesCarriesAlongAsFarAsFrictionReaches) {
  // The belt moves with u = b t^2/2. The block sticks while u_dot = b t <= mu_s g, then it slides behind with mu g.
  const double mu = 0.3, mu_s = 0.4, b = 3.0, t1 = mu_s * g / b;
  System system;
  system.positions = {0.0, 0.0, 0.0};
  system.masses = {1.0};
  system.constraints = {Planes{"belt", {0}, Vector3{0.0, 0.0, 1.0}, 0.0}};
  system.forces = {Gravity{"", {0.0, 0.0, -g}}};
  const VectorFunction velocity{ScalarFunction::formula("1.5*t^2*0.6"), ScalarFunction::formula("1.5*t^2*0.8"), 0.0};
  system.friction = {
      Coulomb{.name = "", .at = {"belt"}, .coefficient = mu, .static_coefficient = mu_s, .velocity = velocity}};
  for (const Method method : sampled_methods) {
    MotionOptions options{.method = method, .rtol = 1e-10, .atol = 1e-12};
    if (has_fixed_steps(method)) options.step = 0.005;
    Simulation simulation(system, options);
    const std::vector<double> events = advance_and_list_events(&simulation, 2.0);
    ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
    ASSERT_EQ(events.size(), 1u);
    EXPECT_NEAR(events[0], t1, 1e-11) << name_of(method);
    const double v = 0.5 * b * t1 * t1 + mu * g * (2.0 - t1);
    EXPECT_NEAR(simulation.velocities()[0], 0.6 * v, 1e-9) << name_of(method);
    EXPECT_NEAR(simulation.velocities()[1], 0.8 * v, 1e-9) << name_of(method);
  }
}

/// The plane passes through the origin and is tilted by x = w t about the y axis; s is measured down along it:
///   s_ddot = s w^2 + g sin x - friction,   N = m (g cos x + 2 w s_dot)
TEST(TiltingPlane, ABeadLeavesAtTheInstantOfTheClosedForm) {
  const double w = 0.2, s0 = 0.5, mu = 0.4;
  // The bead leaves where s0 w^2 + g sin x = mu g cos x.
  const double instant = (std::atan(mu) - std::asin(s0 * w * w / (g * std::sqrt(1.0 + mu * mu)))) / w;
  System system;
  system.positions = {s0, 0.3, 0.0};
  system.velocities = {0.0, 0.0, -w * s0};
  system.masses = {2.0};
  const VectorFunction normal{ScalarFunction::formula("sin(0.2*t)"), 0.0, ScalarFunction::formula("cos(0.2*t)")};
  system.constraints = {Planes{"plane", {0}, normal, 0.0}};
  system.forces = {Gravity{"", {0.0, 0.0, -g}}};
  system.friction = {Coulomb{.name = "", .at = {"plane"}, .coefficient = mu}};
  for (const Method method : sampled_methods) {
    MotionOptions options{.method = method, .rtol = 1e-11, .atol = 1e-13};
    if (has_fixed_steps(method)) options.step = 0.005;
    Simulation simulation(system, options);
    std::vector<double> events = advance_and_list_events(&simulation, 0.9 * instant);
    EXPECT_TRUE(events.empty());
    const auto r = simulation.positions();
    EXPECT_NEAR(std::hypot(r[0], r[2]), s0, 1e-11) << name_of(method);
    events = advance_and_list_events(&simulation, instant + 0.3);
    ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
    ASSERT_EQ(events.size(), 1u);
    EXPECT_NEAR(events[0], instant, 1e-10) << name_of(method);
  }
}

/// The belt moves with u = sin t along a line and carries the bead along, so that r = 1 - cos t.
TEST(Conveyor, StickingBeadKeepsItsPlaceOnTheBelt) {
  System system;
  system.positions = {0.0, 0.0, 0.0};
  system.masses = {1.0};
  system.constraints = {Lines{"belt", {0}, Vector3{}, Vector3{1.0, 0.0, 0.0}}};
  system.forces = {Gravity{"", {0.0, 0.0, -g}}};
  system.friction = {Coulomb{
      .name = "", .at = {"belt"}, .coefficient = 0.5, .velocity = {ScalarFunction::formula("sin(t)"), 0.0, 0.0}}};
  for (const Method method : with_auto(sampled_methods)) {
    MotionOptions options{.method = method};
    if (has_fixed_steps(method)) options.step = 0.02;
    Simulation simulation(system, options);
    ASSERT_TRUE(simulation.advance_to(100.0).ok()) << simulation.outcome().what;
    EXPECT_EQ(simulation.report().events, 0u);
    EXPECT_NEAR(simulation.positions()[0], 1.0 - std::cos(100.0), 1e-12) << name_of(method);
  }
}

/// A mass at a spring on a belt of speed u sticks for 2 D/u and slides for (2 pi - 2 atan(D w/u))/w, where
/// D = (mu_s - mu) m g/k and w^2 = k/m.
TEST(StickSlipOscillator, PeriodIsTheClosedForm) {
  const double m = 0.5, k = 20.0, u = 0.3, mu = 0.2, mu_s = 0.35, w = std::sqrt(k / m), D = (mu_s - mu) * m * g / k;
  const double sticks = 2.0 * D / u, slides = (2.0 * std::numbers::pi - 2.0 * std::atan(D * w / u)) / w;
  System system;
  system.positions = {-1.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  system.velocities = {0.0, 0.0, 0.0, u, 0.0, 0.0};
  system.masses = {1.0, m};
  system.supports = {{"wall", {0}, {}}};
  system.constraints = {Lines{"belt", {1}, Vector3{}, Vector3{1.0, 0.0, 0.0}}};
  system.forces = {Gravity{"", {0.0, -g, 0.0}}, Springs{"spring", {{0, 1}}, k, 0.0, 1.0}};
  system.friction = {Coulomb{
      .name = "", .at = {"belt"}, .coefficient = mu, .static_coefficient = mu_s, .velocity = Vector3{u, 0.0, 0.0}}};
  for (const Method method : sampled_methods) {
    MotionOptions options{.method = method, .rtol = 1e-11, .atol = 1e-13};
    if (has_fixed_steps(method)) options.step = 1e-3;
    Simulation simulation(system, options);
    const double first = mu_s * m * g / (k * u);  // it rides with the belt until then
    const std::vector<double> events = advance_and_list_events(&simulation, first + 5.0 * (sticks + slides) + 0.01);
    ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
    ASSERT_EQ(events.size(), 11u) << name_of(method);
    const double allowed = method == Method::Rattle ? 1e-4 : 1e-9;
    for (std::size_t e = 0; e < events.size(); ++e) {
      const double wanted = first + static_cast<double>(e / 2) * (sticks + slides) + (e % 2 == 1 ? slides : 0.0);
      EXPECT_NEAR(events[e], wanted, allowed) << name_of(method) << " event " << e;
    }
  }
}

}  // namespace
}  // namespace tanor
