#pragma once

#include <Eigen/Core>

#include "base/dense.hpp"

namespace tanor::detail {

/// The range and the null space of a symmetric matrix A >= 0, by its eigenvectors. Eigenvalues up to `rounding` times
/// `unit` count as 0; without a unit, up to `rounding` times the largest one.
class Range {
 public:
  Range(const Eigen::MatrixXd& A, double rounding) : Range(dense::find_eigen(A), rounding) {}
  Range(const Eigen::MatrixXd& A, double rounding, double unit) : Range(dense::find_eigen(A), rounding, unit) {}

  Eigen::Index rank() const { return values.size(); }
  bool is_whole() const { return null.cols() == 0; }

  Eigen::MatrixXd vectors, null;  ///< orthonormal columns
  Eigen::VectorXd values;         ///< [rank] eigenvalues of `vectors`

 private:
  Range(const dense::SymmetricEigen& eigen, double rounding) : Range(eigen, rounding, eigen.values.maxCoeff()) {}
  Range(const dense::SymmetricEigen& eigen, double rounding, double unit) {
    const Eigen::Index size = eigen.values.size();
    const Eigen::Index count = (eigen.values.array() > rounding * unit).count();
    vectors = eigen.vectors.rightCols(count);
    null = eigen.vectors.leftCols(size - count);
    values = eigen.values.tail(count);
  }
};

}  // namespace tanor::detail
