#include "dynamics/multiplier_series.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/stopwatch.hpp"

namespace tanor::detail {

MultiplierSeries::MultiplierSeries(Workspace& work, Linearization& linearization)
    : work_(work),
      model_(work.model()),
      linearization_(linearization),
      lanes_(model_.system, work.constraints, model_.numbering, model_.inverse_mass, model_.parallel.threads()) {
  // The lanes know nothing of rows that depend on time, which may join supports alone.
  if (lanes_.serves_all() && !model_.is_rheonomic() && model_.numbering.one_sided.empty()) return;
  others_ = std::make_unique<MotionSeries>(work, lanes_.left_rows(), lanes_.left_points());
  if (lanes_.serves_some()) rest_ = work.constraints.select(lanes_.left_rows());
}

/// Lanes eliminate S without a look at its rank, or at other processes.
bool MultiplierSeries::may_use_lanes() const {
  return lanes_.serves_some() && work_.team().is_alone() && !linearization_.dependences().is_found() &&
         model_.numbering.one_sided.empty();
}

Outcome MultiplierSeries::expand(const Kinematics& at, const double* w, const Reactions& found,
                                 const SeriesDemand& wanted, std::span<double* const> coefficients,
                                 SeriesExtent* extent) {
  const std::size_t size = 3 * model_.num_points();
  write_first_coefficients(at, w, size, coefficients);
  // The solves take as many passes as those of w.
  const int passes = 1 + found.refinements;
  was_in_lanes_ = may_use_lanes();
  last_ = others_.get();
  if (lanes_.serves_some() && !was_in_lanes_) {
    if (whole_ == nullptr) whole_ = std::make_unique<MotionSeries>(work_);
    last_ = whole_.get();
  }
  extent->smooth_until = std::numeric_limits<double>::infinity();
  extent->longest = any_length;
  const std::size_t num_told = was_in_lanes_ ? model_.num_points() : 0;
  extent->last_term.resize(num_told, static_cast<std::uint8_t>(coefficients.size() - 1));
  if (last_ != nullptr) {
    // Rows of the lanes are 0 in each of its solves.
    extent->smooth_until = last_->expand(at.t, found.lambda, passes, *this, coefficients);
  } else {
    clear_other_points(coefficients, extent->last_term);
    // Islands that leave out terms make fewer.
    work_.counters.solves += static_cast<std::size_t>(passes) * (coefficients.size() - 3);
  }
  if (was_in_lanes_) {
    const Stopwatch watch(&work_.times.solve);
    const Scales& scales = work_.scales;
    extent->longest =
        lanes_.expand(model_.parallel, {coefficients,
                                        found.lambda.data(),
                                        passes,
                                        {wanted, scales.position_tolerances(), scales.velocity_tolerances()},
                                        extent->last_term});
  }
  return is_finite({coefficients.back(), size}) ? Outcome{} : work_.not_finite(at.t, at.x);
}

/// Sets the coefficients of points that no constraint holds, and of supports, to 0 from the third on.
void MultiplierSeries::clear_other_points(std::span<double* const> coefficients,
                                          std::span<std::uint8_t> last_term) const {
  const auto end = [&](std::size_t first, std::size_t last) {
    std::fill(last_term.begin() + first, last_term.begin() + last, std::uint8_t{2});
  };
  if (!last_term.empty()) {
    lanes_.left_points().for_each(end);
    end(model_.num_moving(), model_.num_points());
  }
  for (std::size_t k = 3; k < coefficients.size(); ++k) {
    lanes_.left_points().for_each([&](std::size_t begin, std::size_t end) {
      std::fill(coefficients[k] + 3 * begin, coefficients[k] + 3 * end, 0.0);
    });
    std::fill(coefficients[k] + 3 * model_.num_moving(), coefficients[k] + 3 * model_.num_points(), 0.0);
  }
}

Power MultiplierSeries::power_along(const Kinematics& at, int terms) {
  if (!work_.is_rheonomic()) {
    work_.forces.evaluate_powers(model_.parallel, at.t, at.x, at.v);
    return work_.power(0.0, at);
  }
  points_.resize(3 * model_.num_points());
  work_.evaluate_free(at.t, at.x, at.v, points_.data());
  std::copy_n(at.v, points_.size(), points_.begin());
  std::fill_n(points_.begin(), 3 * model_.num_moving(), 0.0);
  const double* const v_supports = work_.team().without_guests(points_.data(), &points_);
  return work_.power(last_->power_of_constraints(at.t, at.x, v_supports, terms), at);
}

void MultiplierSeries::apply_transposed(const double* points, const double* shift, double* rows) {
  if (!was_in_lanes_) {
    const double* const blocks = linearization_.blocks().data();
    (void)work_.constraints.apply_transposed(model_.parallel, blocks, points, shift, rows);
    return;
  }
  (void)work_.constraints.apply_transposed(model_.parallel, rest_, linearization_.blocks().data(), points, shift, rows);
}

void MultiplierSeries::correct(double* rows, double* points) {
  if (work_.has_rows()) linearization_.correct(rows, points);
}

}  // namespace tanor::detail
