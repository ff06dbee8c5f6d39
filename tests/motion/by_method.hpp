#pragma once

#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <tanor/motion.hpp>

#include "scenes.hpp"

namespace tanor {

/// Runs motions that each of some methods reproduces to eight digits.
class MotionByMethod : public testing::TestWithParam<Method> {
 protected:
  Simulation run(System system, double t_end) const {
    Simulation simulation(std::move(system), {.method = GetParam(), .rtol = 1e-11, .atol = 1e-12});
    const Outcome outcome = simulation.advance_to(t_end);
    EXPECT_TRUE(outcome.ok()) << outcome.what;
    return simulation;
  }
};

/// A method by series, which runs on the definitions of kinds, and one by their kernels.
inline const auto series_and_kernels = testing::Values(Method::Taylor, Method::Dop853);

inline std::string name_method(const testing::TestParamInfo<Method>& method) {
  return std::string(name_of(method.param));
}

}  // namespace tanor
