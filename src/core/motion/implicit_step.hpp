#pragma once

#include <memory>
#include <vector>

#include "motion/newton_iteration.hpp"
#include "motion/scheme.hpp"

namespace tanor::detail {

/// The common part of implicit schemes: the linearisation and the factor, which are kept from step to step while
/// Newton's iteration converges, and the end of a step. Each process has the equations of its own part, so that
/// Newton's matrix of all has a block for each, which factorizes and solves that alone; outcomes, the largest violation
/// and powers are those of all processes.
class ImplicitStep {
 public:
  ImplicitStep(const IntegrationOptions& options, Mechanics& mechanics);

  Mechanics& mechanics;
  const std::unique_ptr<ImplicitEquations> equations;
  NewtonIteration newton;

  /// Returns true if the matrices have to be linearised anew, since there is no linearisation yet or the last one
  /// served badly. It stands at a state of the present step or of an earlier one.
  bool wants_linearisation() const { return renew_; }
  void linearise(double t, const double* x, const double* v, const double* lambda);
  Outcome evaluate(double t, const double* x, const double* v, const double* lambda, double* a, double* rows,
                   Power* power = nullptr);
  double evaluate_positions(double t, const double* x, double* xi);
  template <class T>
  Outcome factorize(const NewtonWeights<T>& weights) {
    return mechanics.together([&] { return equations->factorize(weights); });
  }
  /// Returns true if the matrices have to be factorized for a step of length h from there, which it remembers.
  bool wants_factors(const State& from, double h);
  void forget_factors() { factorized_for_ = 0.0; }
  void renew() { renew_ = true; }

  /// Takes note that Newton's iteration of a step converged. A slow one asks for a new linearisation for the next step.
  void note_convergence();

  /// Ends a step whose x and v are found. Projects them onto xi = 0 in the norm of Newton's matrix, which leaves stiff
  /// springs as they are; `stabilize` does the rest.
  StepResult finish(State* to, MovedVelocity moved_velocity);

  void exchange_memory(Memory& memory) {
    memory.exchange(factorized_for_, renew_);
    newton.exchange_memory(memory);
    equations->exchange_memory(memory);
  }

 private:
  void put_onto_positions(State* to);
  double measure_rounding(const State& at);

  IntegrationOptions options_;
  double factorized_for_ = 0.0;  // s; 0 if there is no factor
  bool renew_ = true;
  std::vector<double> moves_, rates_, rows_;  // scratch
};

}  // namespace tanor::detail
