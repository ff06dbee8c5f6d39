#pragma once

#include <vector>

#include "factor/sparse_lu.hpp"
#include "statics/newton_descent.hpp"

namespace tanor {

/// Newton's method where some force may have no potential: W need not be symmetric, and there is no energy to descend.
/// The whole matrix [ W K; K' -e ] is factorized (e: a tiny compliance, so that rows may depend on each other), and
/// steps are shortened until the residual sinks.
class UnsymmetricNewton {
 public:
  UnsymmetricNewton(EquilibriumEquations& equations, NewtonDescent& measure);

  Outcome run(const NewtonLimits& limits, StaticState* state, std::vector<double>* residuals);
  int iterations() const { return iterations_; }
  int factorizations() const { return factorizations_; }

 private:
  void make_pattern();
  void assemble(double shift);
  bool find_step(const StaticState& state, double shift, std::vector<double>* step);

  EquilibriumEquations& equations_;
  const Model& model_;
  NewtonDescent& measure_;
  std::unique_ptr<SparseLu<double>> factor_;
  std::vector<int> stiffness_slots_;                // [9 block of W]
  std::vector<std::array<int, 2>> gradient_slots_;  // [3 incidence]: of K and of K'
  std::vector<int> row_slots_;                      // [row] the diagonal
  std::vector<double> g_, xi_;
  int iterations_ = 0, factorizations_ = 0;
};

}  // namespace tanor
