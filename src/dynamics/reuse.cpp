#include <algorithm>
#include <cmath>
#include <limits>

#include "base/stopwatch.hpp"
#include "dynamics/normal_form.hpp"

/// \file Where a step evaluates at many stages NormalForm goes on with the factor of S that it has; what conjugate
/// gradients do not find soon is for a factor of its own.
namespace tanor {

/// On the general way alone, where K changes and nothing but S lambda = -b is asked of a stage.
void NormalForm::make_reuse() {
  if (schur_ != nullptr || model_.has_friction() || num_rows() == 0) return;
  if (model_.constraints.gradients_are_constant()) return;
  const std::size_t num_rows_of_S = model_.numbering.first_idle_row();
  if (!Reuse::pays(general().summary(), num_rows_of_S, model_.incidences.size())) return;
  const GramOperator S{model_.constraints, model_.gather, model_.inverse_mass, model_.num_moving(), num_rows_of_S};
  reuse_ = std::make_unique<Reuse>(S, model_.incidences, general());
  correction_.assign(size(), 0.0);
}

/// In the M-norm: sum of m |dw|^2 = sum of m min((atol + rtol |v|)/h, (atol + rtol |x|)/h^2)^2 of the neighbourhood
/// that allows least: a heavy one must not take what a light one needs. atol 0: each point's own.
double NormalForm::allowed_error(const StepTarget& target) const {
  if (reuse_ == nullptr) return 0.0;
  const double h = std::abs(target.h);
  const Scales& scales = model_.scales;
  const bool has_own = !(target.atol > 0.0);
  const auto allowed_square = [&](std::size_t i) {
    const double atol_v = has_own ? scales.velocity_tolerances()[i] : target.atol;
    const double atol_x = has_own ? scales.position_tolerances()[i] : target.atol;
    const double in_v = (atol_v + target.rtol * norm(load(target.v, i))) / h;
    const double in_x = (atol_x + target.rtol * norm(load(target.x, i))) / (h * h);
    const double allowed = std::min(in_v, in_x);
    return model_.mass[i] * allowed * allowed;
  };
  if (scales.are_one()) return std::sqrt(model_.parallel.sum(model_.num_moving(), allowed_square));
  std::vector<double>& sums = norms_;
  sums.assign(scales.size(), 0.0);
  for (std::size_t i = 0; i < model_.num_moving(); ++i) sums[scales.of_point(i)] += allowed_square(i);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < sums.size(); ++k) {
    if (scales.has_rows(k) && sums[k] > 0.0) least = std::min(least, sums[k]);
  }
  return std::sqrt(least);
}

/// Near singular places, where rows depend, and where the unit vectors of lines jumped, every place has its own factor.
bool NormalForm::may_reuse() const {
  constexpr double nearly_singular = 1e-8;
  return allowed_error_ > 0.0 && is_factorized_ && !redundancy_.is_found() &&
         last_.reciprocal_condition > nearly_singular && factor_frames_ == model_.constraints.frames();
}

/// Of the K that is factorized: what was solved with other unit vectors of lines guesses nothing.
void NormalForm::note_frames() {
  const std::size_t frames = model_.constraints.frames();
  if (reuse_ != nullptr && factor_frames_ && *factor_frames_ != frames) reuse_->forget();
  factor_frames_ = frames;
}

/// lambda and dw at t with the K at hand.
bool NormalForm::reuse(double t) {
  const Stopwatch watch(&model_.times.solve);
  if (!has_old_factor_) reuse_->renew();
  const bool is_solved =
      reuse_->solve(model_.parallel, t, blocks_.data(), right_side_.data(), allowed_error_, &lambda_, dw_.data());
  model_.counters.iterations += reuse_->num_iterations();
  if (!is_solved) return false;
  ++model_.counters.solves;
  return has_old_factor_ = true;
}

/// As `correct`.
bool NormalForm::correct_by_reuse(double* rows, double* points) {
  const bool is_solved = reuse_->correct(model_.parallel, blocks_.data(), rows, correction_.data());
  model_.counters.iterations += reuse_->num_iterations();
  if (!is_solved) return false;
  model_.parallel.for_ranges(3 * model_.num_moving(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) points[i] += correction_[i];
  });
  return true;
}

}  // namespace tanor
