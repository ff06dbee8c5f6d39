#pragma once

#include <Eigen/Core>

namespace tanor::detail {

/// A small dense linear program with rows G u <= g and bounded variables, |u_i| <= most.
class LinearProgram {
 public:
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  enum class Status { Optimal, Infeasible, Unfinished };
  static constexpr double most = 1e5, rounding = 1e-10;

  explicit LinearProgram(Eigen::Index num_variables);

  /// Adds row u <= bound, scaled to unit size. A row of rounding alone holds or not; if it does not, the program is
  /// infeasible for good.
  void add(const Eigen::Ref<const Eigen::RowVectorXd>& row, double bound);
  /// Finds the u with the largest c'u by the dual simplex method, from a corner of the bounds.
  Status maximize(const Eigen::VectorXd& c, Eigen::VectorXd* u) const;

 private:
  Eigen::Index find_violated(const Eigen::VectorXd& u, bool takes_first, Eigen::VectorXd* all) const;

  Rows G_;  // u_i <= most, then -u_i <= most, then what was added
  Eigen::VectorXd g_;
  Eigen::Index count_;
  bool is_empty_ = false;
};

}  // namespace tanor::detail
