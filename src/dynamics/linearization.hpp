#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "dynamics/conjugate_residuals.hpp"
#include "dynamics/factor_reuse.hpp"
#include "dynamics/instant.hpp"
#include "dynamics/rank_revealing_factor.hpp"
#include "dynamics/workspace.hpp"
#include "schur/composite_solver.hpp"

namespace tanor {

/// Which factor of S stands.
enum class FactorState {
  None,       ///< none that may be used again
  Composite,  ///< of the K at hand, by the composite of SchurSolvers
  Sparse,     ///< of the K at hand, for all rows together
  Stale       ///< for all rows together, of another K: conjugate gradients go on with it
};

/// K and the factor of S = K'M^-1K at one configuration, and everything that is solved with them:
///
///   x = -S^-1 b,   dw = M^-1 K x
///
/// A composite of SchurSolvers serves where it can. Where S looks singular, where contacts have rows that come and go,
/// and where the composite would be no faster, the factor of all rows together answers (see RankRevealingFactor).
class Linearization {
 public:
  /// `contacts`: with friction; null where constraints are ideal. Both outlive the linearization.
  Linearization(Workspace& work, const SolverOptions& options, ContactState* contacts = nullptr);
  Linearization(const Linearization&) = delete;
  Linearization& operator=(const Linearization&) = delete;

  // ---- the configuration ----

  /// K at (t, r), and the factor of its S. Nothing is done where K is constant. `source`: where r comes from, and what
  /// else that brings; null: it is there.
  Outcome update(double t, const double* r, const PointSource* source = nullptr);
  /// Factorizes S for the K that `blocks()` holds already, after the composite has refused it.
  Outcome factorize(double t, const double* r);
  /// The K at hand has its factor.
  bool has_factor() const { return state_ == FactorState::Composite || state_ == FactorState::Sparse; }
  /// There is no factor yet, or K changes.
  bool needs_factor() const { return state_ == FactorState::None || !work_.constraints.gradients_are_constant(); }
  /// w0 of every moving point, where solvers take it as one vector; null: they take it point by point.
  const Vec3* uniform_free() const { return serves_at_once() ? model_.uniform_free() : nullptr; }
  /// K, the factor of its S, b = phi + K'w0 [d], lambda = -S^-1 b [d] and w = w0 + M^-1 K lambda [3n] in one pass over
  /// the memory (see SchurSolver), or b, lambda and w with the K and the factor at hand. `find_motion`() -> FreeMotion
  /// is called at most once. None: the factor of all rows is to be asked, step by step.
  template <class FindMotion>
  std::optional<Elimination> solve_at_once(Gradients gradients, const FindMotion& find_motion, double* b,
                                           double* lambda, double* w) {
    const bool serves = gradients == Gradients::Keep ? state_ == FactorState::Composite : serves_at_once();
    return serves ? eliminate(find_motion(), gradients, b, lambda, w) : std::nullopt;
  }
  /// b = phi + K'w0 [d] at (r, v); with_gradients: K at r as well. Returns the largest |b|/|gradient|, m/s^2.
  double evaluate_right_side(const double* r, const double* v, const double* w0, bool with_gradients, double* b) {
    return work_.constraints.evaluate_right_side(model_.parallel, r, v, w0, b,
                                                 with_gradients ? blocks_.data() : nullptr);
  }
  /// 1/cond(S) from the pivots of the last factorization, S scaled to a unit diagonal; the smallest over its parts.
  double reciprocal_condition() const { return reciprocal_condition_; }
  /// What `solve_at_once` found leaves too large a residual: the factor is not used again.
  void refuse() { state_ = FactorState::None; }

  /// K as blocks [3 * num_blocks], at the last configuration.
  const std::vector<double>& blocks() const { return blocks_; }

  // ---- solutions ----

  /// x := -S^-1 b [d]; x may be b.
  void solve_negative(const double* b, double* x);
  /// rows := -S^-1 rows [d], also where the factor is a compliant one.
  void solve_negative(double* rows);
  /// lambda = -S^-1 b [d] and dw = M^-1 K lambda [3n], refined to rounding.
  void solve_refined(const double* b, double* lambda, double* dw);
  /// rows := -S^-1 rows [d], points += M^-1 K rows [3n].
  void correct(double* rows, double* points);
  /// The same as one of several corrections: by conjugate residuals where the factor is a compliant one.
  void correct_conjugately(bool begins, double* rows, double* points);
  /// points += M^-1 K rows, and points := M^-1 K rows, of points that move.
  void add_reactions(const double* rows, double* points);
  void write_reactions(const double* rows, double* points) const;
  /// y = K'x + shift [d]; `shift` may be null. Returns the largest |y|/|gradient|.
  double apply_transposed(const double* x, const double* shift, double* y) const {
    return work_.constraints.apply_transposed(model_.parallel, blocks_.data(), x, shift, y);
  }

