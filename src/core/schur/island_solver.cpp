#include "schur/island_solver.hpp"

#include <algorithm>

namespace tanor::detail {

IslandGroup::IslandGroup(const SchurProblem& problem, std::span<const Index> islands)
    : constraints(problem.constraints), gather(problem.gather), inverse_mass(problem.inverse_mass), island_start{0} {
  const Numbering& numbering = problem.numbering;
  std::vector<char> has_row(numbering.num_rows(), 0), has_point(numbering.num_points(), 0);
  for (const Index island : islands) {
    const Index* const start = numbering.island_start.data() + island;
    std::fill(has_row.begin() + start[0], has_row.begin() + start[1], 1);
    for (auto a = static_cast<std::size_t>(start[0]); a < static_cast<std::size_t>(start[1]); ++a) rows.append(a);
    island_start.push_back(island_start.back() + start[1] - start[0]);
  }
  for (const Incidence& incidence : problem.incidences) {
    if (has_row[static_cast<std::size_t>(incidence.row)] != 0) has_point[static_cast<std::size_t>(incidence.point)] = 1;
  }
  for (std::size_t i = 0; i < numbering.num_moving; ++i) {
    if (has_point[i] != 0) points.append(i);
  }
  members = constraints.select(has_row);
}

Elimination IslandSolver::linearise(const Parallel& parallel, const double* r, const PointSource* source,
                                    double* blocks) {
  bring_points(parallel, source);
  group_.constraints.evaluate_gradients(parallel, group_.members, r, blocks);
  return factorize(parallel, blocks);
}

void IslandSolver::correct(const Parallel& parallel, const double* blocks, double* rows, double* points) {
  solve_negative(parallel, rows, rows);
  add_reactions(parallel, blocks, rows, points);
}

/// Iterates with evaluate(rows := violations), which returns the largest one, and points += M^-1 K S^-1 (-rows).
template <class Evaluate>
Projection IslandSolver::iterate(const Parallel& parallel, const double* blocks, double target,
                                 const Evaluate& evaluate, double* points, double* sum) {
  rows_.resize(group_.constraints.num_rows());
  return iterate_along_chord(
      target, [&] { return evaluate(rows_.data()); },
      [&] {
        correct(parallel, blocks, rows_.data(), points);
        if (sum != nullptr) group_.add_rows(parallel, rows_.data(), sum);
      });
}

Projection IslandSolver::project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                                           const PointSource* source, double* sum) {
  bring_points(parallel, source);
  if (sum != nullptr) add_reactions(parallel, blocks, sum, r);
  return iterate(
      parallel, blocks, target,
      [&](double* xi) { return group_.constraints.evaluate_values(parallel, group_.members, r, xi); }, r, sum);
}

Projection IslandSolver::project_velocities(const Parallel& parallel, const double* blocks, double target,
                                            const double* r, double* v, double* sum) {
  return iterate(
      parallel, blocks, target,
      [&](double* rates) { return group_.constraints.evaluate_rates(parallel, group_.members, r, v, rates); }, v, sum);
}

}  // namespace tanor::detail
