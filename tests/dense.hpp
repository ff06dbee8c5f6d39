#pragma once

#include <Eigen/Core>

/// \file Dense linear algebra that tests compare with: Eigen's, compiled once, since each decomposition takes seconds
/// in a file that names it.
namespace tanor::reference {

/// A x = b with full pivots.
Eigen::VectorXd solve_full(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);
/// A x = b with partial pivots; not finite where A is singular.
Eigen::VectorXd solve_partial(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);
/// A x = b of a symmetric A > 0, by LDL'.
Eigen::VectorXd solve_definite(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);
/// The shortest X with the least |A X - B|, column by column; pivots up to `threshold` times the largest count as 0, by
/// default those of rounding.
Eigen::MatrixXd solve_least_squares(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, double threshold = -1.0);

/// Of a symmetric matrix, in ascending order; `vectors`: orthonormal columns.
Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& A, Eigen::MatrixXd* vectors = nullptr);
/// Of A x = omega^2 B x, both symmetric, B > 0.
Eigen::VectorXd eigenvalues_beside(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);
/// In descending order; `V`: square, its columns answer to them.
Eigen::VectorXd singular_values(const Eigen::MatrixXd& A, Eigen::MatrixXd* V = nullptr);

/// Q of A = QR by Householder's reflections: square, its first columns span those of A.
Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd& A);
/// The same with columns exchanged, and the rank by `threshold` as above: the first `rank` columns span those of A.
Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd& A, double threshold, Eigen::Index* rank);
/// A basis of all x with A x = 0, by full pivots.
Eigen::MatrixXd null_space(const Eigen::MatrixXd& A);
/// By reflections and full pivots.
Eigen::Index rank_of(const Eigen::MatrixXd& A, double threshold = -1.0);

}  // namespace tanor::reference
