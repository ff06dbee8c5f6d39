#include <gtest/gtest.h>

#include "motion/allocation/counting_allocator.hpp"
#include "motion/toys.hpp"

namespace tanor {
namespace {

class StepWithEventsTest : public testing::TestWithParam<Method> {};

/// Sliding to and fro without friction: its function is looked at in every step, and inside the first one after each
/// turn. The turns themselves take a copy of the discrete state.
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

INSTANTIATE_TEST_SUITE_P(Methods, StepWithEventsTest, testing::Values(Method::Rk4, Method::Dopri5, Method::Rattle),
                         [](const auto& instance) { return std::string(method_name(instance.param)); });

}  // namespace
}  // namespace tanor
