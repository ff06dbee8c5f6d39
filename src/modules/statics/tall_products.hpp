#pragma once

#include <Eigen/Core>

/// \file Products of matrices with many rows and few columns. Rows are processed in portions that stay in the
/// second-level cache; the code is compiled for each instruction set.
namespace tanor::detail {

using TallMatrix = Eigen::Ref<const Eigen::MatrixXd>;

/// Returns A'B.
Eigen::MatrixXd multiply_transposed(const TallMatrix& A, const TallMatrix& B);
/// Returns A C.
Eigen::MatrixXd multiply_tall(const TallMatrix& A, const Eigen::MatrixXd& C);
/// Computes B -= A C.
void subtract_product(const TallMatrix& A, const Eigen::MatrixXd& C, Eigen::MatrixXd* B);

}  // namespace tanor::detail
