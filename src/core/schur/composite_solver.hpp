#pragma once

#include <memory>
#include <vector>

#include "schur/schur_solver.hpp"

namespace tanor::detail {

/// Solves islands of several kinds, each kind with its own solver. An empty one has no solver, and answers for no row.
class CompositeSolver final : public SchurSolver {
 public:
  explicit CompositeSolver(std::vector<std::unique_ptr<SchurSolver>> solvers = {});

  bool is_empty() const { return solvers_.empty(); }

  Elimination solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks, double* scratch,
                    double* lambda, double* w) override {
    return join<Elimination>(&SchurSolver::solve, parallel, motion, use, blocks, scratch, lambda, w);
  }
  bool finds_multipliers_alone() const override {
    return std::ranges::all_of(solvers_, [](const auto& each) { return each->finds_multipliers_alone(); });
  }
  Elimination linearise(const Parallel& parallel, const double* r, const PointSource* source, double* blocks) override {
    return join<Elimination>(&SchurSolver::linearise, parallel, r, source, blocks);
  }
  Projection project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                               const PointSource* source, double* sum) override {
    return join<Projection>(&SchurSolver::project_positions, parallel, blocks, target, r, source, sum);
  }
  Projection project_velocities(const Parallel& parallel, const double* blocks, double target, const double* r,
                                double* v, double* sum) override {
    return join<Projection>(&SchurSolver::project_velocities, parallel, blocks, target, r, v, sum);
  }
  void solve_negative(const Parallel& parallel, const double* b, double* x) override {
    for (const auto& solver : solvers_) solver->solve_negative(parallel, b, x);
  }
  void correct(const Parallel& parallel, const double* blocks, double* rows, double* points) override {
    for (const auto& solver : solvers_) solver->correct(parallel, blocks, rows, points);
  }
  void add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) override {
    for (const auto& solver : solvers_) solver->add_reactions(parallel, blocks, rows, points);
  }
  void read_offsets(std::span<const Vec3> offsets) override {
    for (const auto& solver : solvers_) solver->read_offsets(offsets);
  }

 private:
  /// Calls a function of each solver and joins what they report.
  template <class Report, class Function, class... Arguments>
  Report join(Function function, const Arguments&... arguments) {
    Report result;
    for (const auto& solver : solvers_) result.include(Report{((*solver).*function)(arguments...)});
    return result;
  }

  std::vector<std::unique_ptr<SchurSolver>> solvers_;
};

/// Makes the solvers that serve all rows of a system together. The result is empty if the sparse factor of all rows is
/// as good or better. Throws InputError if the solver in `wanted` does not serve the system.
CompositeSolver make_composite_solver(const SchurProblem& problem, const SolverOptions& wanted);

}  // namespace tanor::detail
