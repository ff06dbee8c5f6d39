#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <memory>

#include <tanor/motion.hpp>

#include "motion/allocation/counting_allocator.hpp"

namespace tanor::allocation {

/// Allocations in 20 steps of a simulation, after 3 to warm up; one more follows, so that the count falls between two.
inline std::size_t count_in_steady_steps(Simulation* simulation) {
  std::size_t count = 0;
  std::unique_ptr<AllocationCounter> counter;
  const Outcome outcome = simulation->advance(1.0, [&](const MotionReport& report) {
    if (report.steps == 3) counter = std::make_unique<AllocationCounter>();
    if (report.steps == 23) count = counter->count();
    return report.steps < 24;
  });
  EXPECT_TRUE(outcome.ok()) << outcome.what;
  EXPECT_EQ(simulation->report().steps, 24u);
  return count;
}

}  // namespace tanor::allocation
