#include <gtest/gtest.h>

#include <memory>

#include "motion/allocation/counting_allocator.hpp"
#include "motion/scenes.hpp"

namespace tanor {
namespace {

using allocation::AllocationCounter;

/// As long as the pivots of the first factorizations serve.
TEST(ImplicitStepTest, AllocatesNothing) {
  for (const Method method : {Method::Radau5, Method::GeneralizedAlpha}) {
    MotionOptions options{.method = method, .rtol = 1e-6, .atol = 1e-8, .start = StartMode::Project};
    if (method == Method::GeneralizedAlpha) options.step = 1e-3;
    Simulation simulation(scenes::make_damped_chain(100), options, {.threads = 1});

    std::size_t count = 0;
    std::unique_ptr<AllocationCounter> counter;
    const Outcome outcome = simulation.advance(1.0, [&](const MotionReport& report) {
      if (report.steps == 3) counter = std::make_unique<AllocationCounter>();
      if (report.steps == 23) count = counter->count();
      return report.steps < 24;
    });

    EXPECT_TRUE(outcome.ok()) << outcome.what;
    EXPECT_EQ(count, 0u) << method_name(method);
  }
}

}  // namespace
}  // namespace tanor
