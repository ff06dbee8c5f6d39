/// `auto` meets systems that turn out stiff on the way: drag, springs without gravity, formulas, light points.

#include <cmath>
#include <functional>

#include <gtest/gtest.h>
#include <tanor/kernel.hpp>

#include "motion/extreme_scenes.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

struct StiffScene {
  const char* name;
  System system;
  double t_end;                                      // s
  std::function<double(const Simulation&)> error{};  // m, of a closed form
};

/// A point of 1 kg falls in a drag of 1e6 kg/s. By v' = g - k v with k = 1e6/s it falls at g/k after some microseconds.
StiffScene fall_in_honey() {
  System system;
  scenes::add_point({0, 0, 0}, &system);
  system.masses = {1.0};
  system.forces = {scenes::gravity, Drag{"honey", {0}, 1e6, 0.0}};
  const auto error = [](const Simulation& simulation) {
    const double k = 1e6, fallen = 9.81 / k * (1.0 - 1.0 / k);
    return std::abs(simulation.positions()[2] + fallen);
  };
  return {"drag", system, 1.0, error};
}

/// A point slides in a well of 1e8 N/m and 1e5 kg/s along x while it swings along y with 1 rad/s.
StiffScene slide_in_a_formula() {
  System system;
  scenes::add_point({1e-3, 0, 0}, &system);
  system.masses = {1.0};
  system.velocities = {0, 1, 0};
  system.forces = {FormulaForce{"well", {0}, formula_force({"-1e8*x - 1e5*vx", "-y", "0"})}};
  const auto error = [](const Simulation& simulation) {
    return std::max(std::abs(simulation.positions()[0]), std::abs(simulation.positions()[1] - std::sin(1.0)));
  };
  return {"formula", system, 1.0, error};
}

/// Two points 1 m apart on a spring of 1e8 N/m with its damper, without gravity, are pushed slowly. They are an
/// oscillator that creeps, and their middle moves by F t^2/(2 m).
StiffScene push_a_spring() {
  System system;
  scenes::add_point({0, 0, 0}, &system);
  scenes::add_point({1, 0, 0}, &system);
  system.masses = {1.0, 1.0};
  system.forces = {Springs{"spring", {{0, 1}}, 1e8, 1e5, 1.0}, ConstantForce{"push", {0}, Vector3{0.5, 0, 0}}};
  const auto error = [](const Simulation& simulation) {
    return std::abs(0.5 * (simulation.positions()[0] + simulation.positions()[3]) - (0.5 + 0.5 * 0.25 * 25.0));
  };
  return {"spring", system, 5.0, error};
}

/// A force of 20 N pulls 1e-2 kg by a rod to a tip of 1e-13 kg, which would swing about the rod with 2e7 rad/s.
StiffScene pull_a_light_tip() {
  System system;
  scenes::add_point({0, 0, 0}, &system);
  scenes::add_point({0.3, 0.4, 0}, &system);
  system.masses = {1e-2, 1e-13};
  system.constraints = {Rods{"rod", {{0, 1}}, {}, {}}};
  system.forces = {ConstantForce{"pull", {1}, Vector3{12, 16, 0}}};
  const auto error = [](const Simulation& simulation) {
    return std::hypot(simulation.positions()[0] - 600.0, simulation.positions()[1] - 800.0);
  };
  return {"light tip", system, 1.0, error};
}

