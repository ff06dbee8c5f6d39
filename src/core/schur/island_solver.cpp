#include "schur/island_solver.hpp"

#include <algorithm>
#include <iterator>

namespace tanor::detail {

void IslandSolver::serve(const SchurProblem& problem, std::span<const Index> before, std::span<const Index> left) {
  std::vector<Index> own;
  std::ranges::set_difference(before, left, std::back_inserter(own));
  group_.emplace(problem, own);
}

Elimination IslandSolver::linearise(const Parallel& parallel, const double* r, const PointSource* source,
                                    double* blocks) {
  bring_points(parallel, source);
  group_->constraints.evaluate_gradients(parallel, group_->members, r, blocks);
  return factorize(parallel, blocks);
}

void IslandSolver::correct(const Parallel& parallel, const double* blocks, double* rows, double* points) {
  solve_negative(parallel, rows, rows);
  add_reactions(parallel, blocks, rows, points);
}

double IslandSolver::evaluate_values(const Parallel& parallel, const double* r, double* xi) {
  return group_->constraints.evaluate_values(parallel, group_->members, r, xi);
}

double IslandSolver::evaluate_rates(const Parallel& parallel, const double* r, const double* v, double* rates) {
  return group_->constraints.evaluate_rates(parallel, group_->members, r, v, rates);
}

/// Iterates with evaluate(rows := violations), which returns the largest one, and points += M^-1 K S^-1 (-rows).
template <class Evaluate>
Projection IslandSolver::iterate(const Parallel& parallel, const double* blocks, double target,
                                 const Evaluate& evaluate, double* points, double* sum) {
  rows_.resize(group_->constraints.num_rows());
  return iterate_along_chord(
      target, [&] { return evaluate(rows_.data()); },
      [&] {
        correct(parallel, blocks, rows_.data(), points);
        if (sum != nullptr) group_->add_rows(parallel, rows_.data(), sum);
      });
}

Projection IslandSolver::project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                                           const PointSource* source, double* sum) {
  bring_points(parallel, source);
  if (sum != nullptr) add_reactions(parallel, blocks, sum, r);
  return iterate(
      parallel, blocks, target, [&](double* xi) { return evaluate_values(parallel, r, xi); }, r, sum);
}

Projection IslandSolver::project_velocities(const Parallel& parallel, const double* blocks, double target,
                                            const double* r, double* v, double* sum) {
  return iterate(
      parallel, blocks, target, [&](double* rates) { return evaluate_rates(parallel, r, v, rates); }, v, sum);
}

void IslandSolver::add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) {
  group_->add_reactions(parallel, blocks, rows, points);
}

}  // namespace tanor::detail
