#include "friction/linear_program.hpp"

#include <algorithm>
#include <limits>

#include "base/dense.hpp"

namespace tanor::detail {

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

/// Writes one row of all: those of G, then u_i <= most, then -u_i <= most.
void LinearProgram::write_row(Eigen::Index row, Eigen::Ref<Eigen::RowVectorXd> values, double* bound) const {
  const Eigen::Index n = G_.cols();
  if (row < count_) {
    values = G_.row(row);
    *bound = g_(row);
    return;
  }
  values.setZero();
  values((row - count_) % n) = row < count_ + n ? 1.0 : -1.0;
  *bound = most;
}

/// Returns the row that is violated most, or the first violated one; -1 if there is none.
Eigen::Index LinearProgram::find_violated(const VectorXd& u, bool takes_first) const {
  const Eigen::Index n = u.size(), count = count_;
  Eigen::Index worst = -1;
  double most_violated = rounding;
  for (Eigen::Index row = 0; row < count + 2 * n; ++row) {
    const double value = row < count       ? G_.row(row).dot(u) - g_(row)
                         : row < count + n ? u(row - count) - most
                                           : -u(row - count - n) - most;
    const double allowed = row < count ? 0.0 : rounding * most;
    if (value - allowed <= most_violated) continue;
    worst = row;
    most_violated = value - allowed;
    if (takes_first) break;
  }
  return worst;
}

namespace {

/// Returns the place in the basis whose leaving keeps lambda above 0 when y enters: the first one, or among equal ones
/// that with the largest y. Returns -1 if there is none.
Eigen::Index find_leaving(const VectorXd& lambda, const VectorXd& y, bool takes_first) {
  const double least_y = 1e-10 * y.lpNorm<Eigen::Infinity>();
  Eigen::Index leaving = -1;
  double least = std::numeric_limits<double>::infinity();
  for (Eigen::Index j = 0; j < y.size(); ++j) {
    if (y(j) <= least_y) continue;
    const double ratio = std::max(lambda(j), 0.0) / y(j);
    if (ratio < least || (ratio == least && !takes_first && y(j) > y(leaving))) {
      least = ratio;
      leaving = j;
    }
  }
  return leaving;
}

}  // namespace

LinearProgram::Status LinearProgram::maximize(const VectorXd& c, VectorXd* u) const {
  constexpr int most_pivots = 500, plain_pivots = 100;
  const Eigen::Index n = c.size();
  if (is_empty_) return Status::Infeasible;
  u->resize(n);
  if (n == 0) return Status::Optimal;
  MatrixXd B(n, n);
  VectorXd right(n);
  Eigen::RowVectorXd values(n);
  const auto enter = [&](Eigen::Index place, Eigen::Index row) {
    write_row(row, values, &right(place));
    B.row(place) = values;
  };
  for (Eigen::Index i = 0; i < n; ++i) enter(i, count_ + (c(i) < 0.0 ? n : 0) + i);
  dense::Lu lu;
  for (int pivot = 0; pivot < most_pivots; ++pivot) {
    const bool takes_first = pivot > plain_pivots;  // prevents cycles after many pivots (Bland)
    lu.compute(B);
    *u = lu.solve(right);
    const Eigen::Index worst = find_violated(*u, takes_first);
    if (worst < 0) return Status::Optimal;
    // With B'lambda = c and B'y = normal, lambda stays above 0.
    double bound = 0.0;
    write_row(worst, values, &bound);
    const VectorXd lambda = lu.solve_transposed(c), y = lu.solve_transposed(values.transpose());
    const Eigen::Index leaving = find_leaving(lambda, y, takes_first);
    if (leaving < 0) return Status::Infeasible;
    enter(leaving, worst);
  }
  return Status::Unfinished;
}

}  // namespace tanor::detail
