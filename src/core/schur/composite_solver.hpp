#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "schur/schur_solver.hpp"

namespace tanor::detail {

/// Solves islands of several kinds, each kind with its own solver. An empty one has no solver, and answers for no row.
class CompositeSolver final : public SchurSolver {
 public:
  explicit CompositeSolver(std::vector<std::unique_ptr<SchurSolver>> solvers = {});

  bool is_empty() const { return solvers_.empty(); }

  Elimination solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks, double* scratch,
                    double* lambda, double* w) override;
  Elimination factorize(const Parallel& parallel, const double* blocks) override;
  void solve_negative(const Parallel& parallel, const double* b, double* x) override;
  void correct(const Parallel& parallel, const double* blocks, double* rows, double* points) override;
  void read_offsets(std::span<const Vec3> offsets) override;
  const Summary& summary() const override { return summary_; }

  double evaluate_values(const Parallel& parallel, const double* r, double* xi) override;
  double evaluate_rates(const Parallel& parallel, const double* r, const double* v, double* rates) override;
  Elimination linearise(const Parallel& parallel, const double* r, const PointSource* source, double* blocks) override;
  Projection project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                               const PointSource* source, double* sum) override;
  Projection project_velocities(const Parallel& parallel, const double* blocks, double target, const double* r,
                                double* v, double* sum) override;
  void add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) override;

 private:
  /// Calls each(solver) one after the other and joins what they report.
  template <class Each>
  Elimination join(const Each& each);
  template <class Each>
  Projection join_projections(const Each& each);

  std::vector<std::unique_ptr<SchurSolver>> solvers_;
  Summary summary_;
};

/// Makes the solvers that serve all rows of a system together. The result is empty if the sparse factor of all rows is
/// as good or better. Throws InputError if the solver in `wanted` does not serve the system.
CompositeSolver make_composite_solver(const SchurProblem& problem, const SolverOptions& wanted);

}  // namespace tanor::detail
