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
      factor_products_(factor.products),
      products_(iteration_products(factor, S.num_rows, incidences.size())),
      history_(S.constraints.num_rows()),
      correction_(S.constraints.num_rows()) {
  for (std::vector<double>* array : {&rho_, &z_, &p_, &q_}) array->resize(correction_.size(), 0.0);
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
  const bool has_converged = iterate(parallel, blocks, b, allowed, 0.0, lambda->data(), dw);
  if (has_converged) {
    constexpr double kept = plan::weight_of_mean;
    mean_iterations_ = kept * mean_iterations_ + (1.0 - kept) * std::max(1, num_iterations_);
    history_.add(t, *lambda);
  } else {
    not_again_soon();
  }
  return has_converged;
}

bool Reuse::correct(const Parallel& parallel, const double* blocks, double* rows, double* dw) {
  constexpr double five_digits = 1e-5;
  std::fill(correction_.begin(), correction_.end(), 0.0);
  const bool has_converged = iterate(parallel, blocks, rows, 0.0, five_digits, correction_.data(), dw);
  if (has_converged) std::copy(correction_.begin(), correction_.end(), rows);
  return has_converged;
}

/// Replaces a guess `lambda` by the solution and computes dw. The iteration ends when sqrt(rho'P^-1 rho), which would
/// be the error of dw in the M-norm if P were S, is at most `allowed`, or `reduction` times its first value. Returns
/// false if that takes too many iterations, or if S or P is not positive definite to rounding.
bool Reuse::iterate(const Parallel& parallel, const double* blocks, const double* b, double allowed, double reduction,
                    double* lambda, double* dw) {
  constexpr double surely = 0.3;
  std::fill(lambda + S_.num_rows, lambda + rho_.size(), 0.0);
  S_.add_up(parallel, blocks, lambda, dw);
  S_.constraints.apply_transposed(parallel, blocks, dw, b, rho_.data());
  bool has_converged = false;
  double allowed2 = allowed * allowed, before = 0.0, rho2 = dot(parallel, rho_, rho_);
  for (num_iterations_ = 0; !has_converged && num_iterations_ < most_iterations(); ++num_iterations_) {
    incomplete_->factor.solve_negative(incomplete_->plan.scale().data(), rho_.data(), z_.data());
    const double error2 = -dot(parallel, rho_, z_);
    if (num_iterations_ == 0) allowed2 = std::max(allowed2, reduction * reduction * error2);
    has_converged = error2 >= 0.0 && error2 <= allowed2;
    if (has_converged || !(error2 > 0.0)) break;
    if (!advance(parallel, blocks, error2, num_iterations_ == 0 ? 0.0 : error2 / before, lambda, dw)) break;
    before = error2;
    // The error falls as |rho| does. If it is surely small enough, the preconditioner is not needed once more.
    const double rho2_before = std::exchange(rho2, dot(parallel, rho_, rho_));
    has_converged = rho2 / rho2_before * error2 <= surely * allowed2;
  }
  S_.add_up(parallel, blocks, lambda, dw);
  return has_converged;
}

/// Returns x'y. Eight sums run side by side, so that additions need not wait for those before.
double Reuse::dot(const Parallel& parallel, const std::vector<double>& x, const std::vector<double>& y) const {
  constexpr std::size_t width = 8;
  const double *const a = x.data(), *const b = y.data();
  const std::size_t whole = S_.num_rows / width;
  double result = parallel.sum(
      whole,
      [&](std::size_t k) {
        const double *const u = a + width * k, *const v = b + width * k;
        return ((u[0] * v[0] + u[1] * v[1]) + (u[2] * v[2] + u[3] * v[3])) +
               ((u[4] * v[4] + u[5] * v[5]) + (u[6] * v[6] + u[7] * v[7]));
      },
      1024);
  for (std::size_t k = width * whole; k < S_.num_rows; ++k) result += a[k] * b[k];
  return result;
}

/// Computes p = z + beta p, lambda += alpha p and rho += alpha S p. Returns false if p'S p is not positive. dw is
/// scratch.
bool Reuse::advance(const Parallel& parallel, const double* blocks, double error2, double beta, double* lambda,
                    double* dw) {
  parallel.for_ranges(S_.num_rows, [&](std::size_t begin, std::size_t end) {
    for (std::size_t a = begin; a < end; ++a) p_[a] = z_[a] + beta * p_[a];
  });
  S_.add_up(parallel, blocks, p_.data(), dw);
  S_.constraints.apply_transposed(parallel, blocks, dw, nullptr, q_.data());
  const double curvature = dot(parallel, p_, q_);
  if (!(curvature > 0.0)) return false;
  const double alpha = error2 / curvature;
  parallel.for_ranges(S_.num_rows, [&](std::size_t begin, std::size_t end) {
    for (std::size_t a = begin; a < end; ++a) {
      lambda[a] += alpha * p_[a];
      rho_[a] += alpha * q_[a];
    }
  });
  return true;
}

void Reuse::exchange_memory(Memory& memory) {
  memory.exchange(mean_iterations_);
  history_.exchange_memory(memory);
}

}  // namespace tanor::detail
