#pragma once

#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "dynamics/conjugate_residuals.hpp"
#include "dynamics/factor_reuse.hpp"
#include "dynamics/instant.hpp"
#include "dynamics/rank_revealing_factor.hpp"
#include "dynamics/workspace.hpp"
#include "schur/composite_solver.hpp"
#include "schur/refinement.hpp"

namespace tanor::detail {

/// The multipliers of (31) at one instant, and what belongs to them.
struct MultiplierSolution {
  std::vector<double> lambda;  ///< [d] of (31); a guess before
  std::vector<double> b, dw;   ///< [d] phi + K'w0; [3n] w - w0 = M^-1 K lambda. If w is complete, dw may be left out,
                               ///< unless supports move.
  double scale = 0.0;          ///< the largest |w0| and |b|/|gradient|, m/s^2
  double residual = 0.0;       ///< |K'w + phi|/|gradient| over it, if w is complete
  int refinements = 0;         ///< passes that lambda has taken
  bool is_complete = false;    ///< w is w0 + dw; otherwise w is w0, and dw must be refined and added
};

/// The arrays of a refinement, and its limits.
struct Refinement {
  double* rows;               ///< [d] the residual, then the correction
  double* points;             ///< [3n] takes M^-1 K rows
  double* sum;                ///< [d] takes the rows, or null
  int most_passes;            ///< ends earlier where the residual does not halve, …
  int most_where_shared;      ///< … but where contacts share a load, after this number, or five without a gain
  bool is_continued = false;  ///< goes on with the same problem
};

/// K and the factor of S = K'M^-1K at one configuration, and all solutions with them:
///
///   x = -S^-1 b,   dw = M^-1 K x
///
/// The factor is that of a composite of SchurSolvers where possible. It is one of all rows together where S looks
/// singular, where rows of contacts come and go, and where the composite would be no faster; that may be of another K
/// and serve conjugate gradients.
class Linearization {
 public:
  /// `contacts` is null where constraints are ideal. All arguments but the options must outlive the linearization.
  Linearization(Workspace& work, const SolverOptions& options, Contacts* contacts = nullptr);
  Linearization(const Linearization&) = delete;

  // ---- the configuration ----

  /// Evaluates K at (t, r) and factorizes its S, or does nothing where K is constant. `source` brings r, and what else
  /// it has; it is null if r is there already.
  Outcome update(double t, const double* r, const PointSource* source = nullptr);
  /// Sets offsets of rods, see Constraints::set_offsets. The factor stays that of the present K.
  void set_offsets(std::span<const Constraints::RowOffset> offsets);
  /// K as blocks [3 * num_blocks], at the last configuration.
  const std::vector<double>& blocks() const { return blocks_; }
  /// The factor of the present K, made now if need be.
  SchurFactor& factor();
  /// Returns true if the present K has a factor.
  bool is_fresh() const { return state_ == State::Fresh; }
  /// 1/cond(S) from the pivots of the last factorization, S scaled to a unit diagonal; the smallest over its parts.
  double reciprocal_condition() const { return reciprocal_condition_; }
  /// Estimates the same more closely than the pivots tell, for certificates.
  double estimate_reciprocal_condition();
  /// The solvers of S, why they were chosen, and what a factorization costs.
  const SchurSolver::Summary& summary() const { return summary_; }

  // ---- solutions ----

  /// Solves (31) with w0 = M^-1 f [3n] at the state `at`, with f as `request` says, and with K and the factor of S
  /// there or the present ones. `complete`() -> Outcome adds forces that depend on K to w0 and b, once these stand.
  template <class Complete>
  Outcome solve(const Kinematics& at, const Request& request, const Complete& complete, double* w,
                MultiplierSolution* found) {
    work_.set_time(at.t);
    ++work_.counters.evaluations;
    if (request.gradients == Gradients::Evaluate) work_.constraints.choose_frames();
    if (auto outcome = solve_in_one_pass(at, request, w, found)) return *std::move(outcome);
    Outcome outcome = prepare(at, request, w, found);
    if (outcome.ok()) outcome = complete();
    if (outcome.ok() && !found->is_complete) solve_once(found->b.data(), found->lambda.data(), found->dw.data());
    return outcome;
  }
  /// Computes lambda [d] alone, with K and the factor of S that stand, from w0 = M^-1 f [3n] and its largest number.
  /// Returns false where that is no cheaper than all, or leaves a residual that must be refined.
  bool find_multipliers(const Kinematics& at, const double* w0, double largest_w0, double* lambda);
  /// Computes lambda = -S^-1 b [d] and dw = M^-1 K lambda [3n] with the factor alone. Where contacts share a load this
  /// is only the start of a refinement.
  void solve_once(const double* b, double* lambda, double* dw);
  /// Computes x := -S^-1 b [d]; x may be b.
  void solve_negative(const double* b, double* x);
  /// Computes lambda = -S^-1 b [d] and dw = M^-1 K lambda [3n], refined to rounding.
  void solve_refined(const double* b, double* lambda, double* dw);
  /// Computes rows := -S^-1 rows [d], and adds M^-1 K rows to points [3n], and rows to sum [d], which may be null.
  void correct(double* rows, double* points, double* sum = nullptr);
  /// Corrects until `is_enough`(residual), by conjugate residuals where contacts share a load. `measure`() writes the
  /// residual into the rows and returns its size. Returns the number of corrections.
  template <class Measure, class IsEnough>
  int refine(const Refinement& what, const Measure& measure, const IsEnough& is_enough) {
    const RefinementLimits limits =
        shares_loads() ? RefinementLimits{what.most_where_shared, 5} : RefinementLimits{what.most_passes};
    return refine_solution(limits, measure, is_enough,
                           [&](int pass) { correct_once(what, pass == 0 && !what.is_continued); });
  }
  /// Computes points += M^-1 K rows, for moving points.
  void add_reactions(const double* rows, double* points) {
    present_->add_reactions(model_.parallel, blocks_.data(), rows, points);
  }
  /// Computes y = K'x + shift [d]; `shift` may be null. Returns the largest |y|/|gradient|.
  double apply_transposed(const double* x, const double* shift, double* y) const {
    return work_.team().largest(work_.constraints.apply_transposed(model_.parallel, blocks_.data(), x, shift, y));
  }

