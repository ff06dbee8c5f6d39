#include "dynamics/tangent_linearization.hpp"

#include <algorithm>

#include "base/text.hpp"
#include "plan/thresholds.hpp"
#include "schur/refinement.hpp"

namespace tanor::detail {

TangentLinearization::TangentLinearization(Workspace& work, const SolverOptions& options)
    : TangentLinearization(work, options, work.coordinates.list_products(work.model().mass)) {}

TangentLinearization::TangentLinearization(Workspace& work, const SolverOptions& options,
                                           const std::vector<Product>& products)
    : work_(work),
      model_(work.model()),
      num_products_(products.size()),
      solver_(products, {work.coordinates.island_start(), work.coordinates.num_coordinates()}, options.ordering,
              options.linear_solver),
      blocks_(3 * work.coordinates.num_blocks()),
      columns_(work.coordinates.num_coordinates()) {
  for (std::vector<double>* array : {&r_, &v_, &psi_, &points_, &moved_}) array->resize(3 * model_.num_points(), 0.0);
}

void TangentLinearization::prescribe(double t) {
  work_.set_time(t);
  work_.prescribe_all(t, r_.data(), v_.data());
}

void TangentLinearization::evaluate(double t, const double* q, const double* q_dot, bool with_blocks) {
  has_blocks_ = has_blocks_ || with_blocks;
  prescribe(t);
  work_.write_support_accelerations(t, psi_.data());
  work_.coordinates.evaluate(model_.parallel, q, q_dot, r_.data(), v_.data(), psi_.data(),
                             with_blocks ? blocks_.data() : nullptr);
}

Outcome TangentLinearization::factorize(double t) {
  const GramSolver::Quality quality = work_.factorize(&solver_, blocks_.data());
  reciprocal_condition_ = quality.reciprocal_condition;
  if (quality.positive_definite && quality.reciprocal_condition > GramSolver::singular_below) return {};
  return {Status::Singular, "the coordinates are singular at t = " + text(t) + ": coordinate " +
                                work_.coordinates.name_coordinate(model_.system, quality.weakest_row) +
                                " moves no point, or others move the points the same way"};
}

void TangentLinearization::factorize_again() {
  solver_.assemble(model_.parallel, blocks_.data());
  (void)solver_.factorize(model_.parallel);
}

/// Solves H q_dot = A'M (v - r_t) for the nearest rates in the M-norm, and evaluates r_ there.
Outcome TangentLinearization::find_rates(double t, const double* v, const double* q, double* q_dot) {
  std::fill(q_dot, q_dot + columns_.size(), 0.0);
  evaluate(t, q, q_dot, true);
  if (Outcome outcome = factorize(t); !outcome.ok()) return outcome;
  // v_ is r_t here. A q_dot is added to it, and the remainder is solved for again.
  std::fill(moved_.begin(), moved_.end(), 0.0);
  const auto measure = [&] {
    model_.parallel.for_ranges(model_.num_moving(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        store(points_.data(), i, model_.mass[i] * (load(v_.data(), i) + load(moved_.data(), i) - load(v, i)));
    });
    apply_transposed(points_.data(), columns_.data());
  };
  measure();
  refine_solution(2, measure, [&](int) {
    solve_negative(columns_.data());
    for (std::size_t j = 0; j < columns_.size(); ++j) q_dot[j] += columns_[j];
    apply(q_dot, moved_.data());
  });
  return {};
}

void TangentLinearization::find_reactions(const double* force, double* eta) {
  const std::size_t moving = 3 * model_.num_moving();
  std::fill(eta, eta + 3 * model_.num_points(), 0.0);
  std::copy(force, force + moving, eta);
  // Computes eta -= M A H^-1 A'eta until A'eta = 0 to rounding.
  constexpr int passes = 3;
  const auto measure = [&] { apply_transposed(eta, columns_.data()); };
  measure();
  refine_solution(passes, measure, [&](int) {
    ++work_.counters.solves;
    solve_negative(columns_.data());
    apply(columns_.data(), points_.data());
    for (std::size_t i = 0; i < moving; ++i) eta[i] += model_.mass[i / 3] * points_[i];
  });
  work_.coordinates.add_support_reactions(eta);
}

double TangentLinearization::predicted_flops() const {
  const FactorSummary& factor = solver_.summary().factor;
  return factor.flops + 4.0 * static_cast<double>(factor.factor_nonzeros) +
         plan::flops_of_tangent_product * static_cast<double>(num_products_) +
         plan::flops_of_tangent_point * static_cast<double>(model_.num_moving());
}

}  // namespace tanor::detail
