#include <cmath>
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "rough_scenes.hpp"
#include "scenes.hpp"

/// \file A run that was restored from a snapshot goes on bit by bit as the one that was never interrupted, with every
/// method, with and without friction, in either form.
namespace tanor {
namespace {

struct Interruption {
  std::string scene;
  std::function<System()> make;
  MotionOptions options;
  SolverOptions solver{};
  double middle = 0.3, end = 0.7;  // s
};

void PrintTo(const Interruption& each, std::ostream* out) {
  *out << each.scene << " by " << name_of(each.options.method);
}

/// Makes a rough wire that turns, with beads, one of which a shaking force moves now and then.
System make_rough_wire() {
  System system;
  for (int k = 0; k < 3; ++k) scenes::add_point({0.3 + 0.1 * k, 0, 0}, &system);
  const VectorFunction turning{ScalarFunction::formula("cos(t/2)"), ScalarFunction::formula("sin(t/2)"), 0.0};
  for (std::size_t k = 0; k < 3; ++k) system.velocities[3 * k + 1] = 0.5 * system.positions[3 * k];
  system.constraints = {Lines{"wire", {0, 1, 2}, Vector3{}, turning}};
  system.forces = {scenes::gravity, ConstantForce{"drive", {1}, {ScalarFunction::formula("0.9*sin(9*t)"), 0.0, 0.0}}};
  system.friction = {Coulomb{"rust", {"wire"}, 0.4, 0.5}};
  return system;
}

/// Makes a parallelogram with a redundant middle crank.
System make_redundant_cranks() {
  System system = scenes::make_cranks({0.0, 0.5, 1.0}, std::atan2(0.8, 0.6), 1.0);
  system.forces = {Gravity{"gravity", {0, -9.81, 0}}};
  return system;
}

/// Makes chains that move at speeds from 0.01 to 1 m/s, so that their power series have different numbers of terms.
System make_chains_of_all_speeds() {
  System system;
  Rods rods{.length = 0.1};
  for (int chain = 0; chain < 12; ++chain) {
    for (int i = 0; i < 20; ++i) {
      const auto point = scenes::add_point({0.1 * i, 1.0 * chain, 0}, &system);
      if (i > 0) rods.pairs.push_back({point - 1, point});
      const double speed = std::pow(10.0, -chain / 6.0);
      system.velocities[system.velocities.size() - 2] = speed * std::sin(0.4 * i);
      system.velocities.back() = speed * std::cos(0.9 * i);
    }
  }
  system.constraints = {rods};
  system.forces = {scenes::gravity};
  return system;
}

/// Returns all numbers of a state and what the report says of the way there.
std::vector<double> bits(const Simulation& simulation) {
  std::vector<double> all{simulation.time()};
  for (const auto& array :
       {simulation.positions(), simulation.velocities(), simulation.accelerations(), simulation.multipliers(),
        simulation.reactions(), simulation.support_forces(), simulation.coordinates(), simulation.coordinate_rates()})
    all.insert(all.end(), array.begin(), array.end());
  const MotionReport& report = simulation.report();
  all.insert(all.end(), {static_cast<double>(report.steps), static_cast<double>(report.rejected),
                         static_cast<double>(report.events), report.last_event, report.last_step, report.energy.now,
                         report.energy.work_of_supports, report.energy.work_of_forces, report.energy.work_of_friction});
  return all;
}

void expect_same(const Simulation& found, const Simulation& expected, const std::string& where) {
  const std::vector<double> a = bits(found), b = bits(expected);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k)
    EXPECT_EQ(a[k], b[k]) << "number " << k << " of " << a.size() << ", " << where;
}

class GoingOnTest : public testing::TestWithParam<Interruption> {};

TEST_P(GoingOnTest, GoesOnBitByBitFromASnapshot) {
  const auto& [scene, make, options, solver, middle, end] = GetParam();
  Simulation whole(make(), options, solver), first(make(), options, solver), second(make(), options, solver);
  ASSERT_TRUE(whole.advance_to(middle).ok()) << whole.outcome().what;
  ASSERT_TRUE(first.advance_to(middle).ok());

  second.restore(first.save());

  ASSERT_TRUE(second.outcome().ok()) << second.outcome().what;
  expect_same(second, whole, "where it was restored");
  ASSERT_TRUE(whole.advance_to(end).ok()) << whole.outcome().what;
  ASSERT_TRUE(second.advance_to(end).ok()) << second.outcome().what;
  expect_same(second, whole, "at the end");
  EXPECT_GT(whole.report().steps, 2u);
}

TEST_P(GoingOnTest, GoesOnBitByBitFromASnapshotThatAnObserverTook) {
  const auto& [scene, make, options, solver, middle, end] = GetParam();
  Simulation whole(make(), options, solver), second(make(), options, solver);
  for (const std::size_t step : {1u, 3u, 4u, 11u}) {
    Simulation first(make(), options, solver);
    std::vector<std::byte> saved;
    double time = 0.0;
    ASSERT_TRUE(first
                    .advance_to(end,
                                [&, left = step](const MotionReport&) mutable {
                                  if (--left == 0) saved = first.save(), time = first.time();
                                  return left > 0;
                                })
                    .ok());
    if (saved.empty()) continue;  // fewer steps lead to the end
    if (whole.time() == 0.0) {
      ASSERT_TRUE(whole.advance_to(end).ok());
    }
    if (time == end) continue;

    second.restore(saved);

    ASSERT_TRUE(second.advance_to(end).ok()) << second.outcome().what;
    expect_same(second, whole, "from step " + std::to_string(step));
  }
}

/// Returns the counts of work, which observers of a motion do not change.
std::vector<std::size_t> count_work(const Simulation& simulation) {
  const Counters& counters = simulation.report().counters;
  return {counters.evaluations,     counters.factorizations,     counters.solves,
          counters.iterations,      counters.rank_decisions,     counters.split_factorizations,
          counters.friction_solves, counters.friction_iterations};
}

TEST_P(GoingOnTest, GoesOnBitByBitThoughAnObserverLooksAtTheSolution) {
  const auto& [scene, make, options, solver, middle, end] = GetParam();
  Simulation alone(make(), options, solver), watched(make(), options, solver);
  ASSERT_TRUE(alone.advance_to(end).ok());

  const Outcome outcome = watched.advance_to(end, [&](const MotionReport&) {
    EXPECT_TRUE(watched.solution().outcome.ok());
    (void)watched.certify();
    return true;
  });

  ASSERT_TRUE(outcome.ok()) << outcome.what;
  expect_same(watched, alone, "at the end");
  EXPECT_EQ(count_work(watched), count_work(alone));
}

/// Returns the step of a method with fixed steps, s. The compositions divide theirs into 5 and 9.
double step_of(Method method) {
  if (!has_fixed_steps(method)) return 0.0;
  return method == Method::Rattle4 ? 0.01 : method == Method::Rattle6 ? 0.02 : 0.003;
}

std::vector<Interruption> list_cases() {
  std::vector<Interruption> cases;
  for (const MethodTraits& traits : methods()) {
    const MotionOptions options{.method = traits.method, .step = step_of(traits.method)};
    cases.push_back({"chain", [] { return scenes::make_shaken_chain_in_air(0.3); }, options});
    cases.push_back({"breathing_chain", [] { return scenes::make_breathing_chain(); }, options});
    cases.push_back({"beads", [] { return scenes::make_beads(2); }, options});
    cases.push_back({"four_bar", [] { return scenes::make_four_bar(-0.7, 1.0); }, options, {}, 0.69, 1.0});
    cases.push_back({"redundant_cranks", make_redundant_cranks, options});
    cases.push_back({"net", [] { return scenes::make_net(6, 7); }, options, {}, 0.1, 0.2});
    cases.push_back({"chains", make_chains_of_all_speeds, options, {}, 0.05, 0.1});
    cases.back().options.start = StartMode::Project;
    if (traits.serves_friction) {
      cases.push_back({"rough_beads", [] { return scenes::make_rough_beads(2); }, options});
      cases.push_back({"rough_wire", make_rough_wire, options});
    }
    if (traits.steps_in_coordinates) {
      cases.push_back({"coordinates", [] { return scenes::make_coordinates(); }, options});
      cases.back().options.start = StartMode::Project;
      cases.push_back({"rough_hoop", scenes::make_bead_by_its_angle, options, {.form = Form::Tangent}});
    }
  }
  return cases;
}

INSTANTIATE_TEST_SUITE_P(Cases, GoingOnTest, testing::ValuesIn(list_cases()), [](const auto& instance) {
  return instance.param.scene + "_" + std::string(name_of(instance.param.options.method));
});

}  // namespace
}  // namespace tanor