  // ---- violations ----

  /// Computes xi [d] at r. Returns the largest |xi|/length.
  double evaluate_values(const double* r, double* xi);
  /// Computes K'v + xi_t [d] at r. Returns the largest one, m/s.
  double evaluate_rates(const double* r, const double* v, double* rates);
  /// Begins a projection with the guess `sum`, as SchurSolver::project_positions does, and lets the islands iterate by
  /// themselves. Returns nothing if none does, since the factor of all rows is the present one.
  std::optional<Projection> project_positions(double target, double* r, const PointSource* source, double* sum);
  /// Does the same for velocities, without a guess.
  std::optional<Projection> project_velocities(double target, const double* r, double* v, double* sum);

  // ---- rank ----

  /// The rows of K that depend on others, by the last decision.
  const Dependences& dependences() const { return all_rows_->dependences(); }
  /// Decides again which rows depend at r, if some do. Returns true if they have changed.
  bool decide_rank_again(const double* r, RankScope scope = RankScope::DependentIslands);
  /// See RankRevealingFactor.
  void decide_rank_of_poor_parts(const double* r, const std::vector<double>& rows,
                                 const std::vector<double>& accelerations, double allowed);
  /// Replaces lambda by the multipliers of least norm with the same reactions. The rank is decided again at r, since
  /// the null space turns with K.
  void minimize_multiplier_norm(const double* r, double* lambda) {
    (void)decide_rank_again(r);
    dependences().minimize_norm(lambda);
  }
  /// Makes the factor at (t, r) that may serve where the present one leaves too large a residual: that of all rows, or
  /// the one with which sticking contacts share their load from now on. Returns nothing if there is none.
  std::optional<Outcome> improve_factor(double t, const double* r);
  /// Returns true if contacts that stick share a load.
  bool shares_loads() const { return contacts_ != nullptr && contacts_->shares_loads(); }
  /// The solver of S of all rows, in which the rows of contacts may be made compliant.
  GramSolver& gram() { return all_rows_->gram(); }

  /// Null if every configuration has its own factor.
  FactorReuse* reuse() const { return reuse_.get(); }
  void exchange_memory(Memory& memory);

 private:
  enum class State {
    None,   ///< no factor that may be used again
    Fresh,  ///< that of the present K
    Stale   ///< that of another K, for all rows together
  };
  /// Returns true if there is no factor yet, or K changes.
  bool is_needed() const { return state_ == State::None || !has_constant_gradients_; }
  std::optional<Outcome> solve_in_one_pass(const Kinematics& at, const Request& request, double* w,
                                           MultiplierSolution* found);
  std::optional<Elimination> eliminate(const FreeMotion& motion, FactorUse use, double* w, MultiplierSolution* found);
  Outcome prepare(const Kinematics& at, const Request& request, double* w, MultiplierSolution* found);
  Outcome factorize(double t, const double* r);
  bool note_composite(double reciprocal_condition);
  void note_all_rows();
  void correct_once(const Refinement& what, bool begins);

  Workspace& work_;
  const Model& model_;
  const Contacts* contacts_;                       // null if constraints are ideal
  std::vector<double> blocks_;                     // K
  CompositeSolver composite_;                      // empty if the factor of all rows is no slower
  std::vector<Vec3> offsets_;                      // [d] of rods; empty until they change
  std::unique_ptr<RankRevealingFactor> all_rows_;  // decisions about the rank make it the present factor
  const SchurSolver::Summary summary_;
  SchurFactor* present_ = all_rows_.get();  // the present factor; it is the composite only while that is fresh
  State state_ = State::None;
  double reciprocal_condition_ = 1.0;
  std::unique_ptr<FactorReuse> reuse_;  // null if it does not pay
  ConjugateResiduals conjugate_;        // used where contacts share a load
  const bool has_constant_gradients_;
  std::vector<double> rows_, right_side_, points_;  // [d], [d], [3n] scratch
};

}  // namespace tanor::detail
