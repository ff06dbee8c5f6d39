#include "friction/linear_program.hpp"

#include <algorithm>
#include <limits>

#include "base/dense.hpp"

namespace tanor::detail {

using Eigen::MatrixXd;
using Eigen::VectorXd;

LinearProgram::LinearProgram(Eigen::Index num_variables)
    : G_(64 + 2 * num_variables, num_variables), g_(G_.rows()), count_(2 * num_variables) {
  G_.topRows(num_variables).setIdentity();
  G_.middleRows(num_variables, num_variables) = -G_.topRows(num_variables);
  g_.head(count_).setConstant(most);
}

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

/// Returns the row that is violated most, or the first violated one; -1 if there is none. Writes the excess of all
/// rows.
Eigen::Index LinearProgram::find_violated(const VectorXd& u, bool takes_first, VectorXd* all) const {
  VectorXd& excess = *all;
  excess.noalias() = G_.topRows(count_) * u;
  excess -= g_.head(count_);
  excess.head(2 * u.size()).array() -= rounding * most;
  Eigen::Index worst = 0;
  if (takes_first)
    while (worst + 1 < count_ && excess(worst) <= rounding) ++worst;
  else
    excess.maxCoeff(&worst);
  return excess(worst) <= rounding ? -1 : worst;
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
  VectorXd right(n), excess(count_);
  const auto enter = [&](Eigen::Index place, Eigen::Index row) {
    B.row(place) = G_.row(row);
    right(place) = g_(row);
  };
  for (Eigen::Index i = 0; i < n; ++i) enter(i, (c(i) < 0.0 ? n : 0) + i);
  dense::Lu lu;
  for (int pivot = 0; pivot < most_pivots; ++pivot) {
    const bool takes_first = pivot > plain_pivots;  // prevents cycles after many pivots (Bland)
    lu.compute(B);
    *u = lu.solve(right);
    const Eigen::Index worst = find_violated(*u, takes_first, &excess);
    if (worst < 0) return Status::Optimal;
    // With B'lambda = c and B'y = normal, lambda stays above 0.
    const VectorXd lambda = lu.solve_transposed(c), y = lu.solve_transposed(G_.row(worst).transpose());
    const Eigen::Index leaving = find_leaving(lambda, y, takes_first);
    if (leaving < 0) return Status::Infeasible;
    enter(leaving, worst);
  }
  return Status::Unfinished;
}

}  // namespace tanor::detail
