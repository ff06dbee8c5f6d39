#include "dynamics/factor_reuse.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/stopwatch.hpp"

namespace tanor::detail {

std::unique_ptr<FactorReuse> FactorReuse::make(Workspace& work, const GramSolver::Summary& factor) {
  const Model& model = work.model();
  if (model.has_friction() || model.num_rows() == 0 || work.constraints.gradients_are_constant()) return nullptr;
  const std::size_t num_rows_of_S = model.numbering.first_idle_row();
  if (!Reuse::pays(factor, num_rows_of_S, model.incidences.size())) return nullptr;
  const GramOperator S{work.constraints, model.gather, model.inverse_mass, model.num_moving(), num_rows_of_S};
  return std::make_unique<FactorReuse>(work, S, factor);
}

FactorReuse::FactorReuse(Workspace& work, const GramOperator& S, const GramSolver::Summary& factor)
    : work_(work),
      model_(work.model()),
      reuse_(S, model_.incidences, factor),
      correction_(3 * model_.num_points(), 0.0) {
  sums_.reserve(work.scales.size());
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

void FactorReuse::note_factor() {
  const std::size_t frames = work_.constraints.frames();
  if (frames_ && *frames_ != frames) reuse_.forget();
  frames_ = frames;
}

bool FactorReuse::serves(double reciprocal_condition) const {
  constexpr double nearly_singular = 1e-8;
  return allowed_error_ > 0.0 && reciprocal_condition > nearly_singular && frames_ == work_.constraints.frames();
}

bool FactorReuse::solve(double t, bool is_first, const double* blocks, const double* b, std::vector<double>* lambda,
                        double* dw) {
  const Stopwatch watch(&work_.times.solve);
  if (is_first) reuse_.renew();
  const bool is_solved = reuse_.solve(model_.parallel, t, blocks, b, allowed_error_, lambda, dw);
  work_.counters.iterations += reuse_.num_iterations();
  if (is_solved) ++work_.counters.solves;
  return is_solved;
}

bool FactorReuse::correct(const double* blocks, double* rows, double* points) {
  const bool is_solved = reuse_.correct(model_.parallel, blocks, rows, correction_.data());
  work_.counters.iterations += reuse_.num_iterations();
  if (!is_solved) return false;
  model_.add_to_moving(correction_.data(), points);
  return true;
}

}  // namespace tanor::detail
