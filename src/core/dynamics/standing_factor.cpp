#include "dynamics/standing_factor.hpp"

#include <cmath>

#include "base/stopwatch.hpp"
#include "schur/condition.hpp"
#include "schur/rod_rows.hpp"

namespace tanor::detail {

namespace {

SchurProblem problem_of(const Workspace& work) {
  const Model& model = work.model();
  return {work.constraints, model.gather,       model.incidences,
          model.numbering,  model.inverse_mass, model.system.positions};
}

}  // namespace

StandingFactor::StandingFactor(Workspace& work, const SolverOptions& options, std::vector<double>& blocks,
                               Contacts* contacts)
    : work_(work),
      model_(work.model()),
      blocks_(blocks),
      composite_(make_composite_solver(problem_of(work), options)),
      all_rows_(work, options.ordering, blocks, contacts) {
  if (composite_.is_empty()) {
    GramSolver& S = all_rows_.gram();
    if (options.reuse) reuse_ = FactorReuse::make(work, S);
  }
  constexpr double solves = 2.0, flops_a_nonzero = 4.0;  // of one solve
  is_cheap_ = summary().flops <= solves * flops_a_nonzero * static_cast<double>(summary().factor_nonzeros);
}

// ---- making a factor ----

void StandingFactor::set_offsets(std::span<const Constraints::RowOffset> offsets) {
  work_.constraints.set_offsets(offsets);
  if (composite_.is_empty()) return;
  if (offsets_.empty()) offsets_ = RodRows(work_.constraints, model_.num_rows()).offset;
  for (const auto& [row, offset] : offsets) offsets_[row] = offset;
  composite_.read_offsets(offsets_);
}

/// Accepts a factor of the composite, unless it looks singular; then the factor of all rows decides.
bool StandingFactor::note_composite(double reciprocal_condition) {
  reciprocal_condition_ = reciprocal_condition;
  const bool is_fine = reciprocal_condition > all_rows_.suspect_below();
  state_ = is_fine ? State::Composite : State::None;
  return is_fine;
}

/// Notes that the factor of all rows was made anew.
void StandingFactor::note_sparse() {
  state_ = State::Sparse;
  reciprocal_condition_ = all_rows_.reciprocal_condition();
  if (reuse_ != nullptr) reuse_->note_factor();
}

Outcome StandingFactor::linearise(double t, const double* r, const PointSource* source) {
  bring_free_points(source);
  if (may_be_of_composite()) {
    if (linearise_by_composite(r, source)) return {};
  } else {
    bring(model_.parallel, source, 0, model_.num_constrained());
  }
  {
    const Stopwatch watch(&work_.times.evaluate);
    work_.constraints.evaluate_gradients(model_.parallel, r, blocks_.data());
  }
  if (Outcome outcome = work_.check_contacts(t); !outcome.ok()) return outcome;
  return factorize(t, r);
}

/// Evaluates K at r and factorizes S. Returns false if S looks singular, so that the factor of all rows must decide.
bool StandingFactor::linearise_by_composite(const double* r, const PointSource* source) {
  const Stopwatch watch(&work_.times.factor);
  ++work_.counters.factorizations;
  return note_composite(composite_.linearise(model_.parallel, r, source, blocks_.data()).reciprocal_condition);
}

/// Does the same and computes lambda and w. `use` may be Keep if the present factor is the composite's. Returns nothing
/// if S looks singular.
std::optional<Elimination> StandingFactor::solve_by_composite(const FreeMotion& motion, FactorUse use, double* b,
                                                              double* lambda, double* w) {
  bring_free_points(motion.source);
  const Stopwatch watch(&work_.times.solve);
  const bool renews = use == FactorUse::Renew;
  if (renews && is_needed()) ++work_.counters.factorizations;
  ++work_.counters.solves;
  const Elimination found = composite_.solve(model_.parallel, motion, use, blocks_.data(), b, lambda, w);
  work_.counters.solves += static_cast<std::size_t>(found.refinements);
  if (renews) reciprocal_condition_ = found.reciprocal_condition;
  if (std::isfinite(found.largest_right_side) && !note_composite(reciprocal_condition_)) return std::nullopt;
  return found;
}

Outcome StandingFactor::factorize(double t, const double* r) {
  Outcome outcome = all_rows_.factorize(t, r);
  note_sparse();
  if (!outcome.ok()) state_ = State::None;
  return outcome;
}

void StandingFactor::freshen() {
  if (state_ != State::Stale) return;
  all_rows_.factorize_again();
  note_sparse();
}

bool StandingFactor::decide_rank_again(const double* r) {
  const bool is_new = all_rows_.decide_rank_again(r);
  if (is_new) note_sparse();
  return is_new;
}

bool StandingFactor::decide_whole_rank(const double* r) {
  const bool is_new = all_rows_.decide_whole_rank(r);
  if (is_new) note_sparse();
  return is_new;
}

bool StandingFactor::share_loads() {
  if (!all_rows_.share_loads()) return false;
  all_rows_.factorize_again();
  note_sparse();
  return true;
}

// ---- using a factor of another configuration ----

bool StandingFactor::solve_with_old_factor(double t, const double* b, std::vector<double>* lambda, double* dw) {
  const bool serves = reuse_ != nullptr && state_ != State::None && !all_rows_.redundancy().is_found() &&
                      reuse_->serves(reciprocal_condition_);
  if (!serves) return false;
  if (!reuse_->solve(t, state_ == State::Sparse, blocks_.data(), b, lambda, dw)) return false;
  state_ = State::Stale;
  return true;
}

// ---- costs ----

void StandingFactor::describe(PlanSummary* plan) const {
  describe_factor(summary(), plan);
  if (composite_.is_empty()) return;
  plan->linear_solvers = composite_.summary().solvers;
  plan->linear_solver_reason = composite_.summary().reason;
}

double StandingFactor::estimate_reciprocal_condition() {
  const auto estimate = [&](SchurFactor& factor) {
    return detail::estimate_reciprocal_condition(problem_of(work_), model_.parallel, blocks_.data(), factor);
  };
  if (state_ == State::Composite) return estimate(composite_);
  // The factor of S does not contain the rows that QR solves.
  return all_rows_.redundancy().uses_qr() ? estimate(all_rows_) : all_rows_.gram().estimate_reciprocal_condition();
}

void StandingFactor::exchange_memory(Memory& memory) {
  all_rows_.exchange_memory(memory);
  if (reuse_ != nullptr) reuse_->exchange_memory(memory);
}

}  // namespace tanor::detail