  // ---- violations ----

  /// xi [d] at r; returns the largest |xi|/length.
  double evaluate_values(const double* r, double* xi);
  /// K'v + xi_t [d] at r; returns the largest one, m/s.
  double evaluate_rates(const double* r, const double* v, double* rates);
  /// Projects as far as the islands of the composite iterate by themselves (see SchurFactor).
  Projection project_positions(double target, double* r, const PointSource* source, double* sum);
  Projection project_velocities(double target, const double* r, double* v, double* sum);

  // ---- factors of other configurations ----

  /// Null: every configuration has its own factor.
  FactorReuse* reuse() const { return reuse_.get(); }
  /// lambda [d] and dw [3n] for b with the factor of another configuration, to the error that is allowed. False: K
  /// wants a factor of its own.
  bool solve_with_old_factor(double t, const double* b, std::vector<double>* lambda, double* dw);

  // ---- rank ----

  RankRevealingFactor& rank_factor() { return factor_; }
  const RankRevealingFactor& rank_factor() const { return factor_; }
  /// These call the functions of RankRevealingFactor, whose factor of all rows then is the one that stands.
  bool decide_rank_again(const double* r) { return note_sparse(factor_.decide_rank_again(r)); }
  bool decide_whole_rank(const double* r) { return note_sparse(factor_.decide_whole_rank(r)); }
  void decide_rank_of_poor_parts(const double* r, const std::vector<double>& rows,
                                 const std::vector<double>& accelerations, double allowed) {
    factor_.decide_rank_of_poor_parts(r, rows, accelerations, allowed);
    (void)note_sparse(true);
  }
  /// Contacts that stick become compliant. Returns whether S was factorized anew for that.
  bool make_compliant();
  /// lambda := the multipliers of the same reactions with the least norm, at r: the null space turns with K.
  void minimize_multiplier_norm(const double* r, double* lambda) {
    (void)decide_rank_again(r);
    minimize_multiplier_norm(lambda);
  }
  /// The same with the K of the last decision about the rank.
  void minimize_multiplier_norm(double* lambda) const {
    if (factor_.redundancy().is_found()) factor_.redundancy().minimize_norm(lambda);
  }

  // ---- what it costs ----

  void describe(PlanSummary* plan) const;
  /// A factorization costs no more than two solves.
  bool is_cheap() const { return is_cheap_; }
  /// 1/cond(S), closer than what the pivots say: for certificates.
  double estimate_reciprocal_condition();

  void exchange_memory(Memory& memory);

 private:
  friend struct Tampering;  // the tests' hand in the works: every corruption must be caught
  bool serves_at_once() const { return !composite_.empty() && !factor_.redundancy().is_found(); }
  std::optional<Elimination> eliminate(const FreeMotion& motion, Gradients gradients, double* b, double* lambda,
                                       double* w);
  SchurFactor& standing() { return state_ == FactorState::Composite ? static_cast<SchurFactor&>(composite_) : factor_; }
  /// The points that no solver brings.
  void bring_free_points(const PointSource* source) const {
    bring(model_.parallel, source, model_.num_constrained(), model_.num_points());
  }
  void bring_all(const PointSource* source) const { bring(model_.parallel, source, 0, model_.num_points()); }
  bool note_composite(double reciprocal_condition);
  bool note_sparse(bool is_factorized);

  Workspace& work_;
  const Model& model_;
  std::vector<double> blocks_;  // K
  CompositeSolver composite_;   // empty: the factor of all rows is no slower
  RankRevealingFactor factor_;
  SchurFactor& evaluator_;  // one of them
  FactorState state_ = FactorState::None;
  double reciprocal_condition_ = 1.0;
  std::unique_ptr<FactorReuse> reuse_;  // null: it does not pay
  ConjugateResiduals conjugate_;        // where contacts are compliant
  bool is_cheap_;
  std::vector<double> rows_, right_side_, points_;  // [d], [d], [3n] scratch
};

}  // namespace tanor
