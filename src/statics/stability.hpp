#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "statics/kkt_solver.hpp"
#include "statics/zero_modes.hpp"

namespace tanor {

/// The signs of the omega^2 of Z'WZ q = omega^2 Z'MZ q where the equations were linearised last, at r [3 points].
struct ReducedInertia {
  std::size_t negative = 0, zero = 0;
  std::size_t rigid_zero = 0;  ///< among those that are zero: motions of islands as a whole
  bool is_known = true;        ///< false: pivots vanish wherever the signs are asked for, and the numbers say nothing
  /// The lowest omega^2 that is not zero, 1/s^2, and its shape [size()], q'Mq = 1; NaN and empty where there is none.
  double lowest = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> shape;
};

/// So many unknowns have dense matrices.
inline constexpr std::size_t most_dense_unknowns = 300;

/// Up to so many unknowns by all eigenvalues of the dense matrix; above by the inertia of A - omega^2 M (see KktSolver)
/// on both sides of zero (see ZeroModes), and by Lanczos' method on its inverse.
/// `freedoms`: the number of unknowns less the rank of K; `dependent`: its rows that depend on others.
ReducedInertia find_inertia(const EquilibriumEquations& equations, const std::vector<double>& r, std::size_t freedoms,
                            const std::vector<std::size_t>& dependent, KktSolver* solver);

/// The number of negative omega^2 there; empty: pivots vanish wherever it is asked for.
std::optional<std::size_t> count_unstable(const ZeroModes& zero, KktSolver* solver);

}  // namespace tanor
