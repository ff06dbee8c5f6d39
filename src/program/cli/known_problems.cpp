#include "cli/known_problems.hpp"

#include <algorithm>
#include <cmath>

namespace tanor::cli {

Index add_point(const Vector3& place, const Vector3& velocity, double mass, System* system) {
  system->positions.insert(system->positions.end(), place.begin(), place.end());
  system->velocities.insert(system->velocities.end(), velocity.begin(), velocity.end());
  system->masses.push_back(mass);
  return static_cast<Index>(system->masses.size() - 1);
}

MotionOptions tightly(Method method) {
  return {.method = method, .rtol = 1e-13, .atol = 1e-14};
}

double relative_error(std::span<const double> found, std::span<const double> known) {
  double difference = 0.0, size = 0.0;
  for (std::size_t i = 0; i < known.size(); ++i) {
    // max(x, NaN) would be x.
    if (!std::isfinite(found[i])) return HUGE_VAL;
    difference = std::max(difference, std::abs(found[i] - known[i]));
    size = std::max(size, std::abs(known[i]));
  }
  return difference / size;
}

Finding follow(const System& system, const MotionOptions& options, double t_end, Index first_point,
               const std::vector<double>& known) {
  Simulation simulation(system, options, {.threads = 1});
  const Outcome outcome = simulation.advance_to(t_end);
  const auto found = simulation.positions().subspan(3 * static_cast<std::size_t>(first_point), known.size());
  return {relative_error(found, known), outcome};
}

Answer solve_start(const System& system) {
  Dynamics dynamics(system, {.threads = 1});
  Answer answer{std::vector<double>(system.positions.size()), std::vector<double>(num_equations(system)), {}};
  answer.outcome = dynamics
                       .solve({.time = 0.0, .positions = system.positions, .velocities = system.velocities},
                              {.accelerations = answer.accelerations, .multipliers = answer.multipliers})
                       .outcome;
  return answer;
}

}  // namespace tanor::cli
