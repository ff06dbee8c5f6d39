#pragma once

#include <span>
#include <vector>

#include <tanor/system.hpp>

namespace tanor::detail {

/// Forces with bounds of their rounding errors.
struct DefinedForces {
  std::vector<double> f;         ///< N [3n]
  std::vector<double> rounding;  ///< N, bounds of the errors [3n]
};

/// Computes -dU/dr of all energies of tuples a second time, at t and r [3n], added up point by point in the user's
/// order. Built-in laws run by the definition of their kind on dual numbers (dual.hpp) that count their roundings.
/// Users' own laws run by their kernel, not by its expression, and have no bound. Harmonic bonds are left out, because
/// they are springs.
DefinedForces find_defined_forces(const System& system, double t, std::span<const double> r);

}  // namespace tanor::detail
