#include "base/dense.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>

namespace tanor::detail::dense {

using Eigen::MatrixXd;
using Eigen::VectorXd;

void Lu::compute(const MatrixXd& A) {
  lu_.compute(A);
}

VectorXd Lu::solve(const VectorXd& b) const {
  return lu_.solve(b);
}

VectorXd Lu::solve_transposed(const VectorXd& b) const {
  return lu_.transpose().solve(b);
}

MatrixXd Lu::inverse() const {
  return lu_.inverse();
}

double Lu::determinant() const {
  return lu_.determinant();
}

VectorXd solve(const MatrixXd& A, const VectorXd& b) {
  return Lu(A).solve(b);
}

void Ldlt::compute(const MatrixXd& A) {
  ldlt_.compute(A);
}

VectorXd Ldlt::solve(const VectorXd& b) const {
  return ldlt_.solve(b);
}

VectorXd solve_by_qr(const MatrixXd& A, const VectorXd& b) {
  return A.colPivHouseholderQr().solve(b);
}

VectorXd solve_least_squares(const MatrixXd& A, const VectorXd& b, std::optional<double> rounding) {
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition(A.rows(), A.cols());
  if (rounding) decomposition.setThreshold(*rounding);
  decomposition.compute(A);
  return decomposition.solve(b);
}

SymmetricEigen find_eigen(const MatrixXd& A) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(A);
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

SymmetricEigen find_eigen(const MatrixXd& A, const MatrixXd& B) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> eigen(A, B);
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

GeneralEigen find_general_eigen(const MatrixXd& A) {
  const Eigen::EigenSolver<MatrixXd> eigen(A);
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

SingularValues find_singular_values_and_U(const MatrixXd& A) {
  const Eigen::JacobiSVD<MatrixXd> svd(A, Eigen::ComputeFullU);
  return {svd.singularValues(), svd.matrixU(), {}};
}

SingularValues find_singular_values_and_V(const MatrixXd& A) {
  const Eigen::JacobiSVD<MatrixXd> svd(A, Eigen::ComputeFullV);
  return {svd.singularValues(), {}, svd.matrixV()};
}

ThinQr find_thin_qr(const MatrixXd& A) {
  const Eigen::HouseholderQR<MatrixXd> qr(A);
  return {qr.householderQ() * MatrixXd::Identity(A.rows(), A.cols()),
          qr.matrixQR().topRows(A.cols()).triangularView<Eigen::Upper>()};
}

}  // namespace tanor::detail::dense
