#pragma once

#include <Eigen/SparseCore>

#include "dynamics/workspace.hpp"

namespace tanor {

/// Returns D = -df/dv [3n, 3n], N s/m, of the n moving points at rest at (t, r), in the inner order. Springs, linear
/// drag and formulas contribute to it; friction does not.
Eigen::SparseMatrix<double> find_damping(Workspace& work, double t, const double* r);

}  // namespace tanor
