/// \file The motion in normal form as a power series, see MotionSeries.

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/stopwatch.hpp"
#include "dynamics/normal_form.hpp"

namespace tanor {

SeriesExpansion* NormalForm::series() {
  if (path_series_ == nullptr && series_ == nullptr) {
    path_series_ = PathSeries::make(model_.system, model_.numbering, model_.incidences, model_.inverse_mass);
    if (path_series_ == nullptr) series_ = std::make_unique<MotionSeries>(model_);
  }
  return series_ == nullptr || series_->obstacle().empty() ? this : nullptr;
}

std::string NormalForm::why_no_series() const {
  if (path_series_ != nullptr) return "";
  if (series_ != nullptr) return series_->obstacle();
  const bool has_paths =
      PathSeries::make(model_.system, model_.numbering, model_.incidences, model_.inverse_mass) != nullptr;
  return has_paths ? std::string{} : MotionSeries(model_).obstacle();
}

Outcome NormalForm::expand(const Kinematics& at, const double* w, std::span<double* const> coefficients,
                           double* smooth_until) {
  const auto [t, r, v] = at;
  const Parallel& parallel = model_.parallel;
  std::copy(r, r + size(), coefficients[0]);
  std::copy(v, v + size(), coefficients[1]);
  if (w != coefficients[2]) std::copy(w, w + size(), coefficients[2]);
  for (std::size_t i = 0; i < size(); ++i) coefficients[2][i] *= 0.5;
  const int passes = 1 + last_.refinements;
  if (path_series_ != nullptr) return expand_paths(t, passes, coefficients, smooth_until);
  {
    const Stopwatch watch(&model_.times.evaluate);
    series_->begin(t, coefficients);
  }
  *smooth_until = series_->smooth_until();

  lambda_series_ = lambda_;
  for (int k = 0; k + 2 < static_cast<int>(coefficients.size()); ++k) {
    {
      const Stopwatch watch(&model_.times.evaluate);
      series_->advance(k, coefficients, lambda_series_.data(), right_side_.data());
    }
    if (k == 0 || num_rows() == 0) continue;
    double* const next = coefficients[static_cast<std::size_t>(k) + 2];
    // S mu = -(K_0'r_{k+2} + the lower ones), r_{k+2} += M^-1 K_0 mu, lambda_k = (k+1)(k+2) mu
    std::fill(lambda_series_.begin(), lambda_series_.end(), 0.0);
    for (int pass = 0; pass < passes; ++pass) {
      model_.constraints.apply_transposed(parallel, blocks_.data(), next, right_side_.data(), rows_.data());
      correct(rows_.data(), next);
      for (std::size_t a = 0; a < num_rows(); ++a) lambda_series_[a] += rows_[a];
    }
    const double factor = (k + 1.0) * (k + 2.0);
    for (double& lambda : lambda_series_) lambda *= factor;
  }
  return check_finite(t, coefficients.back());
}

Outcome NormalForm::expand_paths(double t, int passes, std::span<double* const> coefficients, double* smooth_until) {
  *smooth_until = std::numeric_limits<double>::infinity();
  const Stopwatch watch(&model_.times.solve);
  path_series_->expand(model_.parallel, coefficients, lambda_.data(), passes);
  model_.counters.solves += static_cast<std::size_t>(passes) * (coefficients.size() - 3);
  return check_finite(t, coefficients.back());
}

Outcome NormalForm::check_finite(double t, const double* x) const {
  return std::all_of(x, x + size(), [](double x_i) { return std::isfinite(x_i); }) ? Outcome{} : model_.not_finite(t);
}

Power NormalForm::power_along(const Kinematics& at, const double* w) {
  // M^-1 eta = w - M^-1 f
  std::vector<double>& reaction = respond_;
  reaction.resize(size());
  model_.evaluate_free(at.t, at.x, at.v, reaction.data());
  for (std::size_t i = 0; i < size(); ++i) reaction[i] = w[i] - reaction[i];
  return model_.power(reaction.data(), at.x, at.v);
}

}  // namespace tanor
