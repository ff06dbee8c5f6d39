#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "dynamics/roles.hpp"
#include "dynamics/workspace.hpp"
#include "schur/reuse.hpp"

namespace tanor::detail {

/// Solves inside a step without a factor of S. There K changes from stage to stage, and only S lambda = -b is solved.
/// Conjugate gradients converge to the tolerance of the step. If they do not converge soon,
/// the configuration gets a factor of its own.
class FactorReuse final : public InexactSolves {
 public:
  /// Returns null where reuse does not pay, or K is constant. `factor` sums up the factor of S.
  static std::unique_ptr<FactorReuse> make(Workspace& work, const GramSolver::Summary& factor);

  FactorReuse(Workspace& work, const GramOperator& S, const GramSolver::Summary& factor);

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
  /// made. Returns false if the iteration does not converge soon.
  bool solve(double t, bool is_first, const double* blocks, const double* b, std::vector<double>* lambda, double* dw);
  /// Computes rows := -S^-1 rows and adds M^-1 K rows to points, with the K of the last solution. Returns false if the
  /// iteration does not converge soon.
  bool correct(const double* blocks, double* rows, double* points);
  /// Adds a solution at t that was found otherwise, as a guess for later ones.
  void note(double t, const std::vector<double>& lambda) {
    if (allowed_error_ > 0.0) reuse_.add(t, lambda);
  }

  void exchange_memory(Memory& memory) { reuse_.exchange_memory(memory); }

 private:
  Workspace& work_;
  const Model& model_;
  Reuse reuse_;
  double allowed_error_ = 0.0;
  std::optional<std::size_t> frames_;  // of lines, when the factor was made; see Constraints::frames
  std::vector<double> correction_;     // [3n] scratch
  std::vector<double> sums_;           // [neighbourhood] scratch
};

}  // namespace tanor::detail
