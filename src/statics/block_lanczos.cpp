#include "statics/block_lanczos.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tanor {

using Eigen::MatrixXd, Eigen::VectorXd;
using Rows = Eigen::Index;

namespace {

/// What x becomes orthonormal by: x = V C + Q R, V'Q = 0.
struct Orthonormal {
  MatrixXd Q, C, R;
};

/// Twice is enough, also where columns of x depend on each other: what rounding then puts into Q is orthogonal to V.
Orthonormal orthonormalise(const Eigen::Ref<const MatrixXd>& V, MatrixXd x) {
  const Rows block = x.cols();
  Orthonormal result{{}, MatrixXd::Zero(V.cols(), block), MatrixXd::Identity(block, block)};
  for (int round = 0; round < 2; ++round) {
    const MatrixXd part = V.transpose() * x;
    x.noalias() -= V * part;
    const Eigen::HouseholderQR<MatrixXd> qr(x);
    result.C += part * result.R;
    result.R = qr.matrixQR().topRows(block).triangularView<Eigen::Upper>() * result.R;
    x = qr.householderQ() * MatrixXd::Identity(x.rows(), block);
  }
  result.Q = std::move(x);
  return result;
}

/// Where no full block has room beside the Krylov space, A itself is as small.
RitzPairs find_in_small_space(const std::function<MatrixXd(const MatrixXd&)>& apply, Rows size, Rows count) {
  const MatrixXd A = apply(MatrixXd::Identity(size, size));
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(0.5 * (A + A.transpose()));
  return {eigen.eigenvalues().reverse().head(count), eigen.eigenvectors().rowwise().reverse().leftCols(count)};
}

}  // namespace

RitzPairs find_largest(const std::function<MatrixXd(const MatrixXd&)>& apply, const MatrixXd& start,
                       const LanczosLimits& limits) {
  const Rows block = start.cols(), most = std::max(limits.dimension, limits.count + 2 * block);
  if (start.rows() < most + block) return find_in_small_space(apply, start.rows(), limits.count);
  MatrixXd V(start.rows(), most), T = MatrixXd::Zero(most, most);
  V.leftCols(block) = orthonormalise(V.leftCols(0), start).Q;
  RitzPairs found;
  Rows size = block;
  for (int restarts = 0; restarts <= limits.most_restarts;) {
    // A V = V T + Q R E', where E has the columns of the last block.
    const Orthonormal next = orthonormalise(V.leftCols(size), apply(V.middleCols(size - block, block)));
    T.block(0, size - block, size, block) = next.C;
    T.block(size - block, 0, block, size) = next.C.transpose();
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(T.topLeftCorner(size, size));
    const MatrixXd rotation = eigen.eigenvectors().rowwise().reverse();
    const VectorXd values = eigen.eigenvalues().reverse();
    const VectorXd residuals = (next.R * rotation.bottomRows(block)).colwise().norm();
    // Products know no digit below the rounding of the largest eigenvalue.
    const double rounding = 16.0 * std::numeric_limits<double>::epsilon() * std::abs(values[0]);
    Rows converged = 0;
    while (converged < std::min(size, limits.count) &&
           residuals[converged] <= std::max(limits.tolerance * std::abs(values[converged]), rounding))
      ++converged;
    const bool is_last = restarts == limits.most_restarts && size + block > most;
    if (converged >= limits.count || is_last)
      return {values.head(converged), V.leftCols(size) * rotation.leftCols(converged)};
    if (size + block > most) {
      // The best vectors, and as many others as a block has, stay.
      const Rows kept = std::min(limits.count + block, most - block);
      const MatrixXd best = V.leftCols(size) * rotation.leftCols(kept);
      V.leftCols(kept) = best;
      T.setZero();
      T.diagonal().head(kept) = values.head(kept);
      size = kept;
      ++restarts;
    }
    V.middleCols(size, block) = next.Q;
    size += block;
  }
  return found;
}

}  // namespace tanor
