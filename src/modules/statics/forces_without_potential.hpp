#pragma once

#include <string>
#include <vector>

#include <tanor/system.hpp>

#include "base/parallel.hpp"

namespace tanor::detail {

/// W = -df/dr is not a Hessian, and some force has no potential, if |W - W'| exceeds this part of the largest |W|.
inline constexpr double symmetric_to = 1e-8;

/// Names the formulas that make the stiffness of a system unsymmetric at `positions` [3n, in the user's order] and t:
/// "follower, wind". `largest` is the largest |W_ij| of all forces, N/m.
std::string name_forces_without_potential(const System& system, const std::vector<double>& positions, double t,
                                          double largest);

/// Lists by name the formulas whose forces at rest change with the velocities.
std::vector<std::string> list_formulas_on_velocities(const System& system, const std::vector<double>& positions,
                                                     double t);

}  // namespace tanor::detail
