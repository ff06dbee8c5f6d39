#pragma once

#include <cstddef>

#include "statics/equilibrium_equations.hpp"

namespace tanor {

/// Motions of whole bodies that nothing holds: of each set of points that stiffness and constraints join, the
/// translations and rotations that neither K' nor W at the last linearisation feels. `r` [3 points], inner order.
std::size_t count_rigid_zero_modes(const EquilibriumEquations& equations, const double* r);

}  // namespace tanor
