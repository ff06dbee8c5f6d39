#pragma once

#include <cstddef>

#include <tanor/motion.hpp>

namespace tanor::cli {

/// Rough cost of one step, before any number was computed.
struct StepCost {
  int solves = 0;        ///< of S, each with its evaluation
  double seconds = 0.0;  ///< one thread of a 2.5 GHz machine, within a factor of 2
  double bytes = 0.0;    ///< of the matrices and the state
};

StepCost predict_step(const PlanSummary& plan, std::size_t num_points, Method method);

}  // namespace tanor::cli
