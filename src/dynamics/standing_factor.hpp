#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "dynamics/factor_reuse.hpp"
#include "dynamics/rank_revealing_factor.hpp"
#include "dynamics/workspace.hpp"
#include "schur/composite_solver.hpp"

namespace tanor {

/// The factor of S that stands, and which one that is: of the K at hand, by the composite of SchurSolvers or for all
/// rows together, or of another K, with which conjugate gradients go on. Decides who makes the next one.
class StandingFactor {
 public:
  /// `blocks`: K, always at the present configuration. `contacts`: null where constraints are ideal.
  StandingFactor(Workspace& work, const SolverOptions& options, std::vector<double>& blocks, ContactState* contacts);

  /// The K at hand has a factor.
  bool is_fresh() const { return state_ == State::Composite || state_ == State::Sparse; }
  /// There is no factor yet, or K changes.
  bool is_needed() const { return state_ == State::None || !work_.constraints.gradients_are_constant(); }
  /// The factor that stands was made by the composite, or the next one may be.
  bool is_of_composite() const { return state_ == State::Composite; }
  bool may_be_of_composite() const { return composite_.has_value() && !all_rows_.redundancy().is_found(); }
  /// 1/cond(S) from the pivots of the last factorization, S scaled to a unit diagonal; the smallest over its parts.
  double reciprocal_condition() const { return reciprocal_condition_; }

  // ---- to make one ----

  /// K at r and its factor by the composite, which may make one. False: S looks singular, the factor of all rows is to
  /// decide.
  bool linearise_by_composite(const double* r, const PointSource* source);
  /// The same with lambda and w, see SchurSolver::solve; `use`: Keep where the composite's factor stands. None: S looks
  /// singular.
  std::optional<Elimination> solve_by_composite(const FreeMotion& motion, FactorUse use, double* b, double* lambda,
                                                double* w);
  /// Factorizes S for all rows together, of the K at (t, r).
  Outcome factorize(double t, const double* r);
  /// Makes one of the K at hand where that of another K stands.
  void freshen();
  /// What is solved with it leaves too large a residual: it is not used again.
  void refuse() { state_ = State::None; }

  // ---- to use it ----

  /// It is fresh.
  SchurFactor& operator*() { return is_of_composite() ? static_cast<SchurFactor&>(*composite_) : all_rows_; }
  SchurFactor* operator->() { return &**this; }
  /// Evaluates values and rates fastest; needs no factor.
  SchurFactor& evaluator() { return composite_.has_value() ? static_cast<SchurFactor&>(*composite_) : all_rows_; }
  /// Null: every configuration has its own factor.
  FactorReuse* reuse() const { return reuse_.get(); }
  /// lambda [d] and dw [3n] for b with the factor of another configuration, to the error that is allowed. False: K
  /// wants a factor of its own.
  bool solve_with_old_factor(double t, const double* b, std::vector<double>* lambda, double* dw);
  /// rows := -S^-1 rows, points += M^-1 K rows with the factor of another configuration, where that stands and serves.
  bool correct_with_old_factor(double* rows, double* points) {
    return state_ == State::Stale && reuse_->correct(blocks_.data(), rows, points);
  }

  // ---- rank; what decides about it makes the factor of all rows, which then stands ----

  RankRevealingFactor& all_rows() { return all_rows_; }
  const RankRevealingFactor& all_rows() const { return all_rows_; }
  bool decide_rank_again(const double* r);
  bool decide_whole_rank(const double* r);
  void decide_rank_of_poor_parts(const double* r, const std::vector<double>& rows,
                                 const std::vector<double>& accelerations, double allowed) {
    all_rows_.decide_rank_of_poor_parts(r, rows, accelerations, allowed);
    note_sparse();
  }
  /// Contacts that stick share their load from now on. Returns whether S was factorized anew for that.
  bool share_loads();

  // ---- what it costs ----

  void describe(PlanSummary* plan) const;
  /// A factorization costs no more than two solves.
  bool is_cheap() const { return is_cheap_; }
  /// 1/cond(S), closer than what the pivots say: for certificates.
  double estimate_reciprocal_condition();

  void exchange_memory(Memory& memory);

 private:
  friend struct Tampering;  // the tests' hand in the works: every corruption must be caught
  enum class State {
    None,       ///< none that may be used again
    Composite,  ///< of the K at hand, by the composite
    Sparse,     ///< of the K at hand, for all rows together
    Stale       ///< for all rows together, of another K
  };
  bool note_composite(double reciprocal_condition);
  void note_sparse();

  Workspace& work_;
  const Model& model_;
  std::vector<double>& blocks_;               // K
  std::optional<CompositeSolver> composite_;  // none: the factor of all rows is no slower
  RankRevealingFactor all_rows_;
  State state_ = State::None;
  double reciprocal_condition_ = 1.0;
  std::unique_ptr<FactorReuse> reuse_;  // null: it does not pay
  bool is_cheap_;
};

}  // namespace tanor
