#include <gtest/gtest.h>

#include "motion/scenes.hpp"

namespace tanor {
namespace {

TEST(MethodTest, ThoseWithFixedStepsAskForAStep) {
  for (const Method method : {Method::Auto, Method::Rk4, Method::Dopri5, Method::Dop853, Method::Taylor, Method::Rattle,
                              Method::Rattle4, Method::Rattle6, Method::Radau5, Method::GeneralizedAlpha}) {
    bool asks = false;
    try {
      Simulation(scenes::make_chain(2), {.method = method});
    } catch (const InputError& error) {
      asks = error.where() == "/motion/step";
    }
    EXPECT_EQ(has_fixed_steps(method), asks) << method_name(method);
  }
}

}  // namespace
}  // namespace tanor
