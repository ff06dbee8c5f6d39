#include <gtest/gtest.h>

#include "allocation/steady_steps.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

/// Steps take no memory as long as the pivots of the first factorizations serve.
TEST(ImplicitStepTest, AllocatesNothing) {
  for (const Method method : list_methods_that(&MethodTraits::is_implicit)) {
    MotionOptions options{.method = method, .rtol = 1e-6, .atol = 1e-8, .start = StartMode::Project};
    if (has_fixed_steps(method)) options.step = 1e-3;
    Simulation simulation(scenes::make_damped_chain(100), options, {.threads = 1});

    EXPECT_EQ(allocation::count_in_steady_steps(&simulation), 0u) << name_of(method);
  }
}

}  // namespace
}  // namespace tanor
