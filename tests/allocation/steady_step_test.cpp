#include <cstdlib>
#include <cstring>
#include <memory>

#include <gtest/gtest.h>

#include "allocation/steady_steps.hpp"
#include "beside.hpp"
#include "long_tests.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

using allocation::AllocationCounter;
using allocation::Scene;

const Scene steady_scenes[]{
    {"chain", [] { return scenes::make_chain(4'200); }},
    {"ring", [] { return scenes::make_ring(260); }},
    {"net", [] { return scenes::make_net(30, 30); }},
    {"lattice", [] { return scenes::make_lattice(6); }},
    {"clusters", [] { return scenes::make_clusters(50); }},
    {"beads", [] { return scenes::make_beads(1'100); }},
    {"mixture", [] { return allocation::make_mixture(scenes::make_beads(20)); }},
    {"damped_springs", [] { return scenes::make_damped_chain(100); }},
    {"shaken_support", [] { return scenes::make_shaken_chain(100); }},
    {"breathing_rods", [] { return scenes::make_breathing_chain(100); }},
    {"driven_bead", [] { return scenes::make_driven_chain(100); }},
};

/// Returns tolerances so tight, and an order so low, that the motion takes more than 24 steps.
MotionOptions make_options(Method method) {
  MotionOptions options{.method = method, .rtol = 1e-6, .atol = 1e-8, .start = StartMode::Project};
  if (has_fixed_steps(method)) options.step = 1e-3;
  if (method == Method::Taylor || method == Method::Dop853) options.rtol = options.atol = 1e-11;
  if (method == Method::Taylor) options.order = 6;
  return options;
}

class SteadyStepTest : public testing::TestWithParam<allocation::Steps> {};

TEST_P(SteadyStepTest, AllocatesNothing) {
  const auto& [scene, method, threads] = GetParam();
  Simulation simulation(scene.build(), make_options(method), {.threads = threads});

  EXPECT_EQ(allocation::count_in_steady_steps(&simulation), 0u);
}

/// A host that asks for every step takes no memory either.
TEST_P(SteadyStepTest, AllocatesNothingWhereEachIsAnAdvance) {
  const auto& [scene, method, threads] = GetParam();
  Simulation simulation(scene.build(), make_options(method), {.threads = threads});
  const auto advance = [&](int from, int to) {
    for (int k = from; k <= to; ++k) {
      if (!simulation.advance_to(1e-3 * k).ok()) return false;
    }
    return true;
  };
  ASSERT_TRUE(advance(1, 3));

  const AllocationCounter counter;
  const bool is_ok = advance(4, tests_are_long() ? 13 : 7);
  const std::size_t count = counter.count();

  EXPECT_TRUE(is_ok);
  EXPECT_EQ(count, 0u);
}

// The compositions take steps of `rattle` and run the scenes of the next list alone.
INSTANTIATE_TEST_SUITE_P(Scenes, SteadyStepTest,
                         testing::Combine(testing::ValuesIn(steady_scenes),
                                          testing::Values(Method::Rk4, Method::Dopri5, Method::Dop853, Method::Taylor,
                                                          Method::Rattle),
                                          testing::Values(1, 2)),
                         allocation::name_steps);
INSTANTIATE_TEST_SUITE_P(Compositions, SteadyStepTest,
                         testing::Combine(testing::Values(steady_scenes[0], steady_scenes[2], steady_scenes[5],
                                                          steady_scenes[8]),
                                          testing::Values(Method::Rattle4, Method::Rattle6), testing::Values(1, 2)),
                         allocation::name_steps);
// Method `taylor` is left out, since these forces have no series.
INSTANTIATE_TEST_SUITE_P(Pairs, SteadyStepTest,
                         testing::Combine(testing::Values(Scene{"melt", [] { return scenes::make_melt(12); }}),
                                          testing::Values(Method::Rk4, Method::Dopri5, Method::Dop853, Method::Rattle),
                                          testing::Values(1, 2)),
                         allocation::name_steps);
INSTANTIATE_TEST_SUITE_P(Coordinates, SteadyStepTest,
                         testing::Combine(testing::Values(Scene{"coordinates", scenes::make_coordinates}),
                                          testing::ValuesIn(list_methods_that(&MethodTraits::steps_in_coordinates)),
                                          testing::Values(1, 2)),
                         allocation::name_steps);

TEST(AllocationCounterTest, SeesMallocAndNew) {
  const AllocationCounter counter;

  void* volatile block = std::malloc(10);
  std::free(block);
  const std::unique_ptr<int> number = std::make_unique<int>(1);

  EXPECT_EQ(*number, 1);
  EXPECT_EQ(counter.count(), 2u);
}

TEST(AllocationCounterTest, SeesWhatLibrariesTake) {
  const AllocationCounter counter;

  char* volatile copy = strdup("taken by the C library");
  std::free(copy);

  EXPECT_EQ(counter.count(), 1u);
}

}  // namespace
}  // namespace tanor
