#pragma once

#include <span>
#include <vector>

#include <tanor/system.hpp>

namespace tanor {

/// -dU/dr of all energies of tuples a second time, N, added up point by point [3n] in the user's order: built-in laws by
/// the definition of their kind on dual numbers (dual.hpp), users' own by their kernel, not by its expression. Harmonic
/// bonds are left out: they are springs. `t`, r [3n]: where.
std::vector<double> find_defined_forces(const System& system, double t, std::span<const double> r);

}  // namespace tanor
