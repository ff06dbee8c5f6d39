#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "allocation/steady_steps.hpp"
#include "scenes.hpp"

/// \file Steps with friction take no memory while no contact changes its mode.
namespace tanor {
namespace {

Coulomb make_rough(const std::string& guide, double mu) {
  return Coulomb{.name = "rough " + guide, .at = {guide}, .coefficient = mu};
}

/// Makes six beads on one line. Every second one slides, the others stick against a push that grows and falls.
System make_beads_on_a_line() {
  System system;
  Lines line{"line", {}, Vector3{}, Vector3{1.0, 0.0, 0.0}};
  ConstantForce push{"push", {}, {ScalarFunction::formula("0.1*sin(3*t)"), 0.0, 0.0}};
  for (int k = 0; k < 6; ++k) {
    const Index i = scenes::add_point({1.0 * k, 0.0, 0.0}, &system);
    line.points.push_back(i);
    if (k % 2 == 0)
      system.velocities[3 * static_cast<std::size_t>(i)] = 10.0;
    else
      push.points.push_back(i);
  }
  system.constraints = {line};
  system.forces = {scenes::gravity, push};
  system.friction = {make_rough("line", 0.3)};
  return system;
}

/// Makes bars between a rough wall and a rough floor. Friction at one end of a bar presses the other end.
///
///     |o
///     | \        c = 0.6, s = 0.8
///     |__o___
System make_bars_on_lines(int count, double speed, double mu) {
  System system;
  Rods bars{"bars", {}, {}, {}};
  for (int k = 0; k < count; ++k) {
    const double y = 1.0 * k, c = 0.6, s = 0.8;
    const Index top = scenes::add_point({0.0, y, s}, &system), foot = scenes::add_point({c, y, 0.0}, &system);
    bars.pairs.push_back({top, foot});
    const std::string number = std::to_string(k);
    system.constraints.push_back(Lines{"wall" + number, {top}, Vector3{0.0, y, 0.0}, Vector3{0.0, 0.0, 1.0}});
    system.constraints.push_back(Lines{"floor" + number, {foot}, Vector3{0.0, y, 0.0}, Vector3{1.0, 0.0, 0.0}});
    system.friction.push_back(make_rough("wall" + number, mu));
    system.friction.push_back(make_rough("floor" + number, mu));
    // The bar keeps its length: c c' + s s' = 0.
    system.velocities[3 * static_cast<std::size_t>(top) + 2] = -speed * c;
    system.velocities[3 * static_cast<std::size_t>(foot)] = speed * s;
  }
  system.constraints.push_back(bars);
  system.forces = {scenes::gravity};
  return system;
}

/// Makes beads on a plane and on spheres, some of which slide and some of which stick.
System make_beads_on_surfaces() {
  System system;
  Planes floor{"floor", {}, Vector3{0.0, 0.0, 1.0}, 0.0};
  Spheres balls{"balls", {}, Vector3{0.0, 0.0, 0.0}, 2.0};
  for (int k = 0; k < 4; ++k) {
    const auto i = static_cast<std::size_t>(scenes::add_point({1.0 * k, 3.0, 0.0}, &system));
    floor.points.push_back(static_cast<Index>(i));
    if (k % 2 == 0) system.velocities[3 * i] = system.velocities[3 * i + 1] = 5.0;
  }
  for (int k = 0; k < 4; ++k) {
    const double angle = 1.5 * k, tilt = 0.1;
    const auto i = static_cast<std::size_t>(scenes::add_point(
        {2.0 * std::sin(tilt) * std::cos(angle), 2.0 * std::sin(tilt) * std::sin(angle), 2.0 * std::cos(tilt)},
        &system));
    balls.points.push_back(static_cast<Index>(i));
    if (k % 2 == 0) {
      system.velocities[3 * i] = -5.0 * std::sin(angle);
      system.velocities[3 * i + 1] = 5.0 * std::cos(angle);
    }
  }
  system.constraints = {floor, balls};
  system.forces = {scenes::gravity, ConstantForce{"push", {1, 3}, {ScalarFunction::formula("0.1*sin(3*t)"), 0.0, 0.0}}};
  system.friction = {make_rough("floor", 0.3), make_rough("balls", 0.3)};
  return system;
}

/// Makes a row of beads on rods that slides over a rough plane.
System make_sliding_rope() {
  System system = scenes::make_chain(8, false);
  Planes floor{"floor", {}, Vector3{0.0, 0.0, 1.0}, 0.0};
  for (std::size_t i = 0; i < system.num_points(); ++i) {
    floor.points.push_back(static_cast<Index>(i));
    system.velocities[3 * i] = 5.0;
    system.velocities[3 * i + 1] = 3.0 * static_cast<double>(i) - 12.0;
  }
  system.constraints.push_back(floor);
  system.friction = {make_rough("floor", 0.2)};
  return system;
}

/// Makes the same rope at rest, pulled too little to move. Its sticking contacts share the load.
System make_resting_rope() {
  System system = make_sliding_rope();
  std::fill(system.velocities.begin(), system.velocities.end(), 0.0);
  system.forces.push_back(ConstantForce{"pull", {8}, {ScalarFunction::formula("0.1*sin(3*t)"), 0.0, 0.0}});
  return system;
}

/// Makes beads that stick to a turning hoop, and some that slide on it.
System make_turning_hoop() {
  System system;
  Circles hoop{"hoop",
               {},
               Vector3{0.0, 0.0, 0.0},
               {ScalarFunction::formula("sin(2*t)"), ScalarFunction::formula("cos(2*t)"), 0.0},
               1.0};
  for (int k = 0; k < 4; ++k) {
    const double angle = -1.7 + 0.08 * k, x = std::cos(angle), z = std::sin(angle);
    const auto i = static_cast<std::size_t>(scenes::add_point({x, 0.0, z}, &system));
    hoop.points.push_back(static_cast<Index>(i));
    system.velocities[3 * i + 1] = -2.0 * x;
    if (k % 2 == 0) {
      system.velocities[3 * i] = 5.0 * z;
      system.velocities[3 * i + 2] = -5.0 * x;
    }
  }
  system.constraints = {hoop};
  system.forces = {scenes::gravity};
  system.friction = {make_rough("hoop", 0.5)};
  return system;
}

/// Makes the beads on surfaces with laws of friction that never stick.
System make_creeping_beads() {
  System system = make_beads_on_surfaces();
  Coulomb floor = make_rough("floor", 0.3);
  floor.regularisation = 1e-2;
  Coulomb balls = make_rough("balls", 0.3);
  balls.reaction = Coulomb::Reaction::Full;
  system.friction = {floor, balls, Viscous{.name = "oil", .at = {"floor"}, .coefficient = 0.1}};
  return system;
}

const allocation::Scene scenes_with_friction[]{
    {"beads_on_a_line", make_beads_on_a_line},
    {"sliding_bars", [] { return make_bars_on_lines(2, 2.0, 0.2); }},
    {"many_sliding_bars", [] { return make_bars_on_lines(10, 2.0, 0.2); }},
    {"resting_bars", [] { return make_bars_on_lines(2, 0.0, 0.9); }},
    {"beads_on_surfaces", make_beads_on_surfaces},
    {"sliding_rope", make_sliding_rope},
    {"resting_rope", make_resting_rope},
    {"turning_hoop", make_turning_hoop},
    {"creeping_beads", make_creeping_beads},
};

MotionOptions make_friction_options(Method method) {
  MotionOptions options{.method = method, .max_step = 1e-3, .rtol = 1e-9, .atol = 1e-11, .start = StartMode::Project};
  if (has_fixed_steps(method)) options.step = 1e-3;
  return options;
}

class StepWithFrictionTest : public testing::TestWithParam<allocation::Steps> {};

TEST_P(StepWithFrictionTest, AllocatesNothing) {
  const auto& [scene, method, threads] = GetParam();
  Simulation simulation(scene.build(), make_friction_options(method), {.threads = threads});

  EXPECT_EQ(allocation::count_in_steady_steps(&simulation), 0u);
  EXPECT_EQ(simulation.report().events, 0u) << "a scene that changes no mode";
}

// Method `dop853` is left out, since it runs the loops of `dopri5`.
INSTANTIATE_TEST_SUITE_P(Scenes, StepWithFrictionTest,
                         testing::Combine(testing::ValuesIn(scenes_with_friction),
                                          testing::Values(Method::Auto, Method::Rk4, Method::Dopri5, Method::Rattle,
                                                          Method::Rattle4, Method::Rattle6),
                                          testing::Values(1, 2)),
                         allocation::name_steps);

class FrictionMethodTest : public testing::TestWithParam<FrictionMethod> {};

/// The bars are coupled so strongly that `auto` takes Newton's method.
TEST_P(FrictionMethodTest, AllocatesNothing) {
  Simulation simulation(make_bars_on_lines(2, 2.0, 0.6), make_friction_options(Method::Dopri5),
                        {.threads = 1, .friction = GetParam()});

  EXPECT_EQ(allocation::count_in_steady_steps(&simulation), 0u);
  const FrictionMethod expected = GetParam() == FrictionMethod::Auto ? FrictionMethod::Newton : GetParam();
  EXPECT_EQ(simulation.report().friction.method_used, expected);
}

INSTANTIATE_TEST_SUITE_P(Methods, FrictionMethodTest,
                         testing::Values(FrictionMethod::Auto, FrictionMethod::FixedPoint, FrictionMethod::Anderson,
                                         FrictionMethod::Newton));

}  // namespace
}  // namespace tanor
