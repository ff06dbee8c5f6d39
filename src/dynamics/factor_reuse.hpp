#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "dynamics/roles.hpp"
#include "dynamics/workspace.hpp"
#include "schur/reuse.hpp"

namespace tanor {

/// Inside a step, where K changes from stage to stage and nothing but S lambda = -b is asked of them, the factor of
/// another configuration serves: conjugate gradients find what the step's tolerance asks for. What they do not find
/// soon is for a factor of its own.
class FactorReuse final : public InexactSolves {
 public:
  /// Null where it does not pay, or K does not change. `factor` has the factor of the other configuration.
  static std::unique_ptr<FactorReuse> make(Workspace& work, GramSolver& factor);

  FactorReuse(Workspace& work, const GramOperator& S, GramSolver& factor);

  /// Largest error of dw = M^-1 K lambda that keeps a step within its target, in the M-norm: the root of the sum of
  /// m |dw|^2 = m min((atol + rtol |v|)/h, (atol + rtol |x|)/h^2)^2 over the neighbourhood that allows least, since a
  /// heavy one must not take what a light one needs. atol 0: each point's own.
  double allowed_error(const StepTarget& target) override;
  /// From here on solutions may have that error; 0: rounding alone.
  void allow_error(double error) { allowed_error_ = error; }

  /// The factor was made of the K at hand: what was solved with other unit vectors of lines guesses nothing.
  void note_factor();
  /// Where S is nearly singular, and where the unit vectors of lines jumped, every configuration has its own factor.
  bool serves(double reciprocal_condition) const;
  /// lambda [d] and dw [3n] at t with the K at hand; `is_first`: since the factor was made. False: not soon.
  bool solve(double t, bool is_first, const double* blocks, const double* b, std::vector<double>* lambda, double* dw);
  /// rows := -S^-1 rows, points += M^-1 K rows, with the K of the last solution. False: not soon.
  bool correct(const double* blocks, double* rows, double* points);
  /// A solution at t that was found otherwise: later ones may begin with it.
  void note(double t, const std::vector<double>& lambda) {
    if (allowed_error_ > 0.0) reuse_.add(t, lambda);
  }

  void exchange_memory(Memory& memory) { reuse_.exchange_memory(memory); }

 private:
  Workspace& work_;
  const Model& model_;
  Reuse reuse_;
  double allowed_error_ = 0.0;
  std::optional<std::size_t> frames_;  // of lines, where the factor was made; see Constraints::frames
  std::vector<double> correction_;     // [3n] scratch
  std::vector<double> sums_;           // [neighbourhood] scratch
};

}  // namespace tanor
