#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "motion/newton_iteration.hpp"
#include "motion/scheme.hpp"

namespace tanor {

/// What implicit schemes share: the linearisation and factor that are kept from step to step while Newton's iteration
/// converges, and the end of a step.
class ImplicitStep {
 public:
  ImplicitStep(const IntegrationOptions& options, Mechanics& mechanics);

  Mechanics& mechanics;
  const std::unique_ptr<ImplicitEquations> equations;
  NewtonIteration newton;

  /// The matrices stand at a place of the step that is tried, or at one of an earlier step; where there is none, or one
  /// that served badly, they want a new one.
  bool wants_linearisation() const { return renew_; }
  void linearise(double t, const double* x, const double* v, const double* lambda);
  /// They have to be factorized for steps of length h, which is noted.
  bool wants_factors(double h);
  void forget_factors() { factorized_for_ = 0.0; }
  void renew() { renew_ = true; }

  /// Newton's iteration of a step converged: a slow one wants a new linearisation for the next.
  void note_convergence();

  /// The end of a step, whose x and v are found: onto xi = 0 in the norm of Newton's matrix, which leaves stiff springs
  /// as they are; then `settle`.
  StepResult finish(State* to, std::optional<Tolerance> tolerance = {});

  void exchange_memory(Memory& memory) {
    memory.exchange(factorized_for_, renew_);
    newton.exchange_memory(memory);
    equations->exchange_memory(memory);
  }

 private:
  void put_onto_positions(State* to);

  IntegrationOptions options_;
  double factorized_for_ = 0.0;  // s; 0: there is no factor
  bool renew_ = true;
  std::vector<double> moves_, rows_;  // scratch
};

}  // namespace tanor
