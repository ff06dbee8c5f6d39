#include <gtest/gtest.h>

#include <memory>

#include "allocation/counting_allocator.hpp"
#include "allocation/steady_steps.hpp"
#include "motion/extreme_scenes.hpp"
#include "motion/toys.hpp"

namespace tanor {
namespace {

class StepWithEventsTest : public testing::TestWithParam<Method> {};

/// A block slides to and fro without friction. Its event function is evaluated in every step, and also inside the first
/// step after each turn. Only the turns themselves copy the discrete state.
TEST_P(StepWithEventsTest, AllocatesOnlyWhereEquationsAreSwitched) {
  toys::Block block(4.0, 0.0, 0.0, 0.0);
  toys::Travel travel(block, GetParam(), {.step = 0.01, .rtol = 1e-8, .atol = 1e-10}, {1.0}, {0.0});
  block.direction = -1;
  travel.place(block, 0.0, {1.0}, {0.0});
  std::size_t turns = 0, steps = 0, allocations = 0;
  block.switch_times.reserve(100);

  const Outcome outcome = travel.advance(
      20.0, [&, events = std::size_t{0}, before = allocation::AllocationCounter()](const MotionReport& report) mutable {
        const std::size_t now = before.count();
        if (report.events == events && report.steps > 1) {
          allocations += now;
          ++steps;
        }
        turns += report.events - events;
        events = report.events;
        before = {};
        return true;
      });

  EXPECT_TRUE(outcome.ok()) << outcome.what;
  EXPECT_EQ(turns, 12u);
  EXPECT_GT(steps, 100u);
  EXPECT_EQ(allocations, 0u);
}

class StepPastSingularConfigurationsTest : public testing::TestWithParam<Method> {};

/// A second run extrapolates past singular configurations, compares K and narrows down where K lost rank, all of it in
/// the memory that it has after the first passage.
TEST_P(StepPastSingularConfigurationsTest, AllocatesNothing) {
  const extreme::Case scene = extreme::turn_four_bar(0.5, 20.0, "");
  MotionOptions options{.method = GetParam(), .rtol = 1e-8, .atol = 1e-10};
  if (has_fixed_steps(options.method)) options.step = 1e-2;
  Simulation simulation(scene.system, options, {.threads = 1});
  const std::vector<std::byte> start = simulation.save();
  ASSERT_TRUE(simulation.advance_to(scene.t_end).ok()) << simulation.outcome().what;
  simulation.restore(start);
  std::size_t allocations = 0;
  std::unique_ptr<allocation::AllocationCounter> counter;

  const Outcome outcome = simulation.advance_to(scene.t_end, [&](const MotionReport& report) {
    if (counter == nullptr && report.singular_passages.count == 1)
      counter = std::make_unique<allocation::AllocationCounter>();
    if (counter != nullptr) allocations = counter->count();
    return true;
  });

  EXPECT_TRUE(outcome.ok()) << outcome.what;
  EXPECT_EQ(simulation.report().singular_passages.count, 7u);
  EXPECT_EQ(allocations, 0u);
}

class StepWithObservablesTest : public testing::TestWithParam<Method> {};

/// The tensions of all rods, their largest, a load and a place are looked at after every step, in memory that stays.
TEST_P(StepWithObservablesTest, AllocatesNothing) {
  MotionOptions options{.method = GetParam(), .rtol = 1e-8, .atol = 1e-10};
  if (has_fixed_steps(options.method)) options.step = 1e-3;
  Simulation simulation(scenes::make_chain(50), options, {.threads = 1});
  for (const char* text : {"each tension(rods)", "max tension(rods)", "load(anchor)", "position(7).z"})
    simulation.add_observable({.text = text, .every_step = true});

  EXPECT_EQ(allocation::count_in_steady_steps(&simulation), 0u);
}

INSTANTIATE_TEST_SUITE_P(Methods, StepWithObservablesTest,
                         testing::Values(Method::Rk4, Method::Dopri5, Method::Taylor, Method::Rattle),
                         [](const auto& instance) { return std::string(name_of(instance.param)); });

// The sample leaves out the compositions, which take steps of `rattle`, and the implicit methods.
INSTANTIATE_TEST_SUITE_P(Methods, StepPastSingularConfigurationsTest,
                         testing::Values(Method::Rk4, Method::Dopri5, Method::Dop853, Method::Taylor, Method::Rattle),
                         [](const auto& instance) { return std::string(name_of(instance.param)); });

INSTANTIATE_TEST_SUITE_P(Methods, StepWithEventsTest, testing::ValuesIn(sampled_methods),
                         [](const auto& instance) { return std::string(name_of(instance.param)); });

}  // namespace
}  // namespace tanor
