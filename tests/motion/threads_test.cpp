#include <array>
#include <ostream>

#include <gtest/gtest.h>

#include "base/checksum.hpp"
#include "long_tests.hpp"
#include "scenes.hpp"

namespace tanor {
using namespace detail;
namespace {

struct BigScene {
  std::string name;
  System (*build)();
  const char* factorization;
  std::vector<Method> methods;
  std::size_t steps = 20;
  Form form = Form::Auto;

  friend std::ostream& operator<<(std::ostream& out, const BigScene& scene) { return out << scene.name; }
};

/// Returns true for all explicit methods but dop853, which runs the loops of dopri5 and takes more stages in each step.
bool is_explicit(const MethodTraits& method) {
  return !method.is_implicit && method.method != Method::Dop853;
}

const std::vector<Method> explicit_ones = list_methods_that(is_explicit);
const std::vector<Method> without_series = list_methods_that(
    [](const MethodTraits& method) { return is_explicit(method) && method.method != Method::Taylor; });
const std::vector<Method> implicit_ones = list_methods_that(&MethodTraits::is_implicit);
const std::vector<Method> in_coordinates = list_methods_that(&MethodTraits::steps_in_coordinates);

/// Makes beads whose guides are coordinates, without friction.
System make_beads_in_coordinates() {
  System system = scenes::make_beads(1'500);
  for (const Constraint& constraint : system.constraints) {
    if (const auto* circles = std::get_if<Circles>(&constraint))
      system.coordinates.push_back(
          CircleCoordinates{"", circles->points, circles->center, circles->normal, circles->radius});
    if (const auto* spheres = std::get_if<Spheres>(&constraint))
      system.coordinates.push_back(SphereCoordinates{"", spheres->points, spheres->center, spheres->radius});
    if (const auto* planes = std::get_if<Planes>(&constraint))
      system.coordinates.push_back(PlaneCoordinates{"", planes->points, planes->normal, planes->offset});
    if (const auto* lines = std::get_if<Lines>(&constraint))
      system.coordinates.push_back(LineCoordinates{"", lines->points, lines->origin, lines->direction});
  }
  system.constraints.clear();
  return system;
}

// The scenes are big enough for loops in several ranges.
const BigScene big_scenes[]{
    {"chain_of_20000", [] { return scenes::make_chain(20'000); }, "paths", explicit_ones},
    {"net_60x60", [] { return scenes::make_net(60, 60); }, "multifrontal", explicit_ones},
    {"ladder_2x3000", [] { return scenes::make_net(2, 3'000); }, "simplicial", explicit_ones},
    {"clusters_of_200", [] { return scenes::make_clusters(200); }, "batches", explicit_ones},
    {"lattice_11x11x11", [] { return scenes::make_lattice(11); }, "multifrontal", explicit_ones},
    {"melt_of_8000", [] { return scenes::make_melt(20); }, "batches", without_series},
    {"beads_of_6000", [] { return scenes::make_beads(1'500); }, "closed_form", explicit_ones},
    {"damped_chain_of_2500", [] { return scenes::make_damped_chain(2'500); }, "paths", implicit_ones, 5},
    {"implicit_beads", [] { return scenes::make_beads(800); }, "closed_form", implicit_ones, 5},
    {"rough_beads", [] { return scenes::make_rough_beads(1'500); }, "simplicial", without_series, 5},
    {"beads_in_coordinates", make_beads_in_coordinates, "closed_form+simplicial", in_coordinates, 20, Form::Tangent},
};

struct BigRun {
  BigScene scene;
  Method method;

  friend std::ostream& operator<<(std::ostream& out, const BigRun& run) {
    return out << run.scene << " by " << name_of(run.method);
  }
};

class ThreadsTest : public testing::TestWithParam<BigRun> {
 protected:
  /// Returns a checksum of all that some steps leave behind.
  static std::uint64_t hash_steps(int threads) {
    const auto& [scene, method] = GetParam();
    MotionOptions options{.method = method, .rtol = 1e-6, .atol = 1e-8, .start = StartMode::Project};
    if (has_fixed_steps(method)) options.step = 1e-3;
    if (method == Method::Taylor) options.order = 6;  // which takes more steps
    Simulation simulation(scene.build(), options, {.form = scene.form, .threads = threads});
    EXPECT_EQ(simulation.plan().factorization(), scene.factorization);

    const std::size_t steps = tests_are_long() ? scene.steps : (scene.steps + 3) / 4 + 1;
    const Outcome outcome = simulation.advance_to(1.0, scenes::stop_after(steps));

    EXPECT_TRUE(outcome.ok()) << outcome.what;
    EXPECT_EQ(simulation.report().steps, steps);
    const EnergyReport& energy = simulation.report().energy;
    const std::array numbers{simulation.time(), energy.now, energy.work_of_forces, energy.work_of_friction};
    Checksum sum;
    for (const auto& array : {std::span<const double>(numbers), simulation.positions(), simulation.velocities(),
                              simulation.accelerations(), simulation.multipliers(), simulation.reactions()})
      sum.add(array);
    return sum.value();
  }
};

TEST_P(ThreadsTest, AnyNumberOfThreadsGivesTheSameBits) {
  const std::uint64_t one = hash_steps(1);

  EXPECT_EQ(hash_steps(2), one);
  EXPECT_EQ(hash_steps(3), one);
}

std::vector<BigRun> list_runs() {
  std::vector<BigRun> runs;
  for (const BigScene& scene : big_scenes) {
    for (const Method method : scene.methods) runs.push_back({scene, method});
  }
  return runs;
}

INSTANTIATE_TEST_SUITE_P(BigScenes, ThreadsTest, testing::ValuesIn(list_runs()), [](const auto& instance) {
  return instance.param.scene.name + "_" + std::string(name_of(instance.param.method));
});

}  // namespace
}  // namespace tanor
