#pragma once

#include <vector>

#include "statics/newton_descent.hpp"
#include "statics/unsymmetric_kkt.hpp"

namespace tanor::detail {

/// Newton's method for forces that may have no potential: W need not be symmetric, and there is no energy to descend.
/// Steps with the factor of the whole matrix are shortened until the residual falls.
class UnsymmetricNewton {
 public:
  UnsymmetricNewton(EquilibriumEquations& equations, NewtonDescent& measure);

  Outcome run(const NewtonLimits& limits, StaticState* state, std::vector<double>* residuals);
  double next_move() const { return next_move_; }  ///< m, of the step that would follow the last run
  int iterations() const { return iterations_; }
  int factorizations() const { return factorizations_; }

 private:
  double find_next_step(const StaticState& state);
  double linearise(const StaticState& state);
  bool find_step(double shift, std::vector<double>* dr, std::vector<double>* minus_dlambda);

  EquilibriumEquations& equations_;
  const Model& model_;
  NewtonDescent& measure_;
  UnsymmetricKkt kkt_;
  std::vector<double> g_, xi_;
  double next_move_ = 0.0;
  int iterations_ = 0, factorizations_ = 0;
};

}  // namespace tanor::detail
