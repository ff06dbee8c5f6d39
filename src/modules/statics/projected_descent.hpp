#pragma once

#include <vector>

#include "statics/newton_descent.hpp"
#include "statics/smallest_multipliers.hpp"

namespace tanor::detail {

/// Descends the energy along xi = 0 as a motion that is damped where it goes uphill (FIRE, Bitzek et al. 2006):
///
///   v += h (f + K lambda)/mass,   v turned towards the force,   r += h v put back onto xi = 0
///
/// The masses are proportional to the stiffness at each point, so that one step suits all points. The descent ends near
/// an equilibrium, where Newton's method takes over. Adds its steps to `iterations`, and their forces to `residuals`,
/// N.
Outcome descend_along_constraints(EquilibriumEquations& equations, SmallestMultipliers& multipliers,
                                  const NewtonLimits& limits, StaticState* state, std::vector<double>* residuals,
                                  int* iterations);

}  // namespace tanor::detail
