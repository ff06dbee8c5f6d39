/// A motion in whose middle a step of any other method is tried aside, for nothing, goes on bit by bit as the motion
/// without it. This holds whatever depends on time.

#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "dynamics/forms.hpp"
#include "motion/aside.hpp"
#include "motion/integration.hpp"
#include "rough_scenes.hpp"
#include "scenes.hpp"

namespace tanor {
using namespace detail;
namespace {

struct AsideScene {
  std::string name;
  System system;
  SolverOptions solver{};
};

void PrintTo(const AsideScene& scene, std::ostream* out) {
  *out << scene.name;
}

/// Returns a chain whose support follows a table.
System make_chain_on_a_table() {
  System system = scenes::make_chain(4);
  system.supports[0].displacement = {ScalarFunction::table({0.0, 0.04, 0.1, 0.2, 0.5, 9.0}, {0, 0.01, 0, 0.03, 0, 1}),
                                     0.0, ScalarFunction::formula("0.02*sin(30*t)")};
  return system;
}

/// Returns beads on a wire that turns, whose unit vectors jump once in a quarter turn, and on a plane that rises.
System make_beads_on_moving_guides(bool is_rough) {
  System system;
  for (int k = 0; k < 3; ++k) scenes::add_point({0.3 + 0.1 * k, 0, 0}, &system);
  scenes::add_point({0, 1, 0}, &system);
  for (std::size_t k = 0; k < 3; ++k) system.velocities[3 * k + 1] = 3.0 * system.positions[3 * k];
  system.velocities[11] = 0.2;
  const VectorFunction turning{ScalarFunction::formula("cos(3*t)"), ScalarFunction::formula("sin(3*t)"), 0.0};
  system.constraints = {Lines{"wire", {0, 1, 2}, Vector3{}, turning},
                        Planes{"lift", {3}, Vector3{0, 0, 1}, ScalarFunction::formula("0.1*sin(2*t)")}};
  system.forces = {scenes::gravity, ConstantForce{"drive", {1}, {ScalarFunction::formula("3*sin(9*t)"), 0.0, 0.0}},
                   Springs{"spring", {{0, 3}}, 5.0, 0.1, {}}};
  if (is_rough) system.friction = {Coulomb{"rust", {"wire"}, 0.9, 1.1}, Viscous{"oil", {"lift"}, 0.3}};
  return system;
}

/// Returns a chain that a formula of time and place pulls, under a load that a table gives, in oil.
System make_chain_under_forces_of_time() {
  System system = scenes::make_driven_chain(3);
  system.forces.push_back(FormulaForce{"wind", {2}, formula_force({"sin(20*t)*x", "0.1*cos(t)", "-0.2*vz"})});
  system.forces.push_back(
      ConstantForce{"load", {1}, {0.0, ScalarFunction::table({0.0, 0.1, 0.3, 9.0}, {0.0, 0.2, -0.1, 0.0}), 0.0}});
  return system;
}

/// Returns a wide net, whose stages are solved with the factor of the step's beginning.
System make_wide_net() {
  System system = scenes::make_net(24, 24);
  system.supports[0].displacement = {0.0, 0.0, ScalarFunction::formula("0.01*sin(9*t)")};
  return system;
}

/// Returns molecules that leave their lists of neighbours soon.
System make_fast_molecules() {
  System system = scenes::make_shaken_grid({3, 3, 3}, 1.2, 5);
  system.velocities.resize(system.positions.size());
  scenes::set_random_velocities(4.0, 9, &system);
  system.forces = {PairForces{.name = "lj", .law = PairLaw::Lj, .epsilon = 1.0, .cutoff = 2.0}};
  system.constraints = {Rods{"bond", {{0, 1}}, ScalarFunction::formula("1.1 + 0.1*sin(t)"), {}}};
  system.positions[3] = system.positions[0];
  system.positions[4] = system.positions[1];
  system.positions[5] = system.positions[2] + 1.1;
  return system;
}

/// Returns a parallelogram with a redundant middle crank, whose pivots shake.
System make_shaken_cranks() {
  System system = scenes::make_cranks({0.0, 0.5, 1.0}, std::atan2(0.8, 0.6), 1.0);
  system.supports[0].displacement = {0.0, ScalarFunction::formula("0.01*sin(20*t)^2"), 0.0};
  system.forces = {Gravity{"gravity", {0, -9.81, 0}}};
  return system;
}

std::vector<AsideScene> list_aside_scenes() {
  return {{"support_by_a_formula", scenes::make_shaken_chain_in_air(0.3)},
          {"support_by_a_table", make_chain_on_a_table()},
          {"moving_guides", make_beads_on_moving_guides(false)},
          {"sticking_contacts", make_beads_on_moving_guides(true)},
          {"lengths_of_time", scenes::make_breathing_chain()},
          {"forces_of_time", make_chain_under_forces_of_time()},
          {"coordinates", scenes::make_coordinates()},
          {"coordinates_with_friction", scenes::make_bead_by_its_angle(), {.form = Form::Tangent}},
          {"neighbour_lists", make_fast_molecules()},
          {"reused_factors", make_wide_net()},
          {"multipliers_that_remain", make_shaken_cranks()},
          {"beads_that_stick_and_slide", scenes::make_rough_beads(1)}};
}

/// A motion inside the library, begun as a Simulation begins it.
class InnerMotion {
 public:
  InnerMotion(const AsideScene& scene, const IntegrationOptions& options)
      : forms_(scene.system, scene.solver), integration_(options.method, options, *forms_.main, &report_) {
    const Model& model = forms_.model;
    std::vector<double> r(3 * model.num_points()), v(r.size());
    model.numbering.gather_points(model.system.positions, r);
    if (!model.system.velocities.empty()) model.numbering.gather_points(model.system.velocities, v);
    State& state = integration_.state;
    EquationsOfMotion& form = *forms_.main;
    EXPECT_TRUE(forms_.start(0.0, r.data(), v.data(), StartMode::Project).outcome.ok());
    EXPECT_TRUE(form.set_state(0.0, r.data(), v.data(), state.x.data(), state.v.data()).ok());
    EXPECT_TRUE(form.begin(0.0, state.x.data(), state.v.data(), options.request(Gradients::Keep), state.output()).ok());
    integration_.next_step = options.step;
    integration_.begin();
  }

