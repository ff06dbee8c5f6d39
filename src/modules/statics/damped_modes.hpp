#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "statics/equilibrium_equations.hpp"

namespace tanor::detail {

/// Small motions x(t) = r + Re(q e^(lambda t)): (lambda^2 M + lambda D + W) q + K mu = 0, K'q = 0. A pair of conjugate
/// lambda is represented by the one with the positive imaginary part; the smallest |lambda| comes first. Shapes are in
/// the inner order.
struct DampedModeSet {
  Outcome outcome;
  Eigen::VectorXcd lambda;  ///< 1/s
  Eigen::MatrixXcd shapes;  ///< by columns, q^H M q = 1, q'Mq real and not negative
  double residual = 0.0;    ///< largest |Z'(lambda^2 M + lambda D + W)q| over the largest |lambda|^2
};

/// Finds all damped modes from the dense eigenvalue problem of [0, I; -Z'WZ, -Z'DZ]. Z holds M-orthonormal moves that
/// break no constraint where the equations were linearised last. W and D [size(), size()] need not be symmetric. Values
/// of |lambda| up to `zero` count as 0, which is listed with its multiplicity: twice for a motion that nothing holds or
/// slows.
DampedModeSet find_damped_modes(const EquilibriumEquations& equations, const Eigen::SparseMatrix<double>& D,
                                const Eigen::MatrixXd& Z, double zero);
/// Finds the `count` lowest ones of many freedoms, one of each pair, where the equations were linearised last.
/// `freedoms` is that of the system, at least twice `count`; `rate` is that of the fastest vibration, 1/s.
DampedModeSet find_lowest_damped_modes(const EquilibriumEquations& equations, const Eigen::SparseMatrix<double>& D,
                                       std::size_t count, std::size_t freedoms, double rate, double zero);

}  // namespace tanor::detail
