#include "simulation/stiffness.hpp"

#include <array>
#include <vector>

#include "base/vec3.hpp"

namespace tanor::detail {

namespace {

/// Calls visit(springs, number of the force) for each group of springs.
template <class Visit>
void for_each_springs(const System& system, const Visit& visit) {
  for (std::size_t n = 0; n < system.forces.size(); ++n) {
    if (const auto* springs = std::get_if<Springs>(&system.forces[n])) visit(*springs, n);
  }
}

double shortest_length(const System& system) {
  double result = std::numeric_limits<double>::infinity();
  const auto look_at = [&](const std::vector<std::array<Index, 2>>& pairs) {
    for (const auto& [i, j] : pairs) {
      const double length = norm(load(system.positions.data(), j) - load(system.positions.data(), i));
      if (length > 0.0) result = std::min(result, length);
    }
  };
  for_each_springs(system, [&](const Springs& springs, std::size_t) { look_at(springs.pairs); });
  for (const Constraint& constraint : system.constraints) {
    if (const auto* rods = std::get_if<Rods>(&constraint)) look_at(rods->pairs);
  }
  return result;
}

double largest_speed(const System& system) {
  double result = 0.0;
  for (std::size_t i = 0; 3 * i < system.velocities.size(); ++i)
    result = std::max(result, norm(load(system.velocities.data(), i)));
  return result;
}

}  // namespace

Stiffness measure_stiffness(const System& system) {
  // These are sums over the springs at a point, over its mass. No eigenvalue is larger than those of a spring's two
  // ends together.
  std::vector<double> stiffness(system.num_points(), 0.0), damping(stiffness);
  for_each_springs(system, [&](const Springs& springs, std::size_t) {
    for (const auto& [i, j] : springs.pairs) {
      for (const Index end : {i, j}) {
        stiffness[end] += springs.stiffness / system.masses[end];
        damping[end] += springs.damping / system.masses[end];
      }
    }
  });
  for (const Support& support : system.supports) {
    for (const Index point : support.points) stiffness[point] = damping[point] = 0.0;
  }
  Stiffness result;
  for_each_springs(system, [&](const Springs& springs, std::size_t n) {
    for (std::size_t k = 0; k < springs.pairs.size(); ++k) {
      const auto [i, j] = springs.pairs[k];
      const double rate = std::max(std::sqrt(stiffness[i] + stiffness[j]), damping[i] + damping[j]);
      if (!(rate > result.rate)) continue;
      result.rate = rate;
      result.spring = force_name(system, n) + "[" + std::to_string(k) + "]";
    }
  });
  result.shortest = shortest_length(system);
  result.speed = largest_speed(system);
  for (const Force& force : system.forces) {
    if (const auto* gravity = std::get_if<Gravity>(&force)) result.fall += norm(make_vec3(gravity->acceleration));
    result.has_pairs = result.has_pairs || std::holds_alternative<PairForces>(force);
  }
  return result;
}

Stiffness measure_stiffness(const System& own, Decisions& all) {
  Stiffness result = measure_stiffness(own);
  if (all.is_alone()) return result;
  std::array<double, 5> numbers{result.rate, -result.shortest, result.fall, result.speed, result.has_pairs ? 1.0 : 0.0};
  all.take_largest(numbers);
  const bool has_stiffest = result.rate > 0.0 && result.rate == numbers[0];
  // The number of a spring in a part is not that in the whole system.
  const std::string force = has_stiffest ? result.spring.substr(0, result.spring.rfind('[')) : "";
  return {numbers[0], all.first_text(force), -numbers[1], numbers[2], numbers[3], numbers[4] > 0.0};
}

}  // namespace tanor::detail
