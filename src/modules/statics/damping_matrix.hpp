#pragma once

#include <Eigen/SparseCore>

#include "dynamics/workspace.hpp"
#include "statics/equilibrium_equations.hpp"

namespace tanor::detail {

/// Returns D = -df/dv [3n, 3n], N s/m, of the n moving points at rest at (t, r), in the inner order. Springs, linear
/// drag and formulas contribute to it; friction does not.
Eigen::SparseMatrix<double> find_damping(Workspace& work, double t, const double* r);
/// Returns G = 2 m Omega x [size(), size()], N s/m, minus the derivative of the Coriolis forces in the velocities, in a
/// frame that turns.
Eigen::SparseMatrix<double> find_coriolis(const EquilibriumEquations& equations);

}  // namespace tanor::detail
