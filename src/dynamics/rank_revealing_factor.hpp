#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/load_sharing.hpp"
#include "dynamics/workspace.hpp"
#include "schur/gram_solver.hpp"
#include "schur/redundancy.hpp"
#include "schur/schur_solver.hpp"

namespace tanor {

/// The factor of S for all rows together, also where rows of K depend on others. S raises the suspicion, QR of K
/// decides (see Redundancy); rows that depend take no part from then on, until somebody decides anew. Islands whose S
/// is singular to rounding are solved by their QR factors. Contacts that stick and hold more than can move are made
/// slightly compliant.
class RankRevealingFactor final : public SchurFactor {
 public:
  /// `blocks`: K, always at the present configuration. They outlive the factor, as the model does.
  /// `contacts`: null where none may stick.
  RankRevealingFactor(Workspace& work, Ordering ordering, const std::vector<double>& blocks, ContactState* contacts);

  // ---- the factor ----

  /// S of K at (t, r) factorized, and the rank of K decided where S looks singular.
  Outcome factorize(double t, const double* r);
  /// S of the rows that take part, factorized again.
  void factorize_again() { (void)factorize_rows(); }
  /// 1/cond(S), of its pivots, below which S looks singular.
  double suspect_below() const { return suspect_below_; }
  /// Made when first needed: where a SchurSolver serves all islands it may never be.
  GramSolver& gram();
  /// Of a factor that was made.
  const GramSolver::Summary& summary() const { return gram_->summary(); }

  void solve_negative(const Parallel& parallel, const double* b, double* x) override;
  void correct(const Parallel& parallel, const double* blocks, double* rows, double* points) override;
  void add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) override;
  double evaluate_values(const Parallel& parallel, const double* r, double* xi) override;
  double evaluate_rates(const Parallel& parallel, const double* r, const double* v, double* rates) override;
  Projection project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                               const PointSource* source, double* sum) override;
  Projection project_velocities(const Parallel& parallel, const double* blocks, double target, const double* r,
                                double* v, double* sum) override;

  // ---- the rank of K ----

  /// 1/cond(S) from the pivots of the last factorization, S scaled to a unit diagonal.
  double reciprocal_condition() const { return reciprocal_condition_; }
  const Redundancy& redundancy() const { return redundancy_; }
  /// No row is known to depend on others, nor any contact that sticks.
  bool has_independent_rows() const { return !redundancy_.is_found() && !contacts_share_loads(); }
  /// Decides again which rows depend at r, if some do. Returns whether they changed; S is then factorized without them.
  bool decide_rank_again(const double* r);
  /// Decides for all rows, suspected or not. Returns whether S was factorized again.
  bool decide_whole_rank(const double* r);
  /// Decides for the parts of S that leave more than `allowed` times the accelerations [neighbourhood] in `rows`, by
  /// QR; then S is factorized again.
  void decide_rank_of_poor_parts(const double* r, const std::vector<double>& rows,
                                 const std::vector<double>& accelerations, double allowed);

  /// Largest |row|/|gradient|/unit of rows that take part, and of those that depend on them; `units` [neighbourhood].
  double largest_active(const std::vector<double>& rows, const std::vector<double>& units) const;
  double largest_dependent(const std::vector<double>& rows, const std::vector<double>& units) const;
  /// Names the dependent row that contradicts the others, if one does by more than `allowed`. `rows`: xi, K'v + xi_t or
  /// phi + K'w0, whose size for unit gradients is that of their neighbourhood, `sizes`; `unit`: " m/s".
  Outcome explain_contradiction(double t, const std::vector<double>& rows, const std::vector<double>& sizes,
                                double allowed, const char* unit) const;
  /// "rods[5] depends on rods[0], rods[3], …"
  std::string describe(const Redundancy::Found& found, const char* verb) const;

  // ---- contacts that share a load ----

  LoadSharing& sharing() { return *sharing_; }
  /// Returns whether S is to be factorized anew, see LoadSharing::begin.
  bool share_loads() { return sharing_ && sharing_->begin(); }

  void exchange_memory(Memory& memory) { memory.exchange(suspect_below_); }

 private:
  bool contacts_share_loads() const { return contacts_ != nullptr && contacts_->shares_loads; }
  GramSolver::Quality factorize_rows();
  Outcome decide_rank(double t, const double* r);
  void leave_out_dependent_rows(bool has_changed);
  Outcome check_gradients(double t) const;
  std::vector<double> blocks_of_constraints() const;

  Workspace& work_;
  const Model& model_;
  const Ordering ordering_;
  const std::vector<double>& blocks_;
  const ContactState* contacts_;  // null where none may stick
  double reciprocal_condition_ = 1.0;
  std::unique_ptr<GramSolver> gram_;
  std::optional<LoadSharing> sharing_;  // none: constraints are ideal
  Redundancy redundancy_;
  double suspect_below_;
  std::vector<double> gradient_norms_;    // [d] at the last decision, where rows depend
  std::vector<double> right_side_of_qr_;  // [d] where QR takes part
};

}  // namespace tanor
