#pragma once

#include <cstddef>
#include <vector>

#include "statics/equilibrium_equations.hpp"

namespace tanor::detail {

/// Returns the dimension of the motions of whole islands, free or about a fixed point or axis, that no constraint and
/// no force answers to, over a finite distance too, and that leave the supports which hold them where they are. Islands
/// that could move likewise to first order alone, as a crank with its coupler could, count none, and nor do those that
/// supports hold and no load acts on, as a body at a pin. The equations must have been evaluated and linearised last at
/// r [3 points].
std::size_t count_rigid_modes(const EquilibriumEquations& equations, const std::vector<double>& r);

}  // namespace tanor::detail
