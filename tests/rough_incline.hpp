#pragma once

/// \file cases/04a: mass 2 on a rough straight line inclined by 30 degrees.

#include <cmath>
#include <numbers>

#include <tanor/system.hpp>

namespace tanor {

/// Sliding downhill with `speed`, m/s.
inline System make_incline(double speed, double mu) {
  const double alpha = std::numbers::pi / 6.0;
  const Vector3 downhill{std::cos(alpha), -std::sin(alpha), 0.0};
  System system;
  system.positions = {0.0, 0.0, 0.0};
  system.velocities = {speed * downhill[0], speed * downhill[1], 0.0};
  system.masses = {2.0};
  system.constraints = {Lines{"rail", {0}, Vector3{}, downhill}};
  system.forces = {Gravity{"", {0.0, -9.81, 0.0}}};
  system.friction = {Coulomb{.name = "", .at = {"rail"}, .coefficient = mu}};
  return system;
}

}  // namespace tanor
