#include "ranks/cut_linearization.hpp"

#include <algorithm>

#include "base/stopwatch.hpp"
#include "base/text.hpp"
#include "dynamics/motion_series.hpp"

namespace tanor::detail {

CutLinearization::CutLinearization(Workspace& work, const Part& part, Ordering ordering)
    : work_(work),
      model_(work.model()),
      agreement_(*part.ranks),
      guests_(part, model_.numbering),
      solver_(model_, part, ordering, agreement_.all(work.constraints.gradient_norms_are_constant())),
      rank_(work, part, agreement_),
      blocks_(3 * work.constraints.num_blocks()),
      has_constant_gradients_(agreement_.all(work.constraints.gradients_are_constant())),
      right_side_(model_.num_rows()),
      move_(3 * model_.num_points()) {}

Outcome CutLinearization::update(double t, const double* r) {
  work_.set_time(t);
  if (!needs_factor()) return {};
  work_.constraints.choose_frames();
  {
    const Stopwatch watch(&work_.times.evaluate);
    work_.constraints.evaluate_gradients(model_.parallel, r, blocks_.data());
  }
  return factorize(t, r);
}

Outcome CutLinearization::factorize(double t, const double* r) {
  has_factor_ = factorize_rows();
  if (!has_factor_ && !agreement_.all(is_finite(blocks_)))
    return {Status::Singular, "some constraint has no gradient at t = " + text(t)};
  // If rows depend on others, S has pivots of the size of rounding.
  if (!has_factor_ && rank_.decide(blocks_.data(), r)) {
    solver_.set_active(rank_.active_rows());
    has_factor_ = factorize_rows();
  }
  if (has_factor_) return {};
  return {Status::Singular,
          "constraints that several ranks share are singular to rounding at t = " + text(t) + "; take one rank"};
}

/// Factorizes. Returns true if S is definite, and not singular to rounding, on all ranks.
bool CutLinearization::factorize_rows() {
  constexpr double poor = 1e-12;
  const Stopwatch watch(&work_.times.factor);
  ++work_.counters.factorizations;
  const CutSolver::Quality quality = solver_.factorize(blocks_.data());
  reciprocal_condition_ = quality.reciprocal_condition;
  return agreement_.all(quality.own_is_definite && quality.shared_is_definite && quality.reciprocal_condition > poor);
}

bool CutLinearization::decide_rank_again(double t, const double* r) {
  if (!rank_.is_found() || !rank_.decide(blocks_.data(), r)) return false;
  solver_.set_active(rank_.active_rows());
  return factorize(t, r).ok();
}

void CutLinearization::solve(const double* b, double* x, double* dw) {
  ++work_.counters.solves;
  std::fill(x + model_.numbering.first_idle_row(), x + model_.num_rows(), 0.0);
  solver_.solve_negative(b, x);
  write_reactions(x, dw);
}

void CutLinearization::correct(double* rows, double* points) {
  right_side_.assign(rows, rows + model_.num_rows());
  solve(right_side_.data(), rows, move_.data());
  for (std::size_t i = 0; i < move_.size(); ++i) points[i] += move_[i];
}

void CutLinearization::write_reactions(const double* rows, double* dw) {
  std::fill(dw + 3 * model_.num_moving(), dw + 3 * model_.num_points(), 0.0);
  model_.gather.write_scaled(model_.parallel, blocks_.data(), rows, model_.inverse_mass.data(), model_.num_moving(),
                             dw);
  guests_.fetch(dw);
}

void CutLinearization::describe(PlanSummary* plan) const {
  plan->linear_solvers = {LinearSolver::General};
  plan->linear_solver_reason = text(solver_.num_all_shared()) + " equations are shared by several ranks";
  plan->parts = 1;
  plan->pattern_nonzeros = solver_.pattern_nonzeros();
  plan->factor_nonzeros = static_cast<std::size_t>(solver_.num_stored());
  plan->factorizations = {Factorization::Multifrontal};
}

}  // namespace tanor::detail
