#pragma once

#include <cstddef>

#include <tanor/motion.hpp>

namespace tanor::cli {

/// What is known about a run before any number was computed.
struct PlannedRun {
  const PlanSummary& plan;
  std::size_t num_points;
  bool is_certified;  ///< at the end, by a second factorization
  MotionOptions motion;
};

/// Cost of a run and of each of its steps by a method, as counted and measured (see cost.cpp), within a factor of 2.
struct RunCost {
  double solves = 0.0;          ///< S lambda = b, a step
  double factorizations = 0.0;  ///< of S, a step
  double seconds = 0.0;         ///< of a step, one thread of a 2.6 GHz machine
  double bytes = 0.0;           ///< largest resident memory of the program
};

RunCost predict_run(const PlannedRun& run, Method method);

}  // namespace tanor::cli
