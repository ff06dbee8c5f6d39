#include "statics/block_lanczos.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "base/dense.hpp"
#include "statics/tall_products.hpp"

namespace tanor::detail {

using Eigen::MatrixXd, Eigen::VectorXd;
using Rows = Eigen::Index;

namespace {

constexpr int most_restarts = 300;

/// The factors that orthonormalise x: x = V C + Q R, V'Q = 0.
struct Orthonormal {
  MatrixXd Q, C, R;
};

/// Returns R of X = QR as the Cholesky factor of X'X, or nothing if columns of X nearly depend on each other.
std::optional<MatrixXd> factorize_gram(const MatrixXd& X) {
  constexpr double least_pivot =
      1e-4;  // for unit columns; Q is then orthogonal to 1e-8, and a second round restores the rest
  const MatrixXd gram = multiply_transposed(X, X);
  const VectorXd lengths = gram.diagonal().cwiseSqrt(), inverse = lengths.cwiseInverse();
  if (!(lengths.array() > 0.0).all() || !inverse.allFinite()) return std::nullopt;
  const Eigen::LLT<MatrixXd> factor(inverse.asDiagonal() * gram * inverse.asDiagonal());
  if (factor.info() != Eigen::Success || !(factor.matrixLLT().diagonal().minCoeff() > least_pivot)) return std::nullopt;
  return MatrixXd(factor.matrixU()) * lengths.asDiagonal();
}

/// Orthonormalises x against V. Two rounds are enough, also if the columns of x depend on each other and Householder
/// reflections separate them: the second round makes the directions that rounding put into Q orthogonal to V.
Orthonormal orthonormalise(const Eigen::Ref<const MatrixXd>& V, MatrixXd x) {
  const Rows block = x.cols();
  Orthonormal result{{}, MatrixXd::Zero(V.cols(), block), MatrixXd::Identity(block, block)};
  for (int round = 0; round < 2; ++round) {
    const MatrixXd part = multiply_transposed(V, x);
    subtract_product(V, part, &x);
    result.C += part * result.R;
    if (const std::optional<MatrixXd> R = factorize_gram(x)) {
      result.R = *R * result.R;
      x = multiply_tall(x, R->triangularView<Eigen::Upper>().solve(MatrixXd::Identity(block, block)));
      continue;
    }
    dense::ThinQr qr = dense::find_thin_qr(x);
    result.R = qr.R * result.R;
    x = std::move(qr.Q);
  }
  result.Q = std::move(x);
  return result;
}

}  // namespace

BlockLanczos::BlockLanczos(std::function<Matrix(const Matrix&)> apply, const Matrix& start, Rows count, Rows dimension)
    : apply_(std::move(apply)), count_(count), block_(start.cols()) {
  const Rows most = std::max(dimension, count + 2 * block_);
  if (start.rows() < most + block_) {
    // The Krylov space has no room for another full block, because A itself is as small.
    span_everything(start.rows());
    return;
  }
  V_.resize(start.rows(), most);
  T_ = Matrix::Zero(most, most);
  next_ = orthonormalise(V_.leftCols(0), start).Q;
  extend();
}

void BlockLanczos::span_everything(Rows size) {
  V_ = Matrix::Identity(size, size);
  T_ = apply_(V_);
  T_ = 0.5 * (T_ + T_.transpose()).eval();
  R_ = Matrix::Zero(block_, block_);
  size_ = size;
  find_ritz_pairs();
}

/// Appends the next block to the space, and computes the one after it.
void BlockLanczos::extend() {
  V_.middleCols(size_, block_) = next_;
  size_ += block_;
  Orthonormal next = orthonormalise(V_.leftCols(size_), apply_(next_));
  T_.block(0, size_ - block_, size_, block_) = next.C;
  T_.block(size_ - block_, 0, block_, size_) = next.C.transpose();
  next_ = std::move(next.Q);
  R_ = std::move(next.R);
  find_ritz_pairs();
}

/// Keeps the best Ritz vectors: the wanted ones and one block more.
void BlockLanczos::restart() {
  const Rows kept = std::min(count_ + block_, V_.cols() - block_);
  const Matrix best = vectors(kept);
  V_.leftCols(kept) = best;
  T_.setZero();
  T_.diagonal().head(kept) = values_.head(kept);
  size_ = kept;
  ++restarts_;
}

void BlockLanczos::find_ritz_pairs() {
  const dense::SymmetricEigen eigen = dense::find_eigen(T_.topLeftCorner(size_, size_));
  rotation_ = eigen.vectors.rowwise().reverse();
  values_ = eigen.values.reverse();
  residuals_ = (R_ * rotation_.bottomRows(R_.cols())).colwise().norm();
}

BlockLanczos::Matrix BlockLanczos::vectors(Rows columns) const {
  return multiply_tall(V_.leftCols(size_), rotation_.leftCols(columns));
}

Rows BlockLanczos::count_converged(double tolerance) const {
  // Products are accurate to the rounding of the largest eigenvalue only.
  const double rounding = 16.0 * std::numeric_limits<double>::epsilon() * std::abs(values_[0]);
  Rows result = 0;
  while (result < std::min(size_, count_) &&
         residuals_[result] <= std::max(tolerance * std::abs(values_[result]), rounding))
    ++result;
  return result;
}

bool BlockLanczos::run(double tolerance) {
  while ((converged_ = count_converged(tolerance)) < count_) {
    if (size_ + block_ > V_.cols()) {
      if (restarts_ == most_restarts) return false;
      restart();
    }
    extend();
  }
  return true;
}

}  // namespace tanor::detail
