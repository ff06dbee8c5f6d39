#include "schur/composite_solver.hpp"

#include <algorithm>

namespace tanor::detail {

CompositeSolver::CompositeSolver(std::vector<std::unique_ptr<SchurSolver>> solvers) : solvers_(std::move(solvers)) {
  for (const auto& solver : solvers_) {
    const Summary& each = solver->summary();
    summary_.solvers.insert(summary_.solvers.end(), each.solvers.begin(), each.solvers.end());
    summary_.reason += (summary_.reason.empty() ? "" : "; ") + each.reason;
    summary_.factor.include(each.factor);
  }
  if (summary_.factor.orderings.empty()) summary_.factor.orderings = {Ordering::Natural};
}

template <class Each>
Elimination CompositeSolver::join(const Each& each) {
  Elimination result;
  for (const auto& solver : solvers_) {
    result.include(each(*solver));
  }
  return result;
}

Elimination CompositeSolver::solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks,
                                   double* scratch, double* lambda, double* w) {
  return join([&](SchurSolver& solver) { return solver.solve(parallel, motion, use, blocks, scratch, lambda, w); });
}

Elimination CompositeSolver::factorize(const Parallel& parallel, const double* blocks) {
  return join([&](SchurSolver& solver) { return solver.factorize(parallel, blocks); });
}

void CompositeSolver::solve_negative(const Parallel& parallel, const double* b, double* x) {
  for (const auto& solver : solvers_) solver->solve_negative(parallel, b, x);
}

void CompositeSolver::correct(const Parallel& parallel, const double* blocks, double* rows, double* points) {
  for (const auto& solver : solvers_) solver->correct(parallel, blocks, rows, points);
}

// ---- projections ----

double CompositeSolver::evaluate_values(const Parallel& parallel, const double* r, double* xi) {
  double result = 0.0;
  for (const auto& solver : solvers_) result = larger(result, solver->evaluate_values(parallel, r, xi));
  return result;
}

double CompositeSolver::evaluate_rates(const Parallel& parallel, const double* r, const double* v, double* rates) {
  double result = 0.0;
  for (const auto& solver : solvers_) result = larger(result, solver->evaluate_rates(parallel, r, v, rates));
  return result;
}

template <class Each>
Projection CompositeSolver::join_projections(const Each& each) {
  Projection result;
  for (const auto& solver : solvers_) {
    const Projection found = each(*solver);
    result.violation = larger(result.violation, found.violation);
    result.iterations = std::max(result.iterations, found.iterations);
  }
  return result;
}

Elimination CompositeSolver::linearise(const Parallel& parallel, const double* r, const PointSource* source,
                                       double* blocks) {
  return join([&](SchurSolver& solver) { return solver.linearise(parallel, r, source, blocks); });
}

Projection CompositeSolver::project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                                              const PointSource* source, double* sum) {
  return join_projections(
      [&](SchurSolver& solver) { return solver.project_positions(parallel, blocks, target, r, source, sum); });
}

Projection CompositeSolver::project_velocities(const Parallel& parallel, const double* blocks, double target,
                                               const double* r, double* v, double* sum) {
  return join_projections(
      [&](SchurSolver& solver) { return solver.project_velocities(parallel, blocks, target, r, v, sum); });
}

void CompositeSolver::add_reactions(const Parallel& parallel, const double* blocks, const double* rows,
                                    double* points) {
  for (const auto& solver : solvers_) solver->add_reactions(parallel, blocks, rows, points);
}

void CompositeSolver::read_offsets(std::span<const Vec3> offsets) {
  for (const auto& solver : solvers_) solver->read_offsets(offsets);
}

}  // namespace tanor::detail
