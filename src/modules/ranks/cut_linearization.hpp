#pragma once

#include <vector>

#include <tanor/ranks.hpp>

#include "dynamics/workspace.hpp"
#include "ranks/agreement.hpp"
#include "ranks/cut_rank.hpp"
#include "ranks/cut_solver.hpp"
#include "ranks/guests.hpp"

namespace tanor::detail {

/// K and the factor of S = K'M^-1K at one configuration, where constraints reach from rank to rank, and the solves with
/// them. What is written for points is written for guests, too. All functions that solve are collective.
class CutLinearization {
 public:
  CutLinearization(Workspace& work, const Part& part, Ordering ordering);

  /// Evaluates K at (t, r) and factorizes its S. Does nothing if K is constant and S is factorized.
  Outcome update(double t, const double* r);
  /// Factorizes S for the K in `blocks()`, which was evaluated at r.
  Outcome factorize(double t, const double* r);
  /// Decides anew at r which rows of K depend on others, if some do. Returns true if they changed; S is then factorized
  /// without them.
  bool decide_rank_again(double t, const double* r);
  bool needs_factor() const { return !(has_factor_ && has_constant_gradients_); }
  /// Returns 1/cond(S) of the last factorization.
  double reciprocal_condition() const { return reciprocal_condition_; }
  std::vector<double>& blocks() { return blocks_; }
  const std::vector<double>& blocks() const { return blocks_; }

  /// Computes x = -S^-1 b [d] and dw = M^-1 K x [3n]. `x` may be `b`; the outputs share nothing else with it.
  void solve(const double* b, double* x, double* dw);
  /// Replaces rows by -S^-1 rows [d] and adds M^-1 K rows to points [3n].
  void correct(double* rows, double* points);
  /// Sets dw to M^-1 K rows.
  void write_reactions(const double* rows, double* dw);

  void describe(PlanSummary* plan) const;
  CutRank& rank() { return rank_; }
  Agreement& agreement() { return agreement_; }
  Guests& guests() { return guests_; }

 private:
  bool factorize_rows();

  Workspace& work_;
  const Model& model_;
  Agreement agreement_;
  Guests guests_;
  CutSolver solver_;
  CutRank rank_;
  std::vector<double> blocks_;  // K
  bool has_factor_ = false, has_constant_gradients_;
  double reciprocal_condition_ = 1.0;
  std::vector<double> right_side_;  // [d] scratch
  std::vector<double> move_;        // [3n] scratch
};

}  // namespace tanor::detail
