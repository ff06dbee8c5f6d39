#include "schur/sparse_solver.hpp"

#include <algorithm>
#include <cmath>

#include "schur/refinement.hpp"

namespace tanor::detail {

namespace {

/// Makes the solver of the group's rows, which are numbered one after the other.
GramSolver make_solver(const SchurProblem& problem, const IslandGroup& group) {
  std::vector<Incidence> own;
  for (Incidence incidence : problem.incidences) {
    const auto row = static_cast<std::size_t>(incidence.row);
    if (!group.rows.contains(row)) continue;
    incidence.row = static_cast<Index>(group.rows.count_below(row));
    own.push_back(incidence);
  }
  return {own,
          group.inverse_mass,
          RowIslands(group.island_start, group.rows.size()),
          Ordering::Auto,
          group.constraints.squared_gradient_norms(),
          PointPlaces{problem.positions, problem.numbering.user_point}};
}

}  // namespace

SparseSolver::SparseSolver(const SchurProblem& problem, IslandGroup given)
    : IslandSolver(std::move(given)),
      solver_(make_solver(problem, group_)),
      has_constant_gradients_(group_.constraints.gradients_are_constant(group_.members)),
      own_rows_(group_.rows.size()),
      rows_(group_.constraints.num_rows()),
      dw_(3 * group_.inverse_mass.size()) {
  const std::size_t count = group_.num_islands();
  summary_ = {.solvers = {LinearSolver::General},
              .reason = std::to_string(count) + (count == 1 ? " island of " : " islands of ") +
                        std::to_string(group_.rows.size()) + (count == 1 ? " rows is" : " rows are") +
                        " left to sparse factors",
              .factor = solver_.summary().factor};
}

Elimination SparseSolver::solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks,
                                double* b, double* lambda, double* w) {
  const bool keeps = use == FactorUse::Keep;
  bring_points(parallel, motion.source);
  Elimination result;
  group_.points.for_ranges(parallel, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; motion.uniform != nullptr && i < end; ++i) store(w, i, *motion.uniform);
  });
  result.largest_right_side = group_.constraints.evaluate_right_side(parallel, group_.members, motion.r, motion.v, w, b,
                                                                     keeps ? nullptr : blocks);
  if (!std::isfinite(result.largest_right_side)) return result;
  if (!keeps) (void)factorize(parallel, blocks);
  result.reciprocal_condition = reciprocal_condition_;
  if (!(reciprocal_condition_ > 0.0)) return result;
  solve_negative(parallel, b, lambda);
  // dw = M^-1 K lambda, rho = K'dw + b, and lambda -= S^-1 rho while rho is more than rounding: other islands need
  // none.
  constexpr int most_passes = 3;
  group_.gather.write_scaled(parallel, blocks, lambda, group_.inverse_mass.data(), group_.points, dw_.data());
  result.refinements = refine_solution(
      {most_passes},
      [&] {
        return result.residual =
                   group_.constraints.apply_transposed(parallel, group_.members, blocks, dw_.data(), b, rows_.data());
      },
      [&](double residual) { return residual <= good_enough(false) * result.largest_right_side; },
      [&](int) {
        correct(parallel, blocks, rows_.data(), dw_.data());
        group_.add_rows(parallel, rows_.data(), lambda);
      });
  result.own_residual =
      group_.num_islands() == 1 ? own_residual(result.residual, result.largest_right_side) : cannot_tell;
  // w = w0 + M^-1 K lambda (25)
  group_.points.for_ranges(parallel, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = 3 * begin; i < 3 * end; ++i) w[i] += dw_[i];
  });
  return result;
}

Elimination SparseSolver::factorize(const Parallel& parallel, const double* blocks) {
  if (!(is_factorized_ && has_constant_gradients_)) {
    solver_.assemble(parallel, blocks);
    const GramSolver::Quality quality = solver_.factorize(parallel);
    is_factorized_ = quality.positive_definite;
    reciprocal_condition_ = is_factorized_ ? quality.reciprocal_condition : 0.0;
  }
  return {.reciprocal_condition = reciprocal_condition_};
}

void SparseSolver::solve_negative(const Parallel& parallel, const double* b, double* x) {
  double* own = own_rows_.data();
  group_.rows.for_each([&](std::size_t begin, std::size_t end) { own = std::copy(b + begin, b + end, own); });
  own = own_rows_.data();
  solver_.solve_negative(parallel, own, own);
  group_.rows.for_each([&](std::size_t begin, std::size_t end) {
    std::copy_n(own, end - begin, x + begin);
    own += end - begin;
  });
}

}  // namespace tanor::detail
