#include <gtest/gtest.h>

#include "scenes.hpp"

namespace tanor {
namespace {

TEST(MethodTest, MethodsWithFixedStepsAskForAStep) {
  for (const MethodTraits& each : methods()) {
    bool asks = false;
    try {
      Simulation(scenes::make_chain(2), {.method = each.method});
    } catch (const InputError& error) {
      asks = error.where() == "/motion/step";
    }
    EXPECT_EQ(each.has_fixed_steps, asks) << each.name;
  }
}

bool accepts(const System& system, Method method) {
  MotionOptions options{.method = method};
  if (has_fixed_steps(method)) options.step = 1e-3;
  try {
    Simulation(system, options);
    return true;
  } catch (const InputError& error) {
    EXPECT_EQ(error.where(), "/motion/method") << error.what();
    return false;
  }
}

TEST(MethodTest, TheTableSaysWhichServeFrictionAndCoordinates) {
  System circle, rough;
  scenes::add_point({1, 0, 0}, &circle);
  circle.coordinates = {CircleCoordinates{.points = {0}, .normal = Vector3{0, 0, 1}, .radius = 1.0}};
  scenes::add_point({1, 0, 0}, &rough);
  rough.constraints = {Planes{.name = "floor", .points = {0}, .normal = Vector3{0, 0, 1}}};
  rough.friction = {Coulomb{.at = {"floor"}, .coefficient = 0.1}};
  rough.forces = {Gravity{.acceleration = {0, 0, -9.81}}};
  for (const MethodTraits& each : methods()) {
    EXPECT_EQ(accepts(circle, each.method), each.steps_in_coordinates) << each.name;
    EXPECT_EQ(accepts(rough, each.method), each.serves_friction) << each.name;
  }
}

/// Makes a bead on a rod and another one on a spring that swings 4e4 rad/s, while the beads fall at 10/s.
System make_stiff() {
  System system = scenes::make_chain(2);
  std::get<Rods>(system.constraints[0]).pairs.pop_back();
  system.forces.push_back(Springs{.name = "wire", .pairs = {{1, 2}}, .stiffness = 1e8});
  return system;
}

/// Returns the reason that `auto` gives for a system; a method that was asked for needs no reason.
std::string reason_of(const System& system, const MotionOptions& options, Method expected) {
  const MotionReport report = Simulation(system, options).report();
  EXPECT_EQ(report.method, expected) << report.method_reason;
  EXPECT_EQ(Simulation(system, {.method = expected, .step = 1e-3}).report().method_reason, "");
  return report.method_reason;
}

TEST(MethodTest, AutoSaysWhatItTakesAndWhy) {
  EXPECT_EQ(reason_of(scenes::make_chain(3), {}, Method::Taylor), "all constraints and forces have series in time");
  EXPECT_EQ(reason_of(scenes::make_chain(3), {.step = 1e-3}, Method::Rattle),
            "a step is given: one solve each, and energy that does not drift");

  System black_box = scenes::make_chain(3);
  black_box.forces.push_back(PairForces{.name = "pairs", .points = {1, 3}, .law = PairLaw::Log, .strength = 0.1});
  EXPECT_EQ(reason_of(black_box, {}, Method::Dop853),
            "no series in time: forces[1] cannot be expanded in time: pair forces have no series");

  System circle;
  scenes::add_point({1, 0, 0}, &circle);
  circle.coordinates = {CircleCoordinates{.points = {0}, .normal = Vector3{0, 0, 1}, .radius = 1.0}};
  EXPECT_EQ(reason_of(circle, {.step = 1e-3}, Method::Rk4), "a step is given, the motion is in coordinates");

  const std::string falls = reason_of(make_stiff(), {}, Method::Radau5);
  EXPECT_TRUE(falls.starts_with("stiff: wire[0] swings ")) << falls;
  EXPECT_TRUE(falls.ends_with(" times faster than the system falls")) << falls;
  const std::string steps = reason_of(make_stiff(), {.step = 1e-3}, Method::GeneralizedAlpha);
  EXPECT_TRUE(steps.starts_with("stiff: wire[0] swings by ")) << steps;
  EXPECT_TRUE(steps.ends_with(" radians a step")) << steps;
}

}  // namespace
}  // namespace tanor
