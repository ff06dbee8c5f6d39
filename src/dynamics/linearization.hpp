#pragma once

#include <optional>
#include <vector>

#include "dynamics/conjugate_residuals.hpp"
#include "dynamics/instant.hpp"
#include "dynamics/standing_factor.hpp"
#include "dynamics/workspace.hpp"
#include "schur/refinement.hpp"

namespace tanor {

/// K and the factor of S = K'M^-1K at one configuration, and everything that is solved with them:
///
///   x = -S^-1 b,   dw = M^-1 K x
///
/// A composite of SchurSolvers serves where it can. Where S looks singular, where contacts have rows that come and go,
/// and where the composite would be no faster, the factor of all rows together answers (see StandingFactor).
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
  Outcome factorize(double t, const double* r) { return factor_.factorize(t, r); }
  StandingFactor& factor() { return factor_; }
  const StandingFactor& factor() const { return factor_; }
  /// w0 of every moving point, where solvers take it as one vector; null: they take it point by point.
  const Vec3* uniform_free() const { return factor_.may_be_of_composite() ? model_.uniform_free() : nullptr; }
  /// K, the factor of its S, b = phi + K'w0 [d], lambda = -S^-1 b [d] and w = w0 + M^-1 K lambda [3n] in one pass over
  /// the memory (see SchurSolver), or b, lambda and w with the K and the factor at hand. `find_motion`() -> FreeMotion
  /// is called at most once. None: the factor of all rows is to be asked, step by step.
  template <class FindMotion>
  std::optional<Elimination> solve_at_once(Gradients gradients, const FindMotion& find_motion, double* b,
                                           double* lambda, double* w) {
    const bool keeps = gradients == Gradients::Keep;
    if (!(keeps ? factor_.is_of_composite() : factor_.may_be_of_composite())) return std::nullopt;
    const FreeMotion motion = find_motion();
    bring_free_points(motion.source);
    return factor_.solve_by_composite(motion, keeps ? FactorUse::Keep : FactorUse::Renew, b, lambda, w);
  }
  /// b = phi + K'w0 [d] at (r, v); with_gradients: K at r as well. Returns the largest |b|/|gradient|, m/s^2.
  double evaluate_right_side(const double* r, const double* v, const double* w0, bool with_gradients, double* b) {
    return work_.constraints.evaluate_right_side(model_.parallel, r, v, w0, b,
                                                 with_gradients ? blocks_.data() : nullptr);
  }
  /// K as blocks [3 * num_blocks], at the last configuration.
  const std::vector<double>& blocks() const { return blocks_; }

  // ---- solutions ----

  /// x := -S^-1 b [d]; x may be b.
  void solve_negative(const double* b, double* x);
  /// The same with the factor alone, which is no answer where contacts share a load: a refinement begins with it.
  void apply_factor(const double* b, double* x);
  /// lambda = -S^-1 b [d] and dw = M^-1 K lambda [3n], refined to rounding.
  void solve_refined(const double* b, double* lambda, double* dw);
  /// rows := -S^-1 rows [d], points += M^-1 K rows [3n].
  void correct(double* rows, double* points);
  /// The same as one of several corrections: by conjugate residuals where contacts share a load.
  void correct_conjugately(bool begins, double* rows, double* points);
  /// Say how often such corrections are worth while: those of accelerations, and those of velocities.
  RefinementLimits acceleration_limits() const {
    return shares_loads() ? RefinementLimits{50, 5} : RefinementLimits{5};
  }
  RefinementLimits velocity_limits() const { return shares_loads() ? RefinementLimits{100, 5} : RefinementLimits{4}; }
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

  /// lambda := the multipliers of the same reactions with the least norm, at r: the null space turns with K.
  void minimize_multiplier_norm(const double* r, double* lambda) {
    (void)factor_.decide_rank_again(r);
    minimize_multiplier_norm(lambda);
  }
  /// The same with the K of the last decision about the rank.
  void minimize_multiplier_norm(double* lambda) const {
    const Redundancy& redundancy = factor_.all_rows().redundancy();
    if (redundancy.is_found()) redundancy.minimize_norm(lambda);
  }

  void exchange_memory(Memory& memory) { factor_.exchange_memory(memory); }

 private:
  friend struct Tampering;  // the tests' hand in the works: every corruption must be caught
  bool shares_loads() const { return contacts_ != nullptr && contacts_->shares_loads; }
  /// The points that no solver brings.
  void bring_free_points(const PointSource* source) const {
    bring(model_.parallel, source, model_.num_constrained(), model_.num_points());
  }
  void bring_all(const PointSource* source) const { bring(model_.parallel, source, 0, model_.num_points()); }

  Workspace& work_;
  const Model& model_;
  const ContactState* contacts_;  // null: constraints are ideal
  std::vector<double> blocks_;    // K
  StandingFactor factor_;
  ConjugateResiduals conjugate_;                    // where contacts share a load
  std::vector<double> rows_, right_side_, points_;  // [d], [d], [3n] scratch
};

}  // namespace tanor
