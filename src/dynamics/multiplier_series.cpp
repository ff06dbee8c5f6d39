#include "dynamics/multiplier_series.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/stopwatch.hpp"

namespace tanor {

namespace {

std::unique_ptr<PathSeries> make_path_series(const Workspace& work) {
  const Model& model = work.model();
  return PathSeries::make(model.system, model.numbering, model.incidences, model.inverse_mass);
}

}  // namespace

MultiplierSeries::MultiplierSeries(Workspace& work, Linearization& linearization)
    : work_(work), model_(work.model()), linearization_(linearization), path_series_(make_path_series(work)) {
  if (path_series_ == nullptr) series_ = std::make_unique<MotionSeries>(work);
}

Outcome MultiplierSeries::expand(const Kinematics& at, const double* w, const Reactions& found,
                                 std::span<double* const> coefficients, double* smooth_until) {
  const std::size_t size = 3 * model_.num_points();
  write_first_coefficients(at, w, size, coefficients);
  // The solves take as many passes as those of w.
  const int passes = 1 + found.refinements;
  if (path_series_ != nullptr) {
    *smooth_until = std::numeric_limits<double>::infinity();
    const Stopwatch watch(&work_.times.solve);
    path_series_->expand(model_.parallel, coefficients, found.lambda.data(), passes);
    work_.counters.solves += static_cast<std::size_t>(passes) * (coefficients.size() - 3);
  } else {
    *smooth_until = series_->expand(at.t, found.lambda, passes, *this, coefficients);
  }
  return is_finite({coefficients.back(), size}) ? Outcome{} : work_.not_finite(at.t, at.x);
}

Power MultiplierSeries::power_along(const Kinematics& at, int terms) {
  if (!model_.is_rheonomic()) {
    work_.forces.evaluate_powers(model_.parallel, at.t, at.x, at.v);
    return work_.power(0.0, at.x, at.v);
  }
  points_.resize(3 * model_.num_points());
  work_.evaluate_free(at.t, at.x, at.v, points_.data());
  std::copy_n(at.v, points_.size(), points_.begin());
  std::fill_n(points_.begin(), 3 * model_.num_moving(), 0.0);
  return work_.power(series_->power_of_constraints(at.t, at.x, points_.data(), terms), at.x, at.v);
}

void MultiplierSeries::apply_transposed(const double* points, const double* shift, double* rows) {
  (void)linearization_.apply_transposed(points, shift, rows);
}

void MultiplierSeries::correct(double* rows, double* points) {
  if (model_.num_rows() > 0) linearization_.correct(rows, points);
}

}  // namespace tanor
