#pragma once

#include <memory>
#include <vector>

#include "dynamics/contacts.hpp"
#include "dynamics/dependences.hpp"
#include "dynamics/workspace.hpp"
#include "schur/gram_solver.hpp"
#include "schur/schur_solver.hpp"

namespace tanor::detail {

/// The rows that a decision about the rank looks at: those of islands where some are known to depend, or all.
enum class RankScope { DependentIslands, AllRows };

/// The factor of S for all rows together, also where rows of K depend on others. A nearly singular S raises a
/// suspicion, and a QR of K decides (see Dependences). Dependent rows then take no part until the rank is decided
/// again. Islands whose S is singular to rounding are solved by their QR factors. Contacts that stick and hold more
/// than can move are made slightly compliant. The functions that are virtual here solve and decide with rows of other
/// processes where there are some (see Team::make_factor).
class RankRevealingFactor : public SchurFactor {
 public:
  /// `blocks` is K, always at the present configuration. `contacts` is null if none may stick. The references must
  /// outlive the factor, as the model does.
  RankRevealingFactor(Workspace& work, const SolverOptions& options, const std::vector<double>& blocks,
                      Contacts* contacts);

  // ---- the factor ----

  /// Factorizes S of K at (t, r), and decides the rank of K if S looks singular.
  virtual Outcome factorize(double t, const double* r);
  /// Factorizes S of the active rows again.
  virtual void factorize_again() { (void)factorize_rows(); }
  /// The estimate of 1/cond(S) from its pivots below which S looks singular.
  double suspect_below() const { return suspect_below_; }
  /// Returns the solver of S, which is made when first needed. It is never made if SchurSolvers serve all islands.
  GramSolver& gram();
  /// Says what solves S, and what a factorization costs.
  virtual SchurSolver::Summary summarize() { return {{solver_}, {}, gram().summary().factor}; }

  void solve_negative(const Parallel& parallel, const double* b, double* x) override;
  void correct(const Parallel& parallel, const double* blocks, double* rows, double* points) override;
  void add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) override;

  // ---- the rank of K ----

  /// 1/cond(S) from the pivots of the last factorization, S scaled to a unit diagonal.
  double reciprocal_condition() const { return reciprocal_condition_; }
  virtual const Dependences& dependences() const { return dependences_; }
  /// Decides again at r which rows depend. Returns true if they have changed; S is then factorized without them.
  virtual bool decide_rank_again(const double* r, RankScope scope);
  /// Decides by QR for the parts of S whose residuals in `rows` exceed `allowed` times the accelerations
  /// [neighbourhood]. Factorizes S again.
  virtual void decide_rank_of_poor_parts(const double* r, const std::vector<double>& rows,
                                         const std::vector<double>& accelerations, double allowed);

  /// General, or Cholmod if that was asked for.
  LinearSolver solver() const { return solver_; }

  // ---- contacts that share a load ----

  /// Returns true if S must be factorized again, see Contacts::begin_sharing.
  bool share_loads() { return contacts_ != nullptr && contacts_->begin_sharing(); }

  void exchange_memory(Memory& memory) { memory.exchange(suspect_below_); }

 protected:
  Workspace& work_;
  const Model& model_;
  const std::vector<double>& blocks_;
  double reciprocal_condition_ = 1.0;

 private:
  bool contacts_share_loads() const { return contacts_ != nullptr && contacts_->shares_loads(); }
  GramSolver::Quality factorize_rows();
  Outcome decide_rank(double t, const double* r);
  void leave_out_dependent_rows(bool has_changed);
  Outcome check_gradients(double t) const;
  std::vector<double> blocks_of_constraints() const;

  const Ordering ordering_;
  const LinearSolver solver_;
  Contacts* contacts_;  // null if constraints are ideal
  std::unique_ptr<GramSolver> gram_;
  Dependences dependences_;
  double suspect_below_;
  std::size_t openings_ = 0;              // of one-sided rows, when S was factorized last
  std::vector<double> right_side_of_qr_;  // [d] scratch for QR
};

}  // namespace tanor::detail
