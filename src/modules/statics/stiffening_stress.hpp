#pragma once

#include <functional>
#include <vector>

#include "statics/equilibrium_equations.hpp"
#include "statics/smallest_multipliers.hpp"
#include "statics/stability.hpp"

namespace tanor::detail {

/// Chooses a self-stress that makes an equilibrium stable. The energy has a strict minimum where Z'WZ is positive
/// definite with some multipliers that balance the load. If rods pull against each other in ways that no load
/// determines, there are many such multipliers, and this class looks for stabilizing ones (prestress stability,
/// Connelly and Whiteley 1996).
class StiffeningStress {
 public:
  using FindInertia = std::function<ReducedInertia(const std::vector<double>& lambda)>;

  /// `multipliers` must have decided there which rows depend on others. All arguments must outlive this object.
  StiffeningStress(EquilibriumEquations& equations, const SmallestMultipliers& multipliers, FindInertia find);

  /// Chooses lambda [rows] at r [3 points], and its inertia; both stay if nothing better is found.
  void choose(const std::vector<double>& r, std::vector<double>* lambda, ReducedInertia* inertia);

 private:
  void seek(const std::vector<double>& r, std::vector<double>* lambda, ReducedInertia* inertia);
  void relax(const std::vector<double>& r, std::vector<double>* lambda, ReducedInertia* inertia);
  std::vector<double> stiffening(const std::vector<double>& r, const std::vector<double>& lambda,
                                 const std::vector<double>& q);

  EquilibriumEquations& equations_;
  const SmallestMultipliers& multipliers_;
  FindInertia find_;
};

}  // namespace tanor::detail
