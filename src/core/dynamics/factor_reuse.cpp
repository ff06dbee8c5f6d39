#include "dynamics/factor_reuse.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/stopwatch.hpp"
#include "plan/thresholds.hpp"

namespace tanor::detail {

std::unique_ptr<FactorReuse> FactorReuse::make(Workspace& work, const GramSolver::Summary& factor) {
  const Model& model = work.model();
  if (model.has_friction() || !model.numbering.one_sided.empty() || model.num_rows() == 0 ||
      work.constraints.gradients_are_constant())
    return nullptr;
  // An iteration takes two products with K, sums of vectors, and the preconditioner.
  const double products = 9.0 * static_cast<double>(model.incidences.size()) +
                          5.0 * static_cast<double>(model.numbering.first_idle_row()) +
                          2.0 * static_cast<double>(factor.factor.pattern_nonzeros);
  if (plan::first_guess_of_iterations * products >= factor.products) return nullptr;
  return std::unique_ptr<FactorReuse>(new FactorReuse(work, factor.products, products));
}

FactorReuse::FactorReuse(Workspace& work, double factor_products, double products)
    : work_(work),
      model_(work.model()),
      num_rows_(model_.numbering.first_idle_row()),
      factor_products_(factor_products),
      products_(products),
      history_(model_.num_rows()),
      correction_(model_.num_rows()),
      correction_w_(3 * model_.num_points(), 0.0) {
  for (std::vector<double>* array : {&rho_, &z_, &p_, &q_}) array->resize(model_.num_rows(), 0.0);
  sums_.reserve(work.scales.size());
  forget();
}

double FactorReuse::allowed_error(const StepTarget& target) {
  const double h = std::abs(target.h);
  const Scales& scales = work_.scales;
  const auto allowed_square = [&](std::size_t i) {
    const double atol_v = scales.velocity_tolerance(target.atol, i);
    const double atol_x = scales.position_tolerance(target.atol, i);
    const double in_v = (atol_v + target.rtol * norm(load(target.v, i))) / h;
    const double in_x = (atol_x + target.rtol * norm(load(target.x, i))) / (h * h);
    const double allowed = std::min(in_v, in_x);
    return model_.mass[i] * allowed * allowed;
  };
  if (scales.are_one()) return std::sqrt(model_.parallel.sum(model_.num_moving(), allowed_square));
  sums_.assign(scales.size(), 0.0);
  for (std::size_t i = 0; i < model_.num_moving(); ++i) sums_[scales.of_point(i)] += allowed_square(i);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < sums_.size(); ++k) {
    if (scales.has_rows(k) && sums_[k] > 0.0) least = std::min(least, sums_[k]);
  }
  return std::sqrt(least);
}

void FactorReuse::forget() {
  mean_iterations_ = plan::first_guess_of_iterations;
  history_.forget();
}

void FactorReuse::note_factor() {
  const std::size_t frames = work_.constraints.frames();
  if (frames_ && *frames_ != frames) forget();
  frames_ = frames;
}

bool FactorReuse::serves(double reciprocal_condition) const {
  constexpr double nearly_singular = 1e-8;
  return allowed_error_ > 0.0 && reciprocal_condition > nearly_singular && frames_ == work_.constraints.frames();
}

bool FactorReuse::make_incomplete(const double* blocks) {
  if (is_renewed_) return true;
  if (incomplete_ == nullptr) {
    const std::vector<Incidence> moving = group_by_point(model_.incidences, model_.inverse_mass);
    GatherPlan plan(list_products(moving, model_.inverse_mass, 0), num_rows_, {}, Triangle::Upper,
                    work_.constraints.squared_gradient_norms());
    TrianglePattern pattern{plan.column_start(), plan.rows()};
    incomplete_.reset(new IncompleteFactor{std::move(plan), IncompleteCholesky(std::move(pattern))});
  }
  incomplete_->plan.assemble(blocks, incomplete_->factor.values());
  return is_renewed_ = incomplete_->factor.factorize();
}

bool FactorReuse::solve(double t, bool is_first, const double* blocks, const double* b, std::vector<double>* lambda,
                        double* dw) {
  const Stopwatch watch(&work_.times.solve);
  if (is_first) is_renewed_ = false;
  if (mean_iterations_ * products_ >= factor_products_) {
    mean_iterations_ *= plan::fading_of_mean;
    return false;
  }
  bool is_solved = make_incomplete(blocks);
  if (is_solved) {
    history_.extrapolate(model_.parallel, t, lambda);
    is_solved = iterate(blocks, b, allowed_error_, 0.0, lambda->data(), dw);
  }
  if (!is_solved) {
    mean_iterations_ = 2.0 * factor_products_ / products_;  // not again soon
    return false;
  }
  constexpr double kept = plan::weight_of_mean;
  mean_iterations_ = kept * mean_iterations_ + (1.0 - kept) * std::max(1, num_iterations_);
  history_.add(t, *lambda);
  ++work_.counters.solves;
  return true;
}

