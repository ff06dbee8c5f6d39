#pragma once

#include <optional>
#include <vector>

#include "dynamics/conjugate_residuals.hpp"
#include "dynamics/instant.hpp"
#include "dynamics/standing_factor.hpp"
#include "dynamics/workspace.hpp"
#include "schur/refinement.hpp"

namespace tanor::detail {

/// K and the factor of S = K'M^-1K at one configuration, and all solutions with them:
///
///   x = -S^-1 b,   dw = M^-1 K x
///
/// A composite of SchurSolvers is used where possible. The factor of all rows together is used where S looks singular,
/// where rows of contacts come and go, and where the composite would be no faster (see StandingFactor).
class Linearization {
 public:
  /// `contacts` is null where constraints are ideal. All arguments but the options must outlive the linearization.
  Linearization(Workspace& work, const SolverOptions& options, Contacts* contacts = nullptr);
  Linearization(const Linearization&) = delete;
  Linearization& operator=(const Linearization&) = delete;

  // ---- the configuration ----

  /// Evaluates K at (t, r) and factorizes its S, or does nothing where K is constant. `source` brings r, and what else
  /// it has; it is null if r is there already.
  Outcome update(double t, const double* r, const PointSource* source = nullptr);
  /// Factorizes S for the K that `blocks()` holds already, after the composite has refused it.
  Outcome factorize(double t, const double* r) { return factor_.factorize(t, r); }
  StandingFactor& factor() { return factor_; }
  const StandingFactor& factor() const { return factor_; }
  /// Computes b = phi + K'w0 [d] at (r, v), and K at r if `with_gradients` is true. Returns the largest |b|/|gradient|,
  /// m/s^2.
  double evaluate_right_side(const double* r, const double* v, const double* w0, bool with_gradients, double* b) {
    return work_.constraints.evaluate_right_side(model_.parallel, r, v, w0, b,
                                                 with_gradients ? blocks_.data() : nullptr);
  }
  /// K as blocks [3 * num_blocks], at the last configuration.
  const std::vector<double>& blocks() const { return blocks_; }

  // ---- solutions ----

  /// Computes x := -S^-1 b [d]; x may be b.
  void solve_negative(const double* b, double* x);
  /// Computes the same with the factor alone. Where contacts share a load this is only the start of a refinement.
  void apply_factor(const double* b, double* x);
  /// Computes lambda = -S^-1 b [d] and dw = M^-1 K lambda [3n], refined to rounding.
  void solve_refined(const double* b, double* lambda, double* dw);
  /// Computes rows := -S^-1 rows [d], and adds M^-1 K rows to points [3n].
  void correct(double* rows, double* points);
  /// Does the same as one of several corrections, by conjugate residuals where contacts share a load.
  void correct_conjugately(bool begins, double* rows, double* points);
  /// The limits of such corrections of accelerations, and of velocities.
  RefinementLimits acceleration_limits() const {
    return shares_loads() ? RefinementLimits{50, 5} : RefinementLimits{5};
  }
  RefinementLimits velocity_limits() const { return shares_loads() ? RefinementLimits{100, 5} : RefinementLimits{4}; }
  /// Compute points += M^-1 K rows and points := M^-1 K rows, for moving points.
  void add_reactions(const double* rows, double* points);
  void write_reactions(const double* rows, double* points) const;
  /// Computes y = K'x + shift [d]; `shift` may be null. Returns the largest |y|/|gradient|.
  double apply_transposed(const double* x, const double* shift, double* y) const {
    return work_.constraints.apply_transposed(model_.parallel, blocks_.data(), x, shift, y);
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

  /// Replaces lambda by the multipliers of least norm with the same reactions. The rank is decided again at r, since
  /// the null space turns with K.
  void minimize_multiplier_norm(const double* r, double* lambda) {
    (void)factor_.decide_rank_again(r);
    minimize_multiplier_norm(lambda);
  }
  /// Does the same with the K of the last decision about the rank.
  void minimize_multiplier_norm(double* lambda) const {
    const Redundancy& redundancy = factor_.all_rows().redundancy();
    if (redundancy.is_found()) redundancy.minimize_norm(lambda);
  }

  void exchange_memory(Memory& memory) { factor_.exchange_memory(memory); }

 private:
  friend struct Tampering;  // the tests corrupt the solver through it, and every corruption must be caught
  bool shares_loads() const { return contacts_ != nullptr && contacts_->shares_loads(); }

  Workspace& work_;
  const Model& model_;
  const Contacts* contacts_;    // null if constraints are ideal
  std::vector<double> blocks_;  // K
  StandingFactor factor_;
  ConjugateResiduals conjugate_;                    // used where contacts share a load
  std::vector<double> rows_, right_side_, points_;  // [d], [d], [3n] scratch
};

}  // namespace tanor::detail
