#pragma once

#include <string>
#include <vector>

#include <tanor/system.hpp>

#include "base/parallel.hpp"

namespace tanor {

/// Whether W = -df/dr is no Hessian: of a force that has no potential |W - W'| is more than this part of the largest
/// |W|.
inline constexpr double symmetric_to = 1e-8;

/// The formulas that make the stiffness of a system unsymmetric at `positions` [3n, in the user's order] and t, by
/// name: "follower, wind". `largest`: the largest |W_ij| of all forces, N/m.
std::string name_forces_without_potential(const System& system, const std::vector<double>& positions, double t,
                                          double largest);

/// The formulas whose forces change with the velocities at rest there, by name.
std::vector<std::string> list_formulas_on_velocities(const System& system, const std::vector<double>& positions,
                                                     double t);

}  // namespace tanor
