#include "friction/linear_program.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace tanor {

using Eigen::MatrixXd;
using Eigen::VectorXd;

void LinearProgram::add(const Eigen::Ref<const Eigen::RowVectorXd>& row, double bound) {
  constexpr double nothing = 1e-13;
  const double size = row.size() > 0 ? row.lpNorm<Eigen::Infinity>() : 0.0;
  if (size <= nothing) {
    is_empty_ = is_empty_ || bound < -rounding;
    return;
  }
  if (count_ == G_.rows()) {
    G_.conservativeResize(2 * count_, Eigen::NoChange);
    g_.conservativeResize(2 * count_);
  }
  G_.row(count_) = row / size;
  g_(count_++) = bound / size;
}

LinearProgram::Status LinearProgram::maximize(const VectorXd& c, VectorXd* u) const {
  const Eigen::Index n = c.size(), count = count_;
  if (is_empty_) return Status::Infeasible;
  u->resize(n);
  if (n == 0) return Status::Optimal;
  // Row count + i: u_i <= most; row count + n + i: -u_i <= most.
  const auto bound = [&](Eigen::Index row) { return row < count ? g_(row) : most; };
  std::vector<Eigen::Index> basis(static_cast<std::size_t>(n));
  MatrixXd B = MatrixXd::Zero(n, n);
  VectorXd right(n), normal(n);
  const auto enter = [&](Eigen::Index place, Eigen::Index row) {
    basis[static_cast<std::size_t>(place)] = row;
    if (row < count)
      B.row(place) = G_.row(row);
    else {
      B.row(place).setZero();
      B(place, (row - count) % n) = row < count + n ? 1.0 : -1.0;
    }
    right(place) = bound(row);
  };
  for (Eigen::Index i = 0; i < n; ++i) enter(i, count + (c(i) < 0.0 ? n : 0) + i);
  constexpr int most_pivots = 500, plain_pivots = 100;
  Eigen::PartialPivLU<MatrixXd> lu(n);
  for (int pivot = 0; pivot < most_pivots; ++pivot) {
    lu.compute(B);
    *u = lu.solve(right);
    // The row that is violated most; after many pivots, against cycles, the first one (Bland).
    Eigen::Index worst = -1;
    double most_violated = rounding;
    for (Eigen::Index row = 0; row < count + 2 * n; ++row) {
      const double value = row < count       ? G_.row(row).dot(*u) - g_(row)
                           : row < count + n ? (*u)(row - count) - most
                                             : -(*u)(row - count - n) - most;
      const double allowed = row < count ? 0.0 : rounding * most;
      if (value - allowed <= most_violated) continue;
      worst = row;
      most_violated = value - allowed;
      if (pivot > plain_pivots) break;
    }
    if (worst < 0) return Status::Optimal;
    normal.setZero();
    if (worst < count)
      normal = G_.row(worst).transpose();
    else
      normal((worst - count) % n) = worst < count + n ? 1.0 : -1.0;
    // B'lambda = c, B'y = normal: lambda stays above 0.
    const VectorXd lambda = lu.transpose().solve(c), y = lu.transpose().solve(normal);
    const double least_y = 1e-10 * y.lpNorm<Eigen::Infinity>();
    Eigen::Index leaving = -1;
    double least = std::numeric_limits<double>::infinity();
    for (Eigen::Index j = 0; j < n; ++j) {
      if (y(j) <= least_y) continue;
      const double ratio = std::max(lambda(j), 0.0) / y(j);
      if (ratio < least || (ratio == least && pivot <= plain_pivots && y(j) > y(leaving))) {
        least = ratio;
        leaving = j;
      }
    }
    if (leaving < 0) return Status::Infeasible;
    enter(leaving, worst);
  }
  return Status::Unfinished;
}

}  // namespace tanor
