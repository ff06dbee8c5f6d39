#pragma once

#include <Eigen/Core>

/// \file Products of matrices with many rows and few columns, a part of the rows at a time that stays in the second
/// cache, compiled for each instruction set.
namespace tanor {

using TallMatrix = Eigen::Ref<const Eigen::MatrixXd>;

/// A'B
Eigen::MatrixXd multiply_transposed(const TallMatrix& A, const TallMatrix& B);
/// A C
Eigen::MatrixXd multiply_tall(const TallMatrix& A, const Eigen::MatrixXd& C);
/// B -= A C
void subtract_product(const TallMatrix& A, const Eigen::MatrixXd& C, Eigen::MatrixXd* B);

}  // namespace tanor
