#pragma once

#include <vector>

#include <Eigen/Core>

/// \file Dense linear algebra that tests compare with. It is Eigen's, compiled once, since each decomposition takes
/// seconds in a file that names it.
namespace tanor::reference {

/// Returns the three numbers of a point in an array of all.
inline Eigen::Vector3d place(const std::vector<double>& array, std::ptrdiff_t point) {
  return Eigen::Map<const Eigen::Vector3d>(array.data() + 3 * point);
}

/// Solves A x = b with full pivoting.
Eigen::VectorXd solve_full(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);
/// Solves A x = b with partial pivoting. The result is not finite if A is singular.
Eigen::VectorXd solve_partial(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);
/// Solves A x = b for a symmetric A > 0 by LDL'.
Eigen::VectorXd solve_definite(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);
/// Returns the shortest X with the least |A X - B|, column by column. Pivots up to `threshold` times the largest one
/// count as 0. The default threshold is that of rounding.
Eigen::MatrixXd solve_least_squares(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, double threshold = -1.0);

/// Returns the eigenvalues of a symmetric matrix in ascending order. The columns of `vectors` are orthonormal.
Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& A, Eigen::MatrixXd* vectors = nullptr);
/// Returns the eigenvalues omega^2 of A x = omega^2 B x, both symmetric and B > 0.
Eigen::VectorXd eigenvalues_beside(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);
/// Returns the singular values in descending order. `V` is square, and its columns are in the same order.
Eigen::VectorXd singular_values(const Eigen::MatrixXd& A, Eigen::MatrixXd* V = nullptr);

/// Returns Q of A = QR by Householder reflections. Q is square, and its first columns span those of A.
Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd& A);
/// Returns Q with column pivoting, and the rank by `threshold` as above. The first `rank` columns span those of A.
Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd& A, double threshold, Eigen::Index* rank);
/// Returns a basis of all x with A x = 0, by full pivoting.
Eigen::MatrixXd null_space(const Eigen::MatrixXd& A);
/// Returns the rank, by reflections and full pivoting.
Eigen::Index rank_of(const Eigen::MatrixXd& A, double threshold = -1.0);

}  // namespace tanor::reference
