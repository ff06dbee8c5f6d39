#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "dynamics/factor_reuse.hpp"
#include "dynamics/instant.hpp"
#include "dynamics/rank_revealing_factor.hpp"
#include "dynamics/workspace.hpp"
#include "schur/composite_solver.hpp"

namespace tanor::detail {

/// The present factor of S, and its kind: of the present K, by the composite of SchurSolvers or for all rows together,
/// or of another K, to be used with conjugate gradients. Decides who makes the next one.
class StandingFactor {
 public:
  /// `blocks` is K, always at the present configuration. `contacts` is null if constraints are ideal.
  StandingFactor(Workspace& work, const SolverOptions& options, std::vector<double>& blocks, Contacts* contacts);

  /// Returns true if the present K has a factor.
  bool is_fresh() const { return state_ == State::Composite || state_ == State::Sparse; }
  /// Returns true if there is no factor yet, or K changes.
  bool is_needed() const { return state_ == State::None || !work_.constraints.gradients_are_constant(); }
  /// 1/cond(S) from the pivots of the last factorization, S scaled to a unit diagonal; the smallest over its parts.
  double reciprocal_condition() const { return reciprocal_condition_; }

  /// Sets offsets of rods, see Constraints::set_offsets. The factor stays that of the present K.
  void set_offsets(std::span<const Constraints::RowOffset> offsets);

  // ---- making a factor ----

  /// Evaluates K at (t, r) and factorizes its S. `source` brings r, and what else it has; it is null if r is there.
  Outcome linearise(double t, const double* r, const PointSource* source);
  /// Computes K, the factor of its S, b = phi + K'w0 [d], lambda = -S^-1 b [d] and w = w0 + M^-1 K lambda [3n] in one
  /// pass over the memory (see SchurSolver), or b, lambda and w with the present K and factor. Calls
  /// `find_motion`() -> FreeMotion at most once. Returns nothing if the factor of all rows must be used, step by step.
  template <class FindMotion>
  std::optional<Elimination> solve_at_once(Gradients gradients, const FindMotion& find_motion, double* b,
                                           double* lambda, double* w) {
    const bool keeps = gradients == Gradients::Keep;
    if (!(keeps ? state_ == State::Composite : may_be_of_composite())) return std::nullopt;
    return solve_by_composite(find_motion(), keeps ? FactorUse::Keep : FactorUse::Renew, b, lambda, w);
  }
  /// Factorizes S of the K at (t, r) for all rows together.
  Outcome factorize(double t, const double* r);
  /// Factorizes S of the present K if the present factor is that of another K.
  void freshen();
  /// Drops the factor, because its solutions leave too large a residual.
  void refuse() { state_ = State::None; }

  // ---- using the factor ----

  /// The present factor. It must be fresh for solutions; `add_reactions` reads K alone.
  SchurFactor& operator*() { return state_ == State::Composite ? static_cast<SchurFactor&>(composite_) : all_rows_; }
  SchurFactor* operator->() { return &**this; }
  /// The solver whose islands iterate by themselves with the present factor; null if that is the factor of all rows.
  SchurSolver* solver_by_islands() { return state_ == State::Composite ? &composite_ : nullptr; }
  /// The fastest evaluator of values and rates; it needs no factor.
  SchurFactor& evaluator() { return composite_.is_empty() ? all_rows_ : static_cast<SchurFactor&>(composite_); }
  /// Null if every configuration has its own factor.
  FactorReuse* reuse() const { return reuse_.get(); }
  /// Computes lambda [d] and dw [3n] for b with the factor of another configuration, to the allowed error. Returns
  /// false if K needs a factor of its own.
  bool solve_with_old_factor(double t, const double* b, std::vector<double>* lambda, double* dw);
  /// Computes rows := -S^-1 rows and adds M^-1 K rows to points, with the factor of another configuration. Returns
  /// false if there is no such factor, or it does not serve.
  bool correct_with_old_factor(double* rows, double* points) {
    return state_ == State::Stale && reuse_->correct(blocks_.data(), rows, points);
  }

  // ---- rank; decisions about it make the factor of all rows the present one ----

  RankRevealingFactor& all_rows() { return all_rows_; }
  const RankRevealingFactor& all_rows() const { return all_rows_; }
  bool decide_rank_again(const double* r);
  bool decide_whole_rank(const double* r);
  void decide_rank_of_poor_parts(const double* r, const std::vector<double>& rows,
                                 const std::vector<double>& accelerations, double allowed) {
    all_rows_.decide_rank_of_poor_parts(r, rows, accelerations, allowed);
    note_sparse();
  }
  /// Makes sticking contacts share their load from now on. Returns true if S was factorized anew for that.
  bool share_loads();

  // ---- costs ----

  const FactorSummary& summary() const {
    return composite_.is_empty() ? all_rows_.summary().factor : composite_.summary().factor;
  }
  void describe(PlanSummary* plan) const;
  /// Returns true if a factorization costs no more than two solves.
  bool is_cheap() const { return is_cheap_; }
  /// Estimates 1/cond(S) more closely than the pivots tell, for certificates.
  double estimate_reciprocal_condition();

  void exchange_memory(Memory& memory);

 private:
  friend struct Tampering;  // the tests corrupt the factor through it, and every corruption must be caught
  enum class State {
    None,       ///< no factor that may be used again
    Composite,  ///< of the present K, by the composite
    Sparse,     ///< of the present K, for all rows together
    Stale       ///< for all rows together, of another K
  };
  /// Returns true if the composite may make the next factor.
  bool may_be_of_composite() const { return !composite_.is_empty() && !all_rows_.redundancy().is_found(); }
  bool linearise_by_composite(const double* r, const PointSource* source);
  std::optional<Elimination> solve_by_composite(const FreeMotion& motion, FactorUse use, double* b, double* lambda,
                                                double* w);
  void bring_free_points(const PointSource* source) const {
    bring(model_.parallel, source, model_.num_constrained(), model_.num_points());
  }
  bool note_composite(double reciprocal_condition);
  void note_sparse();

  Workspace& work_;
  const Model& model_;
  std::vector<double>& blocks_;  // K
  CompositeSolver composite_;    // empty if the factor of all rows is no slower
  std::vector<Vec3> offsets_;    // [d] of rods; empty until they change
  RankRevealingFactor all_rows_;
  State state_ = State::None;
  double reciprocal_condition_ = 1.0;
  std::unique_ptr<FactorReuse> reuse_;  // null if it does not pay
  bool is_cheap_;
};

}  // namespace tanor::detail