TEST(StiffSteps, AutoGoesOverToRadau5) {
  for (const StiffScene& scene : {fall_in_honey(), slide_in_a_formula(), push_a_spring(), pull_a_light_tip()}) {
    SCOPED_TRACE(scene.name);
    Simulation chosen(scene.system), asked(scene.system, {.method = Method::Radau5});
    std::size_t steps = 0;

    ASSERT_TRUE(chosen.advance_to(scene.t_end, [&](const MotionReport&) { return ++steps < 20'000; }).ok());
    ASSERT_TRUE(asked.advance_to(scene.t_end).ok());

    EXPECT_EQ(chosen.time(), scene.t_end);
    EXPECT_EQ(chosen.report().method, Method::Radau5);
    EXPECT_TRUE(chosen.report().method_reason.starts_with("stiff: ")) << chosen.report().method_reason;
    EXPECT_LE(chosen.report().steps, 2 * asked.report().steps + 600);
    EXPECT_LE(scene.error(chosen), 1e-6);
  }
}

/// Steps stay explicit where accuracy itself asks for their length, in a chain and on a spring that swings.
TEST(StiffSteps, AreNotAssumedWhereAccuracyAsksForShortSteps) {
  System swinging;
  scenes::add_point({0, 0, 0}, &swinging);
  scenes::add_point({1.01, 0, 0}, &swinging);
  swinging.supports = {{"wall", {0}, {}}};
  swinging.forces = {Springs{"spring", {{0, 1}}, 1e4, 0.0, 1.0}};
  for (const System& system : {swinging, scenes::make_chain(5)}) {
    Simulation simulation(system);

    ASSERT_TRUE(simulation.advance_to(10.0).ok());

    EXPECT_GT(simulation.report().steps, 500U);
    EXPECT_EQ(simulation.report().method, Method::Taylor);
    EXPECT_EQ(simulation.report().method_reason, "all constraints and forces have series in time");
  }
}

/// Returns a block of 1 kg at 1 m/s on a plane in oil of so many N s/m, which a belt may move along.
System slide_in_oil(double coefficient, double belt = 0.0) {
  System system;
  scenes::add_point({0, 0, 0}, &system);
  system.masses = {1.0};
  system.velocities = {1, 0, 0};
  system.constraints = {Planes{"floor", {0}, Vector3{0, 0, 1}, 0.0}};
  system.forces = {scenes::gravity};
  system.friction = {Viscous{"oil", {"floor"}, coefficient, Vector3{belt, 0, 0}}};
  return system;
}

/// By v' = -c (v - u)/m the block comes to the speed of the belt, and to u t + (1 m/s - u) m/c.
TEST(StiffSteps, EndWhereViscousFrictionIsStrong) {
  for (const double c : {1e3, 1e5, 1e7}) {
    for (const double belt : {0.0, 0.3}) {
      SCOPED_TRACE(testing::Message() << c << " N s/m, " << belt << " m/s");
      Simulation chosen(slide_in_oil(c, belt)), asked(slide_in_oil(c, belt), {.method = Method::Radau5});

      ASSERT_TRUE(chosen.advance_to(1.0).ok()) << chosen.outcome().what;
      ASSERT_TRUE(asked.advance_to(1.0).ok()) << asked.outcome().what;

      EXPECT_LE(chosen.report().steps + chosen.report().rejected, 300U);
      for (Simulation* const each : {&chosen, &asked}) {
        EXPECT_NEAR(each->positions()[0], belt + (1.0 - belt) / c, 1e-9);
        EXPECT_NEAR(each->velocities()[0], belt, 1e-9);
        // The belt's friction takes what the block loses.
        EXPECT_NEAR(each->report().energy.work_of_friction, 0.5 * (belt * belt - 1.0), 1e-6);
        EXPECT_NEAR(each->friction_forces()[0], 0.0, 1e-6);
        EXPECT_NEAR(each->multipliers()[0], 9.81, 1e-9);
      }
    }
  }
}

/// A bead in oil creeps down a bowl, and another one, on a spring to it, down a wire that turns.
TEST(StiffSteps, FollowGuidesInOil) {
  System system;
  scenes::add_point({0.8, 0, -0.6}, &system);
  scenes::add_point({1, 0, 0}, &system);
  system.velocities[4] = 0.5;
  system.masses = {1.0, 0.5};
  const VectorFunction turning{ScalarFunction::formula("cos(t/2)"), ScalarFunction::formula("sin(t/2)"), -0.5};
  system.constraints = {Spheres{"bowl", {0}, Vector3{}, 1.0}, Lines{"wire", {1}, Vector3{1, 0, 0}, turning}};
  system.forces = {scenes::gravity, Springs{"spring", {{0, 1}}, 30.0, 0.0, {}}};
  system.friction = {Viscous{"oil", {"bowl"}, 2e3}, Viscous{"tar", {"wire"}, 1e4}};
  const MotionOptions options{.rtol = 1e-10, .start = StartMode::Project};
  MotionOptions explicitly = options;
  explicitly.method = Method::Dop853;
  Simulation chosen(system, options), alone(system, explicitly);

  ASSERT_TRUE(chosen.advance_to(0.5).ok()) << chosen.outcome().what;
  ASSERT_TRUE(alone.advance_to(0.5).ok()) << alone.outcome().what;

  EXPECT_EQ(chosen.report().method, Method::Radau5);
  EXPECT_LE(largest_difference(chosen.positions(), alone.positions()), 1e-9);
  EXPECT_LE(largest_difference(chosen.multipliers(), alone.multipliers()), 1e-5);
  EXPECT_NEAR(chosen.report().energy.work_of_friction, alone.report().energy.work_of_friction, 1e-6);
  EXPECT_LT(chosen.report().steps, alone.report().steps / 2);
}

TEST(StiffSteps, AreKnownToARestoredRun) {
  const StiffScene scene = slide_in_a_formula();
  Simulation straight(scene.system), restored(scene.system);
  ASSERT_TRUE(straight.advance_to(0.5).ok());
  ASSERT_EQ(straight.report().method, Method::Radau5);

  restored.restore(straight.save());
  EXPECT_EQ(restored.report().method, Method::Radau5);
  EXPECT_EQ(restored.report().method_reason, straight.report().method_reason);
  ASSERT_TRUE(restored.advance_to(1.0).ok());
  ASSERT_TRUE(straight.advance_to(1.0).ok());

  EXPECT_NEAR(restored.positions()[1], straight.positions()[1], 1e-9);
}

/// Light points vibrate with the root of the mass ratio, and these motions are such vibrations, which the steps follow.
/// At 1e12 there are 7e5 and 3e6 steps (docs/methods.md).
TEST(MassRatios, BillionToOneRunsToTheEnd) {
  for (const auto& [scene, most_steps] :
       {std::pair{extreme::drop_heavy_tip(1e9), 40'000U}, std::pair{extreme::drop_alternating(1e9), 150'000U}}) {
    SCOPED_TRACE(scene.name);
    Simulation simulation(scene.system, {.method = Method::Taylor, .rtol = 1e-8, .atol = 1e-10});

    ASSERT_TRUE(simulation.advance_to(scene.t_end).ok()) << simulation.outcome().what;

    EXPECT_LT(simulation.report().steps, most_steps);
    EXPECT_LE(simulation.report().violation.position, 1e-12);
    EXPECT_LE(std::abs(simulation.report().energy.drift_relative()), 1e-11);
  }
}

/// The cost is counted in solves, and a factor of a path of rods counts as two. A second factor in a step costs less
/// than the iterations that it saves, and the lower order of loose tolerances saves more than both.
TEST(LooseTolerances, CostNoMoreThanTightOnes) {
  double before = 0.0;
  for (const double rtol : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-10}) {
    Simulation simulation(scenes::make_chain(20), {.method = Method::Taylor, .rtol = rtol, .atol = 1e-2 * rtol});
    ASSERT_TRUE(simulation.advance_to(2.0).ok());
    const Counters& counters = simulation.report().counters;
    const auto cost = static_cast<double>(counters.solves + 2 * counters.factorizations);
    EXPECT_GT(cost, 0.97 * before) << rtol;
    before = cost;
  }
}

/// Two points near the minimum of a stiff pair force have a damper between them. Newton's matrix knows the damper
/// alone, so that implicit steps win nothing.
TEST(StiffStepsTest, PairForcesThatAreStiffKeepExplicitSteps) {
  System system;
  system.positions = {0, 0, 0, std::pow(2.0, 1.0 / 6.0) + 1e-3, 0, 0};
  system.velocities = {1, 0, 0, 1, 0, 0};
  system.masses = {1, 1};
  system.forces = {PairForces{.name = "pair", .law = PairLaw::Lj, .epsilon = 1e6, .cutoff = 2.5},
                   Springs{.name = "damper", .pairs = {{0, 1}}, .stiffness = 0.0, .damping = 1e3}};
  Simulation by_auto(system), by_stages(system, {.method = Method::Dop853});

  ASSERT_TRUE(by_auto.advance_to(1.0).ok());
  ASSERT_TRUE(by_stages.advance_to(1.0).ok());

  EXPECT_LE(by_auto.report().steps + by_auto.report().rejected,
            1.2 * static_cast<double>(by_stages.report().steps + by_stages.report().rejected))
      << name_of(by_auto.report().method);
}

}  // namespace
}  // namespace tanor
