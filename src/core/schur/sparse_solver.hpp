#pragma once

#include <vector>

#include "schur/gram_solver.hpp"
#include "schur/island_solver.hpp"

namespace tanor::detail {

/// Solves the islands that no special solver serves, beside others that one does, by a GramSolver of their rows alone.
class SparseSolver final : public IslandSolver {
 public:
  SparseSolver(const SchurProblem& problem, IslandGroup group);

  Elimination solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks, double* b,
                    double* lambda, double* w) override;
  Elimination factorize(const Parallel& parallel, const double* blocks) override;
  void solve_negative(const Parallel& parallel, const double* b, double* x) override;
  const GramSolver::Summary& factor() const { return solver_.summary(); }

 private:
  GramSolver solver_;  // its rows are the group's, one after the other
  const bool has_constant_gradients_;
  bool is_factorized_ = false;
  double reciprocal_condition_ = 1.0;  // that of the last factor
  std::vector<double> own_rows_;       // [row of the group] b and x of the solver
  std::vector<double> rows_, dw_;      // [d], [3n] scratch
};

}  // namespace tanor::detail
