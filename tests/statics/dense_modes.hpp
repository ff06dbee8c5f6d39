#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Dense>

#include "dense.hpp"
#include "statics/equilibrium_equations.hpp"

namespace tanor {
using namespace detail;

/// W, K and M of linearised equations, and all modes by dense matrices: Z by Householder reflections of K, and Eigen's
/// generalised eigenvalue problem.
struct DenseModes {
  /// Takes `threshold` for the rank of K.
  explicit DenseModes(const EquilibriumEquations& equations, double threshold = 1e-9)
      : W(size_of(equations.size()), size_of(equations.size())),
        K(size_of(equations.size()), size_of(equations.num_rows())),
        mass(size_of(equations.size())) {
    for (Eigen::Index i = 0; i < W.cols(); ++i) {
      const Eigen::VectorXd unit = Eigen::VectorXd::Unit(W.cols(), i);
      equations.stiffness().multiply(unit.data(), W.col(i).data());
      mass[i] = equations.model().mass[static_cast<std::size_t>(i) / 3];
    }
    K.setZero();
    for (Eigen::Index a = 0; a < K.cols(); ++a) {
      std::vector<double> unit(equations.model().num_rows());
      unit[static_cast<std::size_t>(a)] = 1.0;
      equations.add_reactions(unit.data(), K.col(a).data());
    }
    Eigen::Index rank = 0;
    const Eigen::MatrixXd Q = reference::orthonormal_basis(K, threshold, &rank);
    const Eigen::MatrixXd Z = Q.rightCols(W.rows() - rank);
    if (Z.cols() == 0) return;
    omega2 = reference::eigenvalues_beside(Z.transpose() * W * Z, Z.transpose() * mass.asDiagonal() * Z);
  }

  static Eigen::Index size_of(std::size_t n) { return static_cast<Eigen::Index>(n); }
  bool is_symmetric() const { return (W - W.transpose()).norm() <= 1e-12 * W.norm(); }
  std::size_t freedoms() const { return static_cast<std::size_t>(omega2.size()); }

  Eigen::MatrixXd W, K;
  Eigen::VectorXd mass, omega2;
};

}  // namespace tanor