  EquationsOfMotion& form() { return *forms_.main; }
  const State& state() const { return integration_.state; }
  /// Makes some steps, after each of which it calls between().
  Outcome make_steps(int count, const std::function<void()>& between) {
    const auto taken = [this](const StepResult&) {
      State& state = integration_.state;
      form().recentre(state.t, state.x.data(), state.v.data(), state.a.data(), &state.reactions);
    };
    return integration_.advance(1.0, taken, [&](const MotionReport&) {
      between();
      return --count > 0;
    });
  }
  /// Returns all that the motion goes on from, and what it has counted.
  std::vector<double> numbers() {
    const State& s = integration_.state;
    std::vector<double> all{s.t,
                            s.power.supports,
                            s.work.supports,
                            s.work.friction,
                            integration_.next_step,
                            static_cast<double>(report_.rejected),
                            static_cast<double>(report_.events)};
    for (const auto* array : {&s.x, &s.v, &s.a, &s.reactions.lambda, &s.reactions.friction})
      all.insert(all.end(), array->begin(), array->end());
    Memory memory(&all);
    form().exchange_memory(memory);
    return all;
  }

 private:
  Forms forms_;
  MotionReport report_;
  Integration integration_;
};

IntegrationOptions options_of(Method method) {
  return MotionOptions{.method = method, .step = method == Method::Rattle6 ? 0.01 : 0.003, .rtol = 1e-7, .atol = 1e-9};
}

bool can_step(Method method, const AsideScene& scene) {
  try {
    const IntegrationOptions options = options_of(method);
    const Simulation simulation(scene.system, options, scene.solver);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

class AsideTest : public testing::TestWithParam<std::tuple<AsideScene, Method>> {};

TEST_P(AsideTest, AStepOfAnyOtherMethodLeavesNoTrace) {
  const auto& [scene, method] = GetParam();
  if (!can_step(method, scene)) return;
  const int few = scene.name == "reused_factors" ? 2 : 5;
  const IntegrationOptions options = options_of(method);
  InnerMotion alone(scene, options);
  std::vector<std::vector<double>> wanted;
  ASSERT_TRUE(alone.make_steps(few, [&] { wanted.push_back(alone.numbers()); }).ok());
  for (const MethodTraits& other : methods()) {
    if (other.method == Method::Auto || !can_step(other.method, scene)) continue;
    SCOPED_TRACE(std::string("with trials of ") + std::string(other.name));
    const IntegrationOptions of_other = options_of(other.method);
    InnerMotion tried(scene, options);
    std::vector<std::vector<double>> found;
    AsideMemory memory;
    const Outcome outcome = tried.make_steps(few, [&] {
      const std::vector<double> before = tried.numbers();
      const Outcome back = solve_aside(
          tried.form(), options, tried.state(),
          [&] {
            const std::unique_ptr<Scheme> scheme = make_scheme(other.method, of_other, tried.form());
            State to = tried.state();
            to.t += 20.0 * 0.003;
            (void)scheme->step(tried.state(), 20.0 * 0.003, &to);
          },
          &memory);
      EXPECT_TRUE(back.ok()) << back.what;
      EXPECT_EQ(tried.numbers(), before);
      found.push_back(before);
    });

    EXPECT_TRUE(outcome.ok()) << outcome.what;
    EXPECT_EQ(found, wanted);
  }
}

std::vector<Method> list_methods() {
  return list_methods_that([](const MethodTraits&) { return true; });
}

INSTANTIATE_TEST_SUITE_P(Scenes, AsideTest,
                         testing::Combine(testing::ValuesIn(list_aside_scenes()), testing::ValuesIn(list_methods())),
                         [](const auto& instance) {
                           return std::get<0>(instance.param).name + "_" +
                                  std::string(name_of(std::get<1>(instance.param)));
                         });

}  // namespace
}  // namespace tanor
