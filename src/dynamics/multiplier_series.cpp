#include "dynamics/multiplier_series.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/stopwatch.hpp"
#include "schur/refinement.hpp"

namespace tanor {

namespace {

std::unique_ptr<PathSeries> make_path_series(const Workspace& work) {
  const Model& model = work.model();
  return PathSeries::make(model.system, model.numbering, model.incidences, model.inverse_mass);
}

}  // namespace

MultiplierSeries::MultiplierSeries(Workspace& work, Linearization& linearization)
    : work_(work),
      model_(work.model()),
      linearization_(linearization),
      path_series_(make_path_series(work)),
      right_side_(model_.num_rows()),
      rows_(model_.num_rows()) {
  if (path_series_ == nullptr) series_ = std::make_unique<MotionSeries>(work);
}

std::string MultiplierSeries::find_obstacle(const Workspace& work) {
  return make_path_series(work) != nullptr ? std::string{} : MotionSeries(work).obstacle();
}

Outcome MultiplierSeries::expand(const Kinematics& at, const double* w, const Reactions& found,
                                 std::span<double* const> coefficients, double* smooth_until) {
  const std::size_t size = 3 * model_.num_points();
  std::copy(at.x, at.x + size, coefficients[0]);
  std::copy(at.v, at.v + size, coefficients[1]);
  if (w != coefficients[2]) std::copy(w, w + size, coefficients[2]);
  for (std::size_t i = 0; i < size; ++i) coefficients[2][i] *= 0.5;
  // As many as w took.
  const int passes = 1 + found.refinements;
  if (path_series_ != nullptr) {
    *smooth_until = std::numeric_limits<double>::infinity();
    const Stopwatch watch(&work_.times.solve);
    path_series_->expand(model_.parallel, coefficients, found.lambda.data(), passes);
    work_.counters.solves += static_cast<std::size_t>(passes) * (coefficients.size() - 3);
  } else {
    {
      const Stopwatch watch(&work_.times.evaluate);
      series_->begin(at.t, coefficients);
    }
    *smooth_until = series_->smooth_until();
    lambda_ = found.lambda;
    for (int k = 0; k + 2 < static_cast<int>(coefficients.size()); ++k) {
      {
        const Stopwatch watch(&work_.times.evaluate);
        series_->advance(k, coefficients, lambda_.data(), right_side_.data());
      }
      if (k > 0 && model_.num_rows() > 0) solve_order(k, passes, coefficients[static_cast<std::size_t>(k) + 2]);
    }
  }
  const double* const last = coefficients.back();
  const bool is_finite = std::all_of(last, last + size, [](double x_i) { return std::isfinite(x_i); });
  return is_finite ? Outcome{} : work_.not_finite(at.t, at.x);
}

/// M^-1 eta = w - M^-1 f
Power MultiplierSeries::power_along(const Kinematics& at, const double* w) {
  if (!model_.is_rheonomic()) {
    work_.forces.evaluate_powers(model_.parallel, at.t, at.x, at.v);
    return work_.power(nullptr, at.x, at.v);
  }
  reaction_.resize(3 * model_.num_points());
  work_.evaluate_free(at.t, at.x, at.v, reaction_.data());
  for (std::size_t i = 0; i < reaction_.size(); ++i) reaction_[i] = w[i] - reaction_[i];
  return work_.power(reaction_.data(), at.x, at.v);
}

/// S mu = -(K_0'r_{k+2} + the lower ones), r_{k+2} += M^-1 K_0 mu, lambda_k = (k+1)(k+2) mu
void MultiplierSeries::solve_order(int k, int passes, double* next) {
  std::fill(lambda_.begin(), lambda_.end(), 0.0);
  const auto measure = [&] { linearization_.apply_transposed(next, right_side_.data(), rows_.data()); };
  measure();
  refine_solution(passes, measure, [&](int) {
    linearization_.correct(rows_.data(), next);
    for (std::size_t a = 0; a < rows_.size(); ++a) lambda_[a] += rows_[a];
  });
  const double factor = (k + 1.0) * (k + 2.0);
  for (double& lambda : lambda_) lambda *= factor;
}

}  // namespace tanor
