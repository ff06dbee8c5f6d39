#include "schur/reuse.hpp"

#include <algorithm>
#include <utility>

#include "plan/thresholds.hpp"

namespace tanor::detail {

namespace {

GatherPlan plan_in_order_of_rows(const GramOperator& S, std::span<const Incidence> incidences) {
  const std::vector<Incidence> moving = group_by_point(incidences, S.inverse_mass);
  return {list_products(moving, S.inverse_mass, 0),
          S.num_rows,
          {},
          Triangle::Upper,
          S.constraints.squared_gradient_norms()};
}

/// Returns the multiplications of an iteration: two products with K, sums of vectors, and the preconditioner.
double iteration_products(const GramSolver::Summary& factor, std::size_t num_rows, std::size_t num_incidences) {
  return 9.0 * static_cast<double>(num_incidences) + 5.0 * static_cast<double>(num_rows) +
         2.0 * static_cast<double>(factor.factor.pattern_nonzeros);
}

}  // namespace

Reuse::Reuse(const GramOperator& S, std::span<const Incidence> incidences, const GramSolver::Summary& factor)
    : S_(S),
      incidences_(incidences),
      conjugate_gradients_(S),
      factor_products_(factor.products),
      products_(iteration_products(factor, S.num_rows, incidences.size())),
      history_(S.constraints.num_rows()),
      correction_(S.constraints.num_rows()) {
  forget();
}

bool Reuse::pays(const GramSolver::Summary& factor, std::size_t num_rows, std::size_t num_incidences) {
  return plan::first_guess_of_iterations * iteration_products(factor, num_rows, num_incidences) < factor.products;
}

void Reuse::forget() {
  mean_iterations_ = plan::first_guess_of_iterations;
  history_.forget();
}

/// Returns the limit of iterations; more would cost more than the factor.
int Reuse::most_iterations() const {
  return 1 + static_cast<int>(std::min(plan::most_iterations_of_reuse, factor_products_ / products_));
}

bool Reuse::make_incomplete(const double* blocks) {
  if (is_renewed_) return true;
  if (incomplete_ == nullptr) {
    GatherPlan plan = plan_in_order_of_rows(S_, incidences_);
    TrianglePattern pattern{plan.column_start(), plan.rows()};
    incomplete_.reset(new IncompleteFactor{std::move(plan), IncompleteCholesky(std::move(pattern))});
  }
  incomplete_->plan.assemble(blocks, incomplete_->factor.values());
  return is_renewed_ = incomplete_->factor.factorize();
}

bool Reuse::solve(const Parallel& parallel, double t, const double* blocks, const double* b, double allowed,
                  std::vector<double>* lambda, double* dw) {
  num_iterations_ = 0;
  if (mean_iterations_ * products_ >= factor_products_) {
    mean_iterations_ *= plan::fading_of_mean;
    return false;
  }
  const auto not_again_soon = [&] { mean_iterations_ = 2.0 * factor_products_ / products_; };
  if (!make_incomplete(blocks)) {
    not_again_soon();
    return false;
  }
  history_.extrapolate(parallel, t, lambda);
  const ConjugateGradients::Result result =
      iterate(parallel, blocks, b, {allowed, 0.0, most_iterations()}, lambda->data(), dw);
  if (result.has_converged) {
    constexpr double kept = plan::weight_of_mean;
    mean_iterations_ = kept * mean_iterations_ + (1.0 - kept) * std::max(1, result.iterations);
    history_.add(t, *lambda);
  } else {
    not_again_soon();
  }
  return result.has_converged;
}

bool Reuse::correct(const Parallel& parallel, const double* blocks, double* rows, double* dw) {
  constexpr double five_digits = 1e-5;
  std::fill(correction_.begin(), correction_.end(), 0.0);
  const ConjugateGradients::Result result =
      iterate(parallel, blocks, rows, {0.0, five_digits, most_iterations()}, correction_.data(), dw);
  if (result.has_converged) std::copy(correction_.begin(), correction_.end(), rows);
  return result.has_converged;
}

ConjugateGradients::Result Reuse::iterate(const Parallel& parallel, const double* blocks, const double* b,
                                          const ConjugateGradients::Target& target, double* lambda, double* dw) {
  const ConjugateGradients::Result result = conjugate_gradients_.solve(
      parallel, blocks, b, target,
      [&](const double* rho, double* z) {
        incomplete_->factor.solve_negative(incomplete_->plan.scale().data(), rho, z);
      },
      lambda, dw);
  num_iterations_ = static_cast<std::size_t>(result.iterations);
  return result;
}

void Reuse::exchange_memory(Memory& memory) {
  memory.exchange(mean_iterations_);
  history_.exchange_memory(memory);
}

}  // namespace tanor::detail
