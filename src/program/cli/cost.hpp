#pragma once

#include <cstddef>

#include <tanor/motion.hpp>

namespace tanor::cli {

/// The facts about a run that are known before any number is computed.
struct PlannedRun {
  const PlanSummary& plan;
  std::size_t num_points;
  bool is_certified;  ///< by a second factorization at the end
  MotionOptions motion;
};

/// Predicted cost of a run and of each of its steps by a method, within a factor of 2 (see cost.cpp).
struct RunCost {
  double solves = 0.0;          ///< S lambda = b, a step
  double factorizations = 0.0;  ///< of S, a step
  double seconds = 0.0;         ///< time of a step on one thread of a 2.6 GHz machine
  double bytes = 0.0;           ///< largest resident memory of the program
};

RunCost predict_run(const PlannedRun& run, Method method);

}  // namespace tanor::cli