bool FactorReuse::correct(const double* blocks, double* rows, double* points) {
  constexpr double five_digits = 1e-5;
  std::ranges::fill(correction_, 0.0);
  if (!iterate(blocks, rows, 0.0, five_digits, correction_.data(), correction_w_.data())) return false;
  std::ranges::copy(correction_, rows);
  model_.add_to_moving(correction_w_.data(), points);
  return true;
}

/// Computes dw = M^-1 K x [3n].
void FactorReuse::add_up(const double* blocks, const double* x, double* dw) const {
  model_.gather.write_scaled(model_.parallel, blocks, x, model_.inverse_mass.data(), model_.num_moving(), dw);
}

/// Replaces a guess `lambda` by the solution and computes dw. The iteration ends when sqrt(rho'P^-1 rho), which would
/// be the error of dw in the M-norm if P were S, is at most `allowed`, or `reduction` times its first value. Returns
/// false if that takes too many iterations, or if S or P is not positive definite to rounding.
bool FactorReuse::iterate(const double* blocks, const double* b, double allowed, double reduction, double* lambda,
                          double* dw) {
  constexpr double surely = 0.3;
  // More iterations would cost more than the factor.
  const int most = 1 + static_cast<int>(std::min(plan::most_iterations_of_reuse, factor_products_ / products_));
  std::fill(lambda + num_rows_, lambda + rho_.size(), 0.0);
  add_up(blocks, lambda, dw);
  work_.constraints.apply_transposed(model_.parallel, blocks, dw, b, rho_.data());
  bool has_converged = false;
  double allowed2 = allowed * allowed, before = 0.0, rho2 = dot(rho_, rho_);
  for (num_iterations_ = 0; !has_converged && num_iterations_ < most; ++num_iterations_) {
    incomplete_->factor.solve_negative(incomplete_->plan.scale().data(), rho_.data(), z_.data());
    const double error2 = -dot(rho_, z_);
    if (num_iterations_ == 0) allowed2 = std::max(allowed2, reduction * reduction * error2);
    has_converged = error2 >= 0.0 && error2 <= allowed2;
    if (has_converged || !(error2 > 0.0)) break;
    if (!advance(blocks, error2, num_iterations_ == 0 ? 0.0 : error2 / before, lambda, dw)) break;
    before = error2;
    // The error falls as |rho| does. If it is surely small enough, the preconditioner is not needed once more.
    const double rho2_before = std::exchange(rho2, dot(rho_, rho_));
    has_converged = rho2 / rho2_before * error2 <= surely * allowed2;
  }
  add_up(blocks, lambda, dw);
  work_.counters.iterations += static_cast<std::size_t>(num_iterations_);
  return has_converged;
}

/// Returns x'y. Eight sums run side by side, so that additions need not wait for those before.
double FactorReuse::dot(const std::vector<double>& x, const std::vector<double>& y) const {
  constexpr std::size_t width = 8;
  const double *const a = x.data(), *const b = y.data();
  const std::size_t whole = num_rows_ / width;
  double result = model_.parallel.sum(
      whole,
      [&](std::size_t k) {
        const double *const u = a + width * k, *const v = b + width * k;
        return ((u[0] * v[0] + u[1] * v[1]) + (u[2] * v[2] + u[3] * v[3])) +
               ((u[4] * v[4] + u[5] * v[5]) + (u[6] * v[6] + u[7] * v[7]));
      },
      1024);
  for (std::size_t k = width * whole; k < num_rows_; ++k) result += a[k] * b[k];
  return result;
}

/// Computes p = z + beta p, lambda += alpha p and rho += alpha S p. Returns false if p'S p is not positive. dw is
/// scratch.
bool FactorReuse::advance(const double* blocks, double error2, double beta, double* lambda, double* dw) {
  model_.parallel.for_ranges(num_rows_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t a = begin; a < end; ++a) p_[a] = z_[a] + beta * p_[a];
  });
  add_up(blocks, p_.data(), dw);
  work_.constraints.apply_transposed(model_.parallel, blocks, dw, nullptr, q_.data());
  const double curvature = dot(p_, q_);
  if (!(curvature > 0.0)) return false;
  const double alpha = error2 / curvature;
  model_.parallel.for_ranges(num_rows_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t a = begin; a < end; ++a) {
      lambda[a] += alpha * p_[a];
      rho_[a] += alpha * q_[a];
    }
  });
  return true;
}

void FactorReuse::exchange_memory(Memory& memory) {
  memory.exchange(mean_iterations_);
  history_.exchange_memory(memory);
}

}  // namespace tanor::detail
