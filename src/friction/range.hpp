#pragma once

#include <Eigen/Dense>

namespace tanor {

/// The range and the null space of a symmetric matrix A >= 0, by its eigenvectors. Eigenvalues up to `rounding` times
/// `unit` count as 0; without a unit, up to `rounding` times the largest one.
class Range {
 public:
  Range(const Eigen::MatrixXd& A, double rounding)
      : Range(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A), rounding) {}
  Range(const Eigen::MatrixXd& A, double rounding, double unit)
      : Range(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A), rounding, unit) {}

  Eigen::Index rank() const { return values.size(); }
  bool is_whole() const { return null.cols() == 0; }

  Eigen::MatrixXd vectors, null;  ///< orthonormal columns
  Eigen::VectorXd values;         ///< [rank] eigenvalues of `vectors`

 private:
  using Solver = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;
  Range(const Solver& eigen, double rounding) : Range(eigen, rounding, eigen.eigenvalues().maxCoeff()) {}
  Range(const Solver& eigen, double rounding, double unit) {
    const Eigen::Index size = eigen.eigenvalues().size();
    const Eigen::Index count = (eigen.eigenvalues().array() > rounding * unit).count();
    vectors = eigen.eigenvectors().rightCols(count);
    null = eigen.eigenvectors().leftCols(size - count);
    values = eigen.eigenvalues().tail(count);
  }
};

}  // namespace tanor
