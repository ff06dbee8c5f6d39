#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <memory>
#include <ostream>
#include <string>
#include <tuple>

#include <tanor/motion.hpp>

#include "allocation/counting_allocator.hpp"
#include "beside.hpp"
#include "scenes.hpp"

namespace tanor::allocation {

/// A scene and its name in lists of tests.
struct Scene {
  std::string name;
  System (*build)();

  friend std::ostream& operator<<(std::ostream& out, const Scene& scene) { return out << scene.name; }
};

/// A scene, a method and a number of threads.
using Steps = std::tuple<Scene, Method, int>;

inline std::string name_steps(const testing::TestParamInfo<Steps>& instance) {
  const auto& [scene, method, threads] = instance.param;
  return scene.name + "_" + std::string(name_of(method)) + "_" + std::to_string(threads);
}

/// Joins a net, clusters and `others` in one system whose islands take different solvers, one with sparse factors.
inline System make_mixture(const System& others) {
  System system = scenes::make_net(8, 8);
  put_beside(scenes::make_clusters(50), &system);
  put_beside(others, &system);
  return system;
}

/// Counts allocations in 20 steps after 3 of warm-up. One more step follows, so that the count ends between steps.
inline std::size_t count_in_steady_steps(Simulation* simulation) {
  std::size_t count = 0;
  std::unique_ptr<AllocationCounter> counter;
  const Outcome outcome = simulation->advance_to(1.0, [&](const MotionReport& report) {
    if (report.steps == 3) counter = std::make_unique<AllocationCounter>();
    if (report.steps == 23) count = counter->count();
    return report.steps < 24;
  });
  EXPECT_TRUE(outcome.ok()) << outcome.what;
  EXPECT_EQ(simulation->report().steps, 24u);
  return count;
}

}  // namespace tanor::allocation
