#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <optional>

/// \file Decompositions of small dense matrices. They are Eigen's and are compiled once, since each takes seconds in
/// every file that instantiates it.
namespace tanor::detail::dense {

/// LU decomposition of a square matrix, with partial pivoting.
class Lu {
 public:
  Lu() = default;
  explicit Lu(const Eigen::MatrixXd& A) { compute(A); }
  void compute(const Eigen::MatrixXd& A);
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& b) const;             ///< A x = b
  [[nodiscard]] Eigen::VectorXd solve_transposed(const Eigen::VectorXd& b) const;  ///< A'x = b
  [[nodiscard]] Eigen::MatrixXd inverse() const;
  [[nodiscard]] double determinant() const;

 private:
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;
};

/// Decomposition A = L D L' of a symmetric matrix, with diagonal pivoting. Only the lower half of A is read.
class Ldlt {
 public:
  Ldlt() = default;
  explicit Ldlt(const Eigen::MatrixXd& A) { compute(A); }
  void compute(const Eigen::MatrixXd& A);
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& b) const;  ///< A x = b

 private:
  Eigen::LDLT<Eigen::MatrixXd> ldlt_;
};

/// Solves A x = b by LU with partial pivoting. The result is not finite if A is singular.
Eigen::VectorXd solve(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// Returns an x that minimizes |A x - b|, by Householder QR with column pivoting. Directions beyond the numerical rank
/// get the coefficient 0.
Eigen::VectorXd solve_by_qr(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// Returns the shortest of all x that minimize |A x - b|. Pivots up to `rounding` times the largest one count as 0; the
/// default threshold is that of rounding.
Eigen::VectorXd solve_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b,
                                    std::optional<double> rounding = std::nullopt);

/// Eigenvalues and eigenvectors with A V = V diag(values).
struct SymmetricEigen {
  Eigen::VectorXd values;   ///< in ascending order
  Eigen::MatrixXd vectors;  ///< V, orthonormal columns
};
/// Solves the eigenproblem of a symmetric A, of which only the lower half is read.
SymmetricEigen find_eigen(const Eigen::MatrixXd& A);
/// Solves A V = B V diag(values) with V'B V = 1 for symmetric A and B, B > 0.
SymmetricEigen find_eigen(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

/// Eigenvalues and eigenvectors of any square matrix, with A V = V diag(values).
struct GeneralEigen {
  Eigen::VectorXcd values;
  Eigen::MatrixXcd vectors;
};
GeneralEigen find_general_eigen(const Eigen::MatrixXd& A);

/// Singular value decomposition A = U diag(values) V'.
struct SingularValues {
  Eigen::VectorXd values;  ///< in descending order
  Eigen::MatrixXd U, V;    ///< square; empty if it was not asked for
};
SingularValues find_singular_values_and_U(const Eigen::MatrixXd& A);
SingularValues find_singular_values_and_V(const Eigen::MatrixXd& A);

/// Decomposition A = Q R of a matrix that has no more columns than rows, by Householder reflections.
struct ThinQr {
  Eigen::MatrixXd Q, R;
};
ThinQr find_thin_qr(const Eigen::MatrixXd& A);

}  // namespace tanor::detail::dense
