#include "dynamics/linearization.hpp"

#include <algorithm>
#include <cmath>

#include "base/stopwatch.hpp"
#include "schur/condition.hpp"
#include "schur/refinement.hpp"

namespace tanor {

namespace {

SchurProblem problem_of(const Workspace& work) {
  const Model& model = work.model();
  return {work.constraints, model.gather,       model.incidences,
          model.numbering,  model.inverse_mass, model.system.positions};
}

}  // namespace

Linearization::Linearization(Workspace& work, const SolverOptions& options, ContactState* contacts)
    : work_(work),
      model_(work.model()),
      blocks_(3 * work.constraints.num_blocks()),
      composite_(make_composite_solver(problem_of(work), options)),
      factor_(work, options.ordering, blocks_, contacts),
      evaluator_(composite_.empty() ? static_cast<SchurFactor&>(factor_) : composite_),
      conjugate_(work, factor_, blocks_),
      rows_(model_.num_rows()) {
  if (composite_.empty()) (void)factor_.gram();
  if (composite_.empty() && options.reuse) reuse_ = FactorReuse::make(work, factor_.gram());
  PlanSummary plan;
  describe(&plan);
  is_cheap_ = plan.factor_flops <= 2.0 * 4.0 * static_cast<double>(plan.factor_nonzeros);
}

// ---- the configuration ----

/// A factor of the composite that looks singular is none: the factor of all rows decides.
bool Linearization::note_composite(double reciprocal_condition) {
  reciprocal_condition_ = reciprocal_condition;
  const bool is_fine = reciprocal_condition > factor_.suspect_below();
  state_ = is_fine ? FactorState::Composite : FactorState::None;
  return is_fine;
}

/// Returns what it is given: whether the factor of all rows was made anew.
bool Linearization::note_sparse(bool is_factorized) {
  if (!is_factorized) return false;
  state_ = FactorState::Sparse;
  reciprocal_condition_ = factor_.reciprocal_condition();
  if (reuse_ != nullptr) reuse_->note_factor();
  return true;
}

Outcome Linearization::update(double t, const double* r, const PointSource* source) {
  work_.set_time(t);
  const bool is_needed = model_.num_rows() > 0 && needs_factor();
  if (!is_needed || !serves_at_once()) bring_all(source);
  if (!is_needed) return {};
  work_.constraints.choose_frames();
  if (serves_at_once()) {
    bring_free_points(source);
    const Stopwatch watch(&work_.times.factor);
    ++work_.counters.factorizations;
    if (note_composite(composite_.linearise(model_.parallel, r, source, blocks_.data()).reciprocal_condition))
      return {};
  }
  {
    const Stopwatch watch(&work_.times.evaluate);
    work_.constraints.evaluate_gradients(model_.parallel, r, blocks_.data());
  }
  if (Outcome outcome = work_.check_contacts(t); !outcome.ok()) return outcome;
  return factorize(t, r);
}

Outcome Linearization::factorize(double t, const double* r) {
  Outcome outcome = factor_.factorize(t, r);
  (void)note_sparse(true);
  if (!outcome.ok()) state_ = FactorState::None;
  return outcome;
}

std::optional<Elimination> Linearization::eliminate(const FreeMotion& motion, Gradients gradients, double* b,
                                                    double* lambda, double* w) {
  const bool keeps = gradients == Gradients::Keep;
  bring_free_points(motion.source);
  const Stopwatch watch(&work_.times.solve);
  if (!keeps && needs_factor()) ++work_.counters.factorizations;
  ++work_.counters.solves;
  const Elimination found = composite_.solve(model_.parallel, motion, keeps ? FactorUse::Keep : FactorUse::Renew,
                                             blocks_.data(), b, lambda, w);
  work_.counters.solves += static_cast<std::size_t>(found.refinements);
  if (!keeps) reciprocal_condition_ = found.reciprocal_condition;
  if (std::isfinite(found.largest_right_side) && !note_composite(reciprocal_condition_)) return std::nullopt;
  return found;
}

// ---- solutions ----

void Linearization::solve_negative(const double* b, double* x) {
  if (state_ == FactorState::Stale) {
    factor_.factorize_again();
    (void)note_sparse(true);
  }
  standing().solve_negative(model_.parallel, b, x);
}

/// A compliant factor solves S x = -b by its refinement alone.
void Linearization::solve_negative(double* rows) {
  if (!factor_.is_compliant()) return solve_negative(rows, rows);
  right_side_.assign(rows, rows + model_.num_rows());
  points_.resize(3 * model_.num_points());
  solve_refined(right_side_.data(), rows, points_.data());
}

/// rho = K'dw + b, lambda -= S^-1 rho, dw -= M^-1 K S^-1 rho
void Linearization::solve_refined(const double* b, double* lambda, double* dw) {
  const std::size_t num_rows = model_.num_rows();
  std::fill(lambda, lambda + num_rows, 0.0);
  std::fill(dw, dw + 3 * model_.num_points(), 0.0);
  std::copy(b, b + num_rows, rows_.begin());
  if (num_rows == 0) return;
  refine_solution(
      factor_.is_compliant() ? 5 : 3, [&] { apply_transposed(dw, b, rows_.data()); },
      [&](int pass) {
        correct_conjugately(pass == 0, rows_.data(), dw);
        for (std::size_t a = 0; a < num_rows; ++a) lambda[a] += rows_[a];
      });
}

void Linearization::correct(double* rows, double* points) {
  const Stopwatch watch(&work_.times.solve);
  ++work_.counters.solves;
  if (state_ == FactorState::Stale) {
    if (reuse_->correct(blocks_.data(), rows, points)) return;
    factor_.factorize_again();
    (void)note_sparse(true);
  }
  standing().correct(model_.parallel, blocks_.data(), rows, points);
}

void Linearization::correct_conjugately(bool begins, double* rows, double* points) {
  if (factor_.is_compliant()) return conjugate_.correct(begins, rows, points);
  correct(rows, points);
}

void Linearization::add_reactions(const double* rows, double* points) {
  standing().add_reactions(model_.parallel, blocks_.data(), rows, points);
}

void Linearization::write_reactions(const double* rows, double* points) const {
  model_.gather.write_scaled(model_.parallel, blocks_.data(), rows, model_.inverse_mass.data(), model_.num_moving(),
                             points);
}

// ---- violations ----

double Linearization::evaluate_values(const double* r, double* xi) {
  const Stopwatch watch(&work_.times.evaluate);
  return evaluator_.evaluate_values(model_.parallel, r, xi);
}

double Linearization::evaluate_rates(const double* r, const double* v, double* rates) {
  const Stopwatch watch(&work_.times.evaluate);
  return evaluator_.evaluate_rates(model_.parallel, r, v, rates);
}

Projection Linearization::project_positions(double target, double* r, const PointSource* source, double* sum) {
  bring_free_points(source);
  const Stopwatch watch(&work_.times.solve);
  const Projection found = standing().project_positions(model_.parallel, blocks_.data(), target, r, source, sum);
  work_.counters.solves += static_cast<std::size_t>(found.iterations);
  return found;
}

Projection Linearization::project_velocities(double target, const double* r, double* v, double* sum) {
  const Stopwatch watch(&work_.times.solve);
  const Projection found = standing().project_velocities(model_.parallel, blocks_.data(), target, r, v, sum);
  work_.counters.solves += static_cast<std::size_t>(found.iterations);
  return found;
}

// ---- factors of other configurations ----

bool Linearization::solve_with_old_factor(double t, const double* b, std::vector<double>* lambda, double* dw) {
  const bool serves = reuse_ != nullptr && state_ != FactorState::None && !factor_.redundancy().is_found() &&
                      reuse_->serves(reciprocal_condition_);
  if (!serves) return false;
  if (!reuse_->solve(t, state_ == FactorState::Sparse, blocks_.data(), b, lambda, dw)) return false;
  state_ = FactorState::Stale;
  return true;
}

bool Linearization::make_compliant() {
  if (!factor_.make_compliant()) return false;
  factor_.factorize_again();
  return note_sparse(true);
}

// ---- what it costs ----

void Linearization::describe(PlanSummary* plan) const {
  if (composite_.empty()) return describe_factor(factor_.summary(), plan);
  const SchurSolver::Summary& summary = composite_.summary();
  plan->linear_solvers = summary.solvers;
  plan->linear_solver_reason = summary.reason;
  plan->orderings = summary.orderings;
  plan->parts = summary.parts;
  plan->pattern_nonzeros = summary.pattern_nonzeros;
  plan->factor_nonzeros = summary.factor_nonzeros;
  plan->factor_flops = summary.flops;
}

double Linearization::estimate_reciprocal_condition() {
  if (state_ != FactorState::Composite) return factor_.gram().estimate_reciprocal_condition();
  return tanor::estimate_reciprocal_condition(problem_of(work_), model_.parallel, blocks_.data(), composite_);
}

void Linearization::exchange_memory(Memory& memory) {
  factor_.exchange_memory(memory);
  if (reuse_ != nullptr) reuse_->exchange_memory(memory);
}

}  // namespace tanor
