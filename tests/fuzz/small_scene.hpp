#pragma once

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <span>

#include <tanor/motion.hpp>

namespace tanor::fuzz {

/// Returns true if a few steps of the system take no time. (Members of constraints count with the tuples of formulas.)
inline bool is_small(const System& system) {
  return system.num_points() <= 64 && system.constraints.size() <= 16 && system.forces.size() <= 16 &&
         system.friction.size() <= 4 && system.coordinates.size() <= 4;
}

inline void require_finite(std::span<const double> numbers, const char* what) {
  for (const double number : numbers) {
    if (std::isfinite(number)) continue;
    std::fprintf(stderr, "%s are not finite though all went well\n", what);
    std::abort();
  }
}

/// Takes two steps towards t_end and returns true if they succeed. Numbers that are given as good have no NaN.
inline bool advance_few_steps(Simulation* simulation, double t_end) {
  if (!simulation->outcome().ok() || !(simulation->time() < t_end)) return false;
  const std::size_t last = simulation->report().steps + 2;
  const Outcome outcome =
      simulation->advance_to(t_end, [&](const MotionReport& report) { return report.steps < last; });
  if (!outcome.ok()) return false;
  require_finite(simulation->positions(), "positions");
  require_finite(simulation->velocities(), "velocities");
  require_finite(simulation->accelerations(), "accelerations");
  return true;
}

}  // namespace tanor::fuzz
