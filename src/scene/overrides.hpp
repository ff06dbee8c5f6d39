#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene/trajectory.hpp"

namespace tanor::scene {

/// More is a slip of the finger; the rule of "solver" and of --threads.
constexpr int most_threads = 1024;

/// What a command line says over the scene: values given here replace those of the file.
struct Overrides {
  std::optional<std::string> method;  ///< --method
  std::optional<double> step;         ///< --step, s, > 0
  std::optional<double> max_step;     ///< --max-step, s, > 0
  std::optional<double> rtol, atol;   ///< --rtol, --atol, > 0; with "auto" they choose an adaptive method
  std::optional<double> t_end;        ///< --t-end, s, > 0
  std::optional<int> threads;         ///< --threads, 0 (all) to most_threads
  std::optional<std::vector<TrajectoryFormat>> trajectory{};  ///< --trajectory
};

}  // namespace tanor::scene
