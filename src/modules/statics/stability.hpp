#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "statics/kkt_solver.hpp"
#include "statics/zero_modes.hpp"

namespace tanor::detail {

/// The signs of omega^2 in Z'WZ q = omega^2 Z'MZ q where the equations were linearised last, at r [3 points].
struct ReducedInertia {
  std::size_t negative = 0, zero = 0;
  std::size_t rigid_zero = 0;  ///< zero modes that move islands as a whole
  bool is_known = true;        ///< false: pivots vanish at all bounds that were tried, and the numbers are meaningless
  /// The lowest omega^2 that is not zero, 1/s^2, and its shape [size()], q'Mq = 1; NaN and empty if there is none.
  double lowest = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> shape;
};

/// Largest number of unknowns for which dense matrices are used.
inline constexpr std::size_t most_dense_unknowns = 300;

/// Finds the signs from all eigenvalues of the dense matrix up to `most_dense_unknowns` unknowns. With more of them it
/// uses the inertia of A - omega^2 M (see KktSolver) on both sides of zero (see ZeroModes), and Lanczos' method on the
/// inverse. `freedoms` is the number of unknowns less the rank of K; `dependent` lists the rows of K that depend on
/// others.
ReducedInertia find_inertia(const EquilibriumEquations& equations, const std::vector<double>& r, std::size_t freedoms,
                            const std::vector<std::size_t>& dependent, KktSolver* solver);

/// Returns the number of omega^2 below `part` times the bound of each point, -1 for those that are negative. If a pivot
/// vanishes, a nearby bound is used; returns nothing if pivots vanish at all bounds that are tried.
std::optional<std::size_t> count_near(double part, const ZeroModes& zero, KktSolver* solver);

}  // namespace tanor::detail
