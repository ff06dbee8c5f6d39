#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "assembly/gather_plan.hpp"
#include "dynamics/roles.hpp"
#include "dynamics/workspace.hpp"
#include "factor/incomplete_cholesky.hpp"
#include "schur/multiplier_history.hpp"

namespace tanor::detail {

/// Solves inside a step without a factor of S. There K changes from stage to stage, and only S lambda = -b is solved.
/// Conjugate gradients (M. R. Hestenes, E. Stiefel 1952) start from the last solutions and converge to the tolerance of
/// the step. They are preconditioned by an incomplete factor P ~ S in the order of rows, which runs along rods. If they
/// do not converge soon, the configuration gets a factor of its own. The operations and the iterations of earlier
/// solves tell which is cheaper. No clock is asked, so the bits are the same every time.
class FactorReuse final : public InexactSolves {
 public:
  /// Returns null where reuse does not pay, because a few iterations cost more than a factor of S, or K is constant.
  /// `factor` sums up the factor of S that a solve saves.
  static std::unique_ptr<FactorReuse> make(Workspace& work, const GramSolver::Summary& factor);

  /// Returns the largest error of dw = M^-1 K lambda that keeps a step within its target, in the M-norm: the root of
  /// the sum of m |dw|^2 = m min((atol + rtol |v|)/h, (atol + rtol |x|)/h^2)^2 over the neighbourhood that allows
  /// least. A heavy neighbourhood must not take what a light one needs. With atol = 0 each point has its own tolerance.
  double allowed_error(const StepTarget& target) override;
  /// Sets the error that later solutions may have; 0 allows rounding alone.
  void allow_error(double error) { allowed_error_ = error; }

  /// Notes that the factor was made of the present K. Solutions with other unit vectors of lines are no initial guess
  /// any more.
  void note_factor();
  /// Returns false where S is nearly singular and where the unit vectors of lines have jumped. There every
  /// configuration needs its own factor.
  bool serves(double reciprocal_condition) const;
  /// Computes lambda [d] and dw [3n] at t with the present K. `is_first` marks the first solve after the factor was
  /// made; one incomplete factor serves equally well all over a step. Returns false if a factorization has to do it;
  /// lambda and dw then mean nothing.
  bool solve(double t, bool is_first, const double* blocks, const double* b, std::vector<double>* lambda, double* dw);
  /// Computes rows := -S^-1 rows to five digits and adds M^-1 K rows to points, with the K of the last solution.
  /// Returns false if the iteration does not converge soon.
  bool correct(const double* blocks, double* rows, double* points);
  /// Adds a solution at t that was found otherwise, as a guess for later ones.
  void note(double t, const std::vector<double>& lambda) {
    if (allowed_error_ > 0.0) history_.add(t, lambda);
  }

  /// Exchanges what the next solve starts from.
  void exchange_memory(Memory& memory);

 private:
  /// The incomplete factor, and how S is assembled for it.
  struct IncompleteFactor {
    GatherPlan plan;
    IncompleteCholesky factor;
  };

  FactorReuse(Workspace& work, double factor_products, double products);
  void forget();
  bool make_incomplete(const double* blocks);
  bool iterate(const double* blocks, const double* b, double allowed, double reduction, double* lambda, double* dw);
  void add_up(const double* blocks, const double* x, double* dw) const;
  double dot(const std::vector<double>& x, const std::vector<double>& y) const;
  bool advance(const double* blocks, double error2, double beta, double* lambda, double* dw);

  Workspace& work_;
  const Model& model_;
  const std::size_t num_rows_;                    // that take part in S, the first ones
  std::vector<double> rho_, z_, p_, q_;           // [d] S lambda + b; -P^-1 rho; direction; S p
  std::unique_ptr<IncompleteFactor> incomplete_;  // planned when it is first needed: schemes of fixed steps never do
  bool is_renewed_ = false;
  double factor_products_, products_;  // multiplications of a factor of S and of an iteration
  double mean_iterations_ = 0.0;       // of a solve
  int num_iterations_ = 0;             // of the last one
  MultiplierHistory history_;
  double allowed_error_ = 0.0;
  std::optional<std::size_t> frames_;              // of lines, when the factor was made; see Constraints::frames
  std::vector<double> correction_, correction_w_;  // [d], [3n] scratch
  std::vector<double> sums_;                       // [neighbourhood] scratch
};

}  // namespace tanor::detail
