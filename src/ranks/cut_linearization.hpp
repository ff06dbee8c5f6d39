#pragma once

#include <vector>

#include <tanor/ranks.hpp>

#include "dynamics/workspace.hpp"
#include "ranks/agreement.hpp"
#include "ranks/cut_rank.hpp"
#include "ranks/cut_solver.hpp"
#include "ranks/guests.hpp"

namespace tanor {

/// K and the factor of S = K'M^-1K at one configuration, where constraints reach from rank to rank, and what is solved
/// with them. What is written of points is written of guests, too. All functions that solve are collective.
class CutLinearization {
 public:
  CutLinearization(Workspace& work, const Part& part, Ordering ordering);

  /// K at (t, r), and the factor of its S. Nothing is done where K is constant.
  Outcome update(double t, const double* r);
  /// Factorizes S for the K that `blocks()` has, which stands at r.
  Outcome factorize(double t, const double* r);
  /// Decides anew which rows of K depend, at r, if some do. Returns whether they changed; S is then factorized without
  /// them.
  bool decide_rank_again(double t, const double* r);
  bool needs_factor() const { return !(has_factor_ && has_constant_gradients_); }
  /// 1/cond(S) of the last factorization.
  double reciprocal_condition() const { return reciprocal_condition_; }
  std::vector<double>& blocks() { return blocks_; }
  const std::vector<double>& blocks() const { return blocks_; }

  /// x = -S^-1 b [d], dw = M^-1 K x [3n]; the two may share nothing with b but x itself.
  void solve(const double* b, double* x, double* dw);
  /// rows := -S^-1 rows [d], points += M^-1 K rows [3n].
  void correct(double* rows, double* points);
  /// dw := M^-1 K rows
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

}  // namespace tanor
