#pragma once

#include <vector>

#include "dynamics/projector.hpp"
#include "statics/newton_descent.hpp"
#include "statics/smallest_multipliers.hpp"

namespace tanor::detail {

/// Descends the energy along xi = 0 as a motion that is damped where it goes uphill (FIRE, Bitzek et al. 2006):
///
///   v += h (f + K lambda)/mass,   v turned towards the force,   r += h v put back onto xi = 0
///
/// The masses are proportional to the stiffness at each point, so that one step suits all points. The descent ends near
/// an equilibrium, where Newton's method takes over.
class ProjectedDescent {
 public:
  ProjectedDescent(EquilibriumEquations& equations, SmallestMultipliers& multipliers)
      : equations_(equations), model_(equations.model()), multipliers_(multipliers) {}

  Outcome run(const NewtonLimits& limits, StaticState* state, std::vector<double>* residuals);
  int iterations() const { return iterations_; }

 private:
  Outcome find_start(Projector& projector, std::vector<double>* r);
  void turn_along_constraints(std::vector<double>* v);

  EquilibriumEquations& equations_;
  const Model& model_;
  SmallestMultipliers& multipliers_;
  std::vector<double> rates_;  // scratch [rows]
  int iterations_ = 0;
};

}  // namespace tanor::detail
