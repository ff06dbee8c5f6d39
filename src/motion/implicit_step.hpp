#pragma once

#include <memory>
#include <vector>

#include "motion/newton_iteration.hpp"
#include "motion/scheme.hpp"

namespace tanor {

/// What implicit schemes share: the linearisation and factor that are kept from step to step while Newton's iteration
/// converges, and the end of a step.
class ImplicitStep {
 public:
  ImplicitStep(const MotionOptions& options, Mechanics& mechanics);

  Mechanics& mechanics;
  const std::unique_ptr<ImplicitEquations> equations;
  NewtonIteration newton;

  /// Before the iteration of a step from `from`: linearises where there is nothing, or `renew` was asked for. True: the
  /// matrices have to be factorized, for h.
  bool prepare(const State& from, double h, const double* lambda);
  /// After an iteration that converged, or not: a slow one asks for a new linearisation. False: the step is hopeless,
  /// for the linearisation was already its own.
  bool may_renew(const State& from);
  void note_convergence();
  void forget_factor() { factorized_for_ = 0.0; }

  /// `to`, whose x and v are found, onto the constraints in the norm of Newton's matrix, which leaves stiff springs as
  /// they are; then `settle`.
  StepResult finish(State* to);

 private:
  void put_onto_constraints(State* to);

  MotionOptions options_;
  double linearised_at_ = 0.0, factorized_for_ = 0.0;  // s
  bool is_linearised_ = false, renew_ = false;
  std::vector<double> y_, mu_;
};

}  // namespace tanor
