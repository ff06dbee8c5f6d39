#include "dynamics/linearization.hpp"

#include <algorithm>

#include "base/stopwatch.hpp"
#include "schur/refinement.hpp"

namespace tanor::detail {

Linearization::Linearization(Workspace& work, const SolverOptions& options, Contacts* contacts)
    : work_(work),
      model_(work.model()),
      contacts_(contacts),
      blocks_(3 * work.constraints.num_blocks()),
      factor_(work, options, blocks_, contacts),
      conjugate_(work, factor_.all_rows(), blocks_),
      rows_(model_.num_rows()) {}

// ---- the configuration ----

Outcome Linearization::update(double t, const double* r, const PointSource* source) {
  work_.set_time(t);
  if (model_.num_rows() == 0 || !factor_.is_needed()) {
    bring(model_.parallel, source, 0, model_.num_points());
    return {};
  }
  work_.constraints.choose_frames();
  return factor_.linearise(t, r, source);
}

// ---- solutions ----

void Linearization::apply_factor(const double* b, double* x) {
  factor_.freshen();
  factor_->solve_negative(model_.parallel, b, x);
}

void Linearization::solve_negative(const double* b, double* x) {
  if (!shares_loads()) return apply_factor(b, x);
  right_side_.assign(b, b + model_.num_rows());
  points_.resize(3 * model_.num_points());
  solve_refined(right_side_.data(), x, points_.data());
}

/// Computes rho = K'dw + b, lambda -= S^-1 rho, dw -= M^-1 K S^-1 rho in each pass.
void Linearization::solve_refined(const double* b, double* lambda, double* dw) {
  const std::size_t num_rows = model_.num_rows();
  std::fill(lambda, lambda + num_rows, 0.0);
  std::fill(dw, dw + 3 * model_.num_points(), 0.0);
  std::copy(b, b + num_rows, rows_.begin());
  if (num_rows == 0) return;
  refine_solution(
      shares_loads() ? 5 : 3, [&] { apply_transposed(dw, b, rows_.data()); },
      [&](int pass) {
        correct_conjugately(pass == 0, rows_.data(), dw);
        for (std::size_t a = 0; a < num_rows; ++a) lambda[a] += rows_[a];
      });
}

void Linearization::correct(double* rows, double* points) {
  const Stopwatch watch(&work_.times.solve);
  ++work_.counters.solves;
  if (factor_.correct_with_old_factor(rows, points)) return;
  factor_.freshen();
  factor_->correct(model_.parallel, blocks_.data(), rows, points);
}

void Linearization::correct_conjugately(bool begins, double* rows, double* points) {
  if (shares_loads()) return conjugate_.correct(begins, rows, points);
  correct(rows, points);
}

void Linearization::add_reactions(const double* rows, double* points) {
  factor_->add_reactions(model_.parallel, blocks_.data(), rows, points);
}

void Linearization::write_reactions(const double* rows, double* points) const {
  model_.gather.write_scaled(model_.parallel, blocks_.data(), rows, model_.inverse_mass.data(), model_.num_moving(),
                             points);
}

// ---- violations ----

double Linearization::evaluate_values(const double* r, double* xi) {
  const Stopwatch watch(&work_.times.evaluate);
  return factor_.evaluator().evaluate_values(model_.parallel, r, xi);
}

double Linearization::evaluate_rates(const double* r, const double* v, double* rates) {
  const Stopwatch watch(&work_.times.evaluate);
  return factor_.evaluator().evaluate_rates(model_.parallel, r, v, rates);
}

std::optional<Projection> Linearization::project_positions(double target, double* r, const PointSource* source,
                                                           double* sum) {
  SchurSolver* const solver = factor_.solver_by_islands();
  const std::size_t num_brought = solver != nullptr ? model_.num_constrained() : 0;
  bring(model_.parallel, source, num_brought, model_.num_points());
  if (solver == nullptr) {
    if (sum != nullptr) add_reactions(sum, r);
    return std::nullopt;
  }
  const Stopwatch watch(&work_.times.solve);
  const Projection found = solver->project_positions(model_.parallel, blocks_.data(), target, r, source, sum);
  work_.counters.solves += static_cast<std::size_t>(found.iterations);
  return found;
}

std::optional<Projection> Linearization::project_velocities(double target, const double* r, double* v, double* sum) {
  SchurSolver* const solver = factor_.solver_by_islands();
  if (solver == nullptr) return std::nullopt;
  const Stopwatch watch(&work_.times.solve);
  const Projection found = solver->project_velocities(model_.parallel, blocks_.data(), target, r, v, sum);
  work_.counters.solves += static_cast<std::size_t>(found.iterations);
  return found;
}

}  // namespace tanor::detail
