#pragma once

#include <span>
#include <vector>

#include <tanor/system.hpp>

namespace tanor {

/// Forces with what rounding allows them to miss.
struct DefinedForces {
  std::vector<double> f;         ///< N [3n]
  std::vector<double> rounding;  ///< N, bounds of the errors [3n]
};

/// -dU/dr of all energies of tuples a second time, added up point by point in the user's order: built-in laws by the
/// definition of their kind on dual numbers (dual.hpp) that count their roundings, users' own by their kernel, not by
/// its expression, which says nothing of rounding. Harmonic bonds are left out: they are springs. `t`, r [3n]: where.
DefinedForces find_defined_forces(const System& system, double t, std::span<const double> r);

}  // namespace tanor
