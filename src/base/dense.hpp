#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <optional>

/// \file Decompositions of small dense matrices. They are Eigen's, compiled once: each takes seconds in a file that
/// names it.
namespace tanor::dense {

/// A = LU of a square matrix, with partial pivots.
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

/// A = L D L' of a symmetric matrix, with diagonal pivots; its lower half is read.
class Ldlt {
 public:
  Ldlt() = default;
  explicit Ldlt(const Eigen::MatrixXd& A) { compute(A); }
  void compute(const Eigen::MatrixXd& A);
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& b) const;  ///< A x = b

 private:
  Eigen::LDLT<Eigen::MatrixXd> ldlt_;
};

/// A x = b by partial pivots; not finite where A is singular.
Eigen::VectorXd solve(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// An x with the least |A x - b|, by reflections with columns exchanged; what rounding leaves of the rank is 0.
Eigen::VectorXd solve_by_qr(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// Of all x with the least |A x - b| the shortest; pivots up to `rounding` times the largest one count as 0: by default
/// what rounding makes of one.
Eigen::VectorXd solve_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b,
                                    std::optional<double> rounding = std::nullopt);

/// A V = V diag(values)
struct SymmetricEigen {
  Eigen::VectorXd values;   ///< in ascending order
  Eigen::MatrixXd vectors;  ///< V, orthonormal columns
};
/// Of a symmetric A; its lower half is read.
SymmetricEigen find_eigen(const Eigen::MatrixXd& A);
/// A V = B V diag(values), V'B V = 1, of symmetric A and B, B > 0.
SymmetricEigen find_eigen(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

/// A V = V diag(values) of any square matrix.
struct GeneralEigen {
  Eigen::VectorXcd values;
  Eigen::MatrixXcd vectors;
};
GeneralEigen find_general_eigen(const Eigen::MatrixXd& A);

/// A = U diag(values) V'
struct SingularValues {
  Eigen::VectorXd values;  ///< in descending order
  Eigen::MatrixXd U, V;    ///< square; each only where it was asked for
};
SingularValues find_singular_values_and_U(const Eigen::MatrixXd& A);
SingularValues find_singular_values_and_V(const Eigen::MatrixXd& A);

/// A = Q R of a matrix that has no more columns than rows, by Householder's reflections.
struct ThinQr {
  Eigen::MatrixXd Q, R;
};
ThinQr find_thin_qr(const Eigen::MatrixXd& A);

}  // namespace tanor::dense
