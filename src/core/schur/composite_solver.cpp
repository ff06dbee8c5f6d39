#include "schur/composite_solver.hpp"

#include <tanor/error.hpp>

#include <algorithm>
#include <numeric>

#include "plan/thresholds.hpp"
#include "schur/lane_solver.hpp"
#include "schur/point_solver.hpp"
#include "schur/sparse_solver.hpp"

namespace tanor::detail {

namespace {

/// Makes sparse factors of the islands that are left over. Returns null if they are too much of the system.
std::unique_ptr<SchurSolver> make_sparse_solver(const SchurProblem& problem, const std::vector<Index>& left) {
  IslandGroup group(problem, left);
  const auto num_left = static_cast<double>(group.rows.size());
  const double num_special = static_cast<double>(problem.numbering.num_rows()) - num_left;
  if (num_left > plan::most_sparse_rows * num_special) return nullptr;
  auto result = std::make_unique<SparseSolver>(problem, std::move(group));
  if (result->factor().products > plan::most_sparse_products * num_special) return nullptr;
  return result;
}

}  // namespace

CompositeSolver::CompositeSolver(std::vector<std::unique_ptr<SchurSolver>> solvers) : solvers_(std::move(solvers)) {
  for (const auto& solver : solvers_) {
    const Summary& each = solver->summary();
    summary_.solvers.insert(summary_.solvers.end(), each.solvers.begin(), each.solvers.end());
    summary_.reason += (summary_.reason.empty() ? "" : "; ") + each.reason;
    summary_.factor.include(each.factor);
  }
  if (summary_.factor.orderings.empty()) summary_.factor.orderings = {Ordering::Natural};
}

CompositeSolver make_composite_solver(const SchurProblem& problem, const SolverOptions& wanted) {
  const bool is_forced = wanted.linear_solver != LinearSolver::Auto;
  const auto refuse = [&](const std::string& why) -> CompositeSolver {
    if (is_forced) throw InputError("/solver/linear_solver", "it does not serve this system: " + why);
    return CompositeSolver();
  };
  const Numbering& numbering = problem.numbering;
  if (wanted.linear_solver == LinearSolver::General || wanted.linear_solver == LinearSolver::Cholmod ||
      (!is_forced && numbering.num_rows() < plan::fewest_rows))
    return CompositeSolver();
  if (wanted.ordering != Ordering::Auto) return refuse("an ordering is asked for, which belongs to the general solver");
  if (numbering.num_rows() == 0) return refuse("there are no constraints");
  if (numbering.first_idle_row() < numbering.num_rows()) return refuse("some constraints join supports alone");
  if (problem.constraints.tangents().size() > 0) return refuse("contacts with friction have rows that come and go");
  if (!numbering.one_sided.empty()) return refuse("constraints to one side have rows that come and go");

  // Each solver takes the islands that it serves out of those that are left.
  std::vector<Index> left(numbering.num_islands());
  std::iota(left.begin(), left.end(), 0);
  std::vector<std::unique_ptr<SchurSolver>> solvers;
  const auto add = [&](LinearSolver kind, const auto& make) {
    if (is_forced && wanted.linear_solver != kind) return;
    if (std::unique_ptr<SchurSolver> solver = make()) solvers.push_back(std::move(solver));
  };
  add(LinearSolver::ClosedForm, [&] { return PointSolver::make(problem, &left); });
  for (const LinearSolver kind : {LinearSolver::Batches, LinearSolver::Paths, LinearSolver::Trees})
    add(kind, [&] { return LaneSolver::make(problem, kind, wanted.threads, is_forced, &left); });
  if (!left.empty()) {
    if (is_forced) return refuse("some islands have another structure");
    std::unique_ptr<SchurSolver> sparse = solvers.empty() ? nullptr : make_sparse_solver(problem, left);
    if (sparse == nullptr) return CompositeSolver();
    solvers.push_back(std::move(sparse));
  }
  return CompositeSolver(std::move(solvers));
}

}  // namespace tanor::detail
