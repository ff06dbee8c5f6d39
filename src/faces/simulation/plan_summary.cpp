#include <tanor/enum_names.hpp>

namespace tanor {
using namespace detail;

std::string PlanSummary::linear_solver() const {
  return names_of(linear_solvers);
}

std::string PlanSummary::ordering() const {
  return orderings.empty() ? "none" : names_of(orderings);
}

std::string PlanSummary::factorization() const {
  if (linear_solvers != std::vector{LinearSolver::General}) return linear_solver();
  return factorizations.empty() ? "none" : names_of(factorizations);
}

}  // namespace tanor
