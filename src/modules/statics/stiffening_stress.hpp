#pragma once

#include <functional>
#include <vector>

#include "statics/equilibrium_equations.hpp"
#include "statics/smallest_multipliers.hpp"
#include "statics/stability.hpp"

namespace tanor::detail {

using FindInertia = std::function<ReducedInertia(const std::vector<double>& lambda)>;

/// Chooses a self-stress that makes an equilibrium stable, lambda [rows] at r [3 points], and its inertia; both stay if
/// nothing better is found. The energy has a strict minimum where Z'WZ is positive definite with some multipliers that
/// balance the load. If rods pull against each other in ways that no load determines, there are many such multipliers,
/// and this function looks for stabilizing ones (prestress stability, Connelly and Whiteley 1996). `multipliers` must
/// have decided there which rows depend on others.
void choose_self_stress(EquilibriumEquations& equations, const SmallestMultipliers& multipliers,
                        const FindInertia& find, const std::vector<double>& r, std::vector<double>* lambda,
                        ReducedInertia* inertia);

}  // namespace tanor::detail
