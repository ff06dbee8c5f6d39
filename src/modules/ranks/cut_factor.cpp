#include "ranks/cut_factor.hpp"

#include <algorithm>

#include "base/stopwatch.hpp"
#include "base/text.hpp"
#include "dynamics/motion_series.hpp"

namespace tanor::detail {

CutFactor::CutFactor(Workspace& work, const Part& part, const SolverOptions& options, const std::vector<double>& blocks)
    : RankRevealingFactor(work, options, blocks, nullptr),
      solver_(model_, part, options.ordering, work.team().all(work.constraints.gradient_norms_are_constant())),
      rank_(work, part) {}

SchurSolver::Summary CutFactor::summarize() {
  return {{LinearSolver::General},
          text(solver_.num_all_shared()) + " equations are shared by several ranks",
          {.parts = 1,
           .pattern_nonzeros = solver_.pattern_nonzeros(),
           .factor_nonzeros = static_cast<std::size_t>(solver_.num_stored()),
           .factorizations = {Factorization::Multifrontal}}};
}

Outcome CutFactor::factorize(double t, const double* r) {
  if (factorize_rows()) return {};
  if (!work_.team().all(is_finite(blocks_)))
    return {Status::Singular, "some constraint has no gradient at t = " + text(t)};
  // If rows depend on others, S has pivots of the size of rounding.
  if (rank_.decide(blocks_, r)) {
    solver_.set_active(rank_.active_rows());
    if (factorize_rows()) return {};
  }
  return {Status::Singular,
          "constraints that several ranks share are singular to rounding at t = " + text(t) + "; take one rank"};
}

/// Factorizes. Returns true if S is definite, and not singular to rounding, on all ranks.
bool CutFactor::factorize_rows() {
  constexpr double poor = 1e-12;
  const Stopwatch watch(&work_.times.factor);
  ++work_.counters.factorizations;
  const CutSolver::Quality quality = solver_.factorize(blocks_.data());
  reciprocal_condition_ = quality.reciprocal_condition;
  return work_.team().all(quality.own_is_definite && quality.shared_is_definite && quality.reciprocal_condition > poor);
}

bool CutFactor::decide_rank_again(const double* r, RankScope scope) {
  if (scope == RankScope::DependentIslands && !rank_.is_found()) return false;
  if (!rank_.decide(blocks_, r)) return false;
  solver_.set_active(rank_.active_rows());
  return factorize_rows();
}

void CutFactor::solve_negative(const Parallel&, const double* b, double* x) {
  std::fill(x + model_.numbering.first_idle_row(), x + model_.num_rows(), 0.0);
  solver_.solve_negative(b, x);
}

}  // namespace tanor::detail
