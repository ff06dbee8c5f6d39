#pragma once

#include <stdexcept>
#include <string>

#include <tanor/motion.hpp>

namespace tanor {

inline constexpr double of_earth = 9.81;  // m/s^2

inline const Observed& find(std::span<const Observed> all, const std::string& name) {
  for (const Observed& each : all)
    if (each.name == name) return each;
  throw std::runtime_error("no observable is named " + name);
}

/// A chain that hangs straight down from a hook.
inline System make_cable(std::size_t links, double mass = 0.5) {
  System system;
  system.units = units_from_name("si");
  RodGroup rods = system.add_rods("links");
  Point last = system.add_support({0.0, 0.0, 0.0}, {}, "hook");
  for (std::size_t k = 1; k <= links; ++k) {
    const Point next = system.add_point({.position = {0.0, 0.0, -0.1 * static_cast<double>(k)}, .mass = mass});
    rods.join(last, next);
    last = next;
  }
  system.add_gravity({0.0, 0.0, -of_earth});
  return system;
}

}  // namespace tanor
