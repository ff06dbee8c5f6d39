#include "dense.hpp"

#include <Eigen/Dense>

namespace tanor::reference {

using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd solve_full(const MatrixXd& A, const VectorXd& b) {
  return A.fullPivLu().solve(b);
}

VectorXd solve_partial(const MatrixXd& A, const VectorXd& b) {
  return A.partialPivLu().solve(b);
}

VectorXd solve_definite(const MatrixXd& A, const VectorXd& b) {
  return A.ldlt().solve(b);
}

MatrixXd solve_least_squares(const MatrixXd& A, const MatrixXd& B, double threshold) {
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition(A.rows(), A.cols());
  if (threshold >= 0.0) decomposition.setThreshold(threshold);
  return decomposition.compute(A).solve(B);
}

VectorXd eigenvalues(const MatrixXd& A, MatrixXd* vectors) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(A);
  if (vectors != nullptr) *vectors = eigen.eigenvectors();
  return eigen.eigenvalues();
}

VectorXd eigenvalues_beside(const MatrixXd& A, const MatrixXd& B) {
  return Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd>(A, B, Eigen::EigenvaluesOnly).eigenvalues();
}

VectorXd singular_values(const MatrixXd& A, MatrixXd* V) {
  const Eigen::JacobiSVD<MatrixXd> svd(A, V != nullptr ? Eigen::ComputeFullV : 0);
  if (V != nullptr) *V = svd.matrixV();
  return svd.singularValues();
}

MatrixXd orthonormal_basis(const MatrixXd& A) {
  return A.householderQr().householderQ();
}

MatrixXd orthonormal_basis(const MatrixXd& A, double threshold, Eigen::Index* rank) {
  Eigen::ColPivHouseholderQR<MatrixXd> qr(A);
  qr.setThreshold(threshold);
  *rank = qr.rank();
  return qr.householderQ();
}

MatrixXd null_space(const MatrixXd& A) {
  return A.fullPivLu().kernel();
}

Eigen::Index rank_of(const MatrixXd& A, double threshold) {
  Eigen::FullPivHouseholderQR<MatrixXd> qr(A.rows(), A.cols());
  if (threshold >= 0.0) qr.setThreshold(threshold);
  return qr.compute(A).rank();
}

}  // namespace tanor::reference
