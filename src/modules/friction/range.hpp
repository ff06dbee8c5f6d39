#pragma once

#include <Eigen/Core>
#include <optional>

#include "base/dense.hpp"

namespace tanor::detail {

/// The range and the null space of a symmetric matrix A >= 0, by its eigenvectors. Eigenvalues up to `rounding` times
/// `unit` count as 0; without a unit, up to `rounding` times the largest one.
class Range {
 public:
  Range(const Eigen::MatrixXd& A, double rounding, std::optional<double> unit = std::nullopt) {
    const dense::SymmetricEigen eigen = dense::find_eigen(A);
    const double least = rounding * unit.value_or(eigen.values.maxCoeff());
    const Eigen::Index size = eigen.values.size(), count = (eigen.values.array() > least).count();
    vectors = eigen.vectors.rightCols(count);
    null = eigen.vectors.leftCols(size - count);
    values = eigen.values.tail(count);
  }

  Eigen::Index rank() const { return values.size(); }
  bool is_whole() const { return null.cols() == 0; }

  Eigen::MatrixXd vectors, null;  ///< orthonormal columns
  Eigen::VectorXd values;         ///< [rank] eigenvalues of `vectors`
};

}  // namespace tanor::detail
