#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene/trajectory.hpp"

namespace tanor::scene {

/// Largest number of threads for "solver" and --threads; a larger one is a typing error.
constexpr int most_threads = 1024;

/// Values of the command line, which replace those of the file.
struct Overrides {
  std::optional<std::string> method;  ///< --method
  std::optional<double> step;         ///< --step, s, > 0
  std::optional<double> max_step;     ///< --max-step, s, > 0
  std::optional<double> rtol, atol;   ///< --rtol, --atol, > 0; with "auto" they choose an adaptive method
  std::optional<double> t_end;        ///< --t-end, s
  std::optional<int> threads;         ///< --threads, 0 (all) to most_threads
  std::optional<std::vector<TrajectoryFormat>> trajectory{};  ///< --trajectory
};

}  // namespace tanor::scene
