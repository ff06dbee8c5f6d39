#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <tanor/tanor.hpp>

#include "motion/rough_guides.hpp"
#include "scenes.hpp"

/// \file A point that nothing joins to a system does not affect it, however fast, far or heavy the point is and
/// whatever pulls at it.
namespace tanor {
namespace {

using scenes::g;

/// A free point, or one on a line of its own, that nothing joins to the others; it comes last.
struct Bystander {
  Vector3 place{5.0, 5.0, 5.0}, velocity{};
  double mass = 1.0, acceleration = 0.0;
  bool is_on_line = false;
};

System with(const Bystander& bystander, System system) {
  const auto point = static_cast<Index>(system.masses.size());
  system.velocities.resize(system.positions.size(), 0.0);
  system.positions.insert(system.positions.end(), bystander.place.begin(), bystander.place.end());
  system.velocities.insert(system.velocities.end(), bystander.velocity.begin(), bystander.velocity.end());
  system.masses.push_back(bystander.mass);
  const double force = bystander.mass * bystander.acceleration;
  if (force != 0.0) system.forces.push_back(ConstantForce{"pull", {point}, Vector3{force, 0.0, 0.0}});
  if (bystander.is_on_line) {
    system.constraints.push_back(Lines{"its line", {point}, bystander.place, Vector3{1.0, 0.0, 0.0}});
  }
  return system;
}

const std::vector<Bystander> bystanders{
    {.velocity = {1e5, 0.0, 0.0}},
    {.acceleration = 1e10},
    {.place = {1e9, 0.0, 0.0}},
    {.place = {3.0, 0.0, 1.0}, .velocity = {0.0, 1.0, 0.0}, .mass = 1e12},
    {.velocity = {1e5, 0.0, 0.0}, .is_on_line = true},
    {.acceleration = 1e10, .is_on_line = true},
    {.place = {1e9, 1e9, 0.0}, .velocity = {1e5, 0.0, 0.0}, .mass = 1e12, .acceleration = 1e10, .is_on_line = true},
};

/// Makes a block that slides over a rough plane, aslant to the force, until it stops.
System make_block() {
  System system;
  system.positions = {0.0, 0.0, 0.0};
  system.velocities = {0.04, 0.03, 0.0};
  system.masses = {1.0};
  system.constraints = {Planes{"floor", {0}, Vector3{0.0, 0.0, 1.0}, 0.0}};
  system.forces = {ConstantForce{"", {0}, Vector3{0.5, -0.2, -10.0}}};
  system.friction = {Coulomb{.name = "", .at = {"floor"}, .coefficient = 0.3}};
  return system;
}

/// Makes two beads on a rough line that a damped spring joins, pulled so slowly at first that they stick.
System make_train() {
  System system;
  system.positions = {0.0, 0.0, 0.0, 0.1, 0.0, 0.0};
  system.masses = {1.0, 0.5};
  system.constraints = {Lines{"rail", {0, 1}, Vector3{}, Vector3{1.0, 0.0, 0.0}}};
  system.forces = {Gravity{"", {0.0, 0.0, -g}},
                   ConstantForce{"", {0}, VectorFunction{ScalarFunction::formula("4*t"), 0.0, 0.0}},
                   Springs{"", {{0, 1}}, 500.0, 1.0, 0.1}};
  system.friction = {Coulomb{.name = "", .at = {"rail"}, .coefficient = 0.2, .static_coefficient = 0.3}};
  return system;
}

struct Scene {
  std::string name;
  System (*make)();
  double t_end;
};

const std::vector<Scene> the_scenes{{"block", make_block, 0.5},
                                    {"train", make_train, 2.0},
                                    {"pendulum", [] { return scenes::make_pendulum(); }, 1.0},
                                    {"chain", [] { return scenes::make_chain(5); }, 0.3},
                                    {"ring", [] { return scenes::make_ring(8); }, 0.3},
                                    {"shaken", [] { return scenes::make_shaken_chain(); }, 0.3},
                                    {"beads", [] { return scenes::make_beads(3); }, 0.3}};

struct Motion {
  std::vector<double> positions, velocities;
  std::size_t steps = 0, events = 0;
};

Motion run(const System& system, const MotionOptions& options, double t_end, std::size_t count) {
  Simulation simulation(system, options);
  const Outcome outcome = simulation.advance_to(t_end);
  EXPECT_TRUE(outcome.ok()) << outcome.what;
  const auto first = [&](std::span<const double> all) { return std::vector(all.begin(), all.begin() + count); };
  return {first(simulation.positions()), first(simulation.velocities()), simulation.report().steps,
          simulation.report().events};
}

TEST(Bystanders, DoNotChangeTheMotionOfOthers) {
  for (const Scene& scene : the_scenes) {
    const System system = scene.make();
    for (const Method method : {Method::Auto, Method::Dopri5, Method::Rattle}) {
      MotionOptions options{.method = method, .start = StartMode::Project};
      if (method == Method::Rattle) options.step = 1e-3;
      const Motion alone = run(system, options, scene.t_end, system.positions.size());
      for (std::size_t k = 0; k < bystanders.size(); ++k) {
        const Motion beside = run(with(bystanders[k], system), options, scene.t_end, system.positions.size());
        const std::string what = scene.name + ", bystander " + std::to_string(k) + ", " + std::string(name_of(method));
        EXPECT_EQ(beside.events, alone.events) << what;
        EXPECT_LE(beside.steps, alone.steps + alone.steps / 2 + 20) << what;
        EXPECT_GE(beside.steps + beside.steps / 2 + 20, alone.steps) << what;
        const double allowed = method == Method::Rattle ? 1e-10 : 3e-6;  // some tolerances of 1e-8, along the motion
        EXPECT_LE(largest_difference(beside.positions, alone.positions), allowed) << what;
        EXPECT_LE(largest_difference(beside.velocities, alone.velocities), 100.0 * allowed) << what;
      }
    }
  }
}

/// Makes light beads with a heavy tip in a straight line, aslant. S is ill-conditioned, so that residuals decide what
/// is refined.
System make_heavy_tip() {
  System system = scenes::make_chain_along(10, {0.06, 0.0, -0.08}, 1e-2);
  system.masses.back() = 1e4;
  return scenes::hang(system, {0});
}

/// Makes the same chain with angles as coordinates.
System make_angles() {
  System system = make_heavy_tip();
  system.constraints.clear();
  system.coordinates = {ChainAngles{.name = "", .points = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10}, .anchor = 0, .length = 0.1}};
  return system;
}

TEST(Bystanders, DoNotChangeAccelerationsOfAnIllConditionedChain) {
  for (const auto& make : {make_heavy_tip, make_angles}) {
    const System system = make();
    const auto solve = [&](const System& of) {
      Dynamics dynamics(of);
      std::vector<double> w(of.positions.size()), v(of.positions.size(), 0.0);
      std::copy(of.velocities.begin(), of.velocities.end(), v.begin());
      const SolveReport report =
          dynamics.solve({.time = 0.0, .positions = of.positions, .velocities = v}, {.accelerations = w});
      EXPECT_TRUE(report.outcome.ok()) << report.outcome.what;
      w.resize(system.positions.size());
      return w;
    };
    const std::vector<double> alone = solve(system);
    for (std::size_t k = 0; k < bystanders.size(); ++k) {
      if (!system.coordinates.empty() && bystanders[k].is_on_line) continue;
      System both = with(bystanders[k], system);
      if (!system.coordinates.empty()) both.coordinates.push_back(FreeCoordinates{"", {11}});
      EXPECT_LE(largest_difference(solve(both), alone), 1e-10) << "bystander " << k;
    }
  }
}

TEST(Bystanders, DoNotChangeAccelerations) {
  for (const Scene& scene : the_scenes) {
    const System system = scene.make();
    const std::size_t count = system.positions.size();
    const auto solve = [&](const System& of) {
      Simulation simulation(of, {.method = Method::Dop853, .start = StartMode::Project});
      EXPECT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
      const auto w = simulation.accelerations();
      return std::vector(w.begin(), w.begin() + static_cast<std::ptrdiff_t>(count));
    };
    const std::vector<double> alone = solve(system);
    for (std::size_t k = 0; k < bystanders.size(); ++k) {
      const std::vector<double> beside = solve(with(bystanders[k], system));
      EXPECT_LE(largest_difference(beside, alone), 1e-11 * std::max(1.0, largest(alone)))
          << scene.name << ", bystander " << k;
    }
  }
}

/// A block under F = 1.1 + mu m g along x slides by its own forces, whatever another point feels.
TEST(Bystanders, ABlockSlidesByItsOwnForces) {
  const double mu = 0.3;
  for (const Bystander& bystander : bystanders) {
    System system;
    system.positions = {0.0, 0.0, 0.0};
    system.masses = {1.0};
    system.constraints = {Planes{"floor", {0}, Vector3{0.0, 0.0, 1.0}, 0.0}};
    system.forces = {ConstantForce{"", {0}, Vector3{1.1 + mu * g, 0.0, -g}}};
    system.friction = {Coulomb{.name = "", .at = {"floor"}, .coefficient = mu}};
    system = with(bystander, system);
    Dynamics dynamics(system);
    std::vector<double> w(6);
    const SolveReport report = dynamics.solve(
        {.time = 0.0, .positions = system.positions, .velocities = system.velocities}, {.accelerations = w});
    ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
    EXPECT_NEAR(w[0], 1.1, 1e-13);
  }
}

RC_GTEST_PROP(Bystanders, LeaveTheBlockAloneAtAnySpeedPlaceAndPull, ()) {
  const auto power_of_ten = [](int least, int most) { return std::pow(10.0, *rc::gen::inRange(least, most + 1)); };
  const double far = power_of_ten(0, 9);
  const Bystander bystander{.place = {far, -far, 0.3 * far},
                            .velocity = {power_of_ten(-6, 5), 0.0, 0.0},
                            .mass = power_of_ten(-12, 12),
                            .acceleration = power_of_ten(-3, 10),
                            .is_on_line = *rc::gen::arbitrary<bool>()};
  const MotionOptions options{.rtol = 1e-10};
  const Motion alone = run(make_block(), options, 0.5, 3), beside = run(with(bystander, make_block()), options, 0.5, 3);

  RC_ASSERT(beside.events == alone.events);
  RC_ASSERT(beside.steps <= alone.steps + alone.steps / 2 + 20);
  RC_ASSERT(largest_difference(beside.positions, alone.positions) <= 1e-11);
}

/// Each group has its own bound for the errors that conjugate gradients leave at a stage, so that a heavy bystander
/// does not use up the bound of the others.
TEST(Bystanders, DoNotLoosenTheStagesOfANetWhenHeavy) {
  System net = scenes::make_net(24, 24);
  for (std::size_t i = 0; i < net.positions.size(); i += 3)
    net.velocities[i + 2] = 0.1 * std::sin(7.0 * net.positions[i] + 3.0 * net.positions[i + 1]);
  const MotionOptions options{.method = Method::Dop853, .rtol = 1e-9, .start = StartMode::Project};
  const Bystander heavy{.place = {3.0, 0.0, 1.0}, .velocity = {0.0, 1.0, 0.0}, .mass = 1e12};
  const std::size_t count = net.positions.size();
  const Motion alone = run(net, options, 0.1, count), beside = run(with(heavy, net), options, 0.1, count);
  EXPECT_LE(largest_difference(beside.positions, alone.positions), 1e-9);
  EXPECT_NEAR(static_cast<double>(beside.steps), static_cast<double>(alone.steps), 2.0);
}

/// A block stops where it would alone, also beside one that is 1e12 times as heavy and that nothing joins to it.
TEST(Bystanders, DoNotChangeTheFrictionOfOthers) {
  System heavy = make_block();
  heavy.masses = {1e12};
  std::get<ConstantForce>(heavy.forces[0]).force = Vector3{5e11, -2e11, -1e13};
  System both = make_block();
  both.positions.insert(both.positions.end(), {0.0, 7.0, 0.0});
  both.velocities.insert(both.velocities.end(), {0.04, 0.03, 0.0});
  both.masses.push_back(1e12);
  std::get<Planes>(both.constraints[0]).points = {0, 1};
  both.forces.push_back(ConstantForce{"", {1}, Vector3{5e11, -2e11, -1e13}});
  const MotionOptions options{.rtol = 1e-10};
  const Motion alone = run(make_block(), options, 0.5, 3), beside = run(both, options, 0.5, 3);
  EXPECT_LE(largest_difference(beside.positions, alone.positions), 1e-12);
}

}  // namespace
}  // namespace tanor
