#include "ranks/cut_series.hpp"

namespace tanor::detail {

Outcome CutSeries::expand(const Kinematics& at, const double* w, const Reactions& found, const SeriesDemand&,
                          std::span<double* const> coefficients, SeriesExtent* extent) {
  const std::size_t size = 3 * model_.num_points();
  write_first_coefficients(at, w, size, coefficients);
  // Coefficients are refined as often as w was.
  extent->longest = any_length;
  extent->last_term.clear();
  extent->smooth_until = series_.expand(at.t, found.lambda, 1 + found.refinements, *this, coefficients);
  return is_finite({coefficients.back(), size}) ? Outcome{} : work_.not_finite(at.t, at.x);
}

void CutSeries::apply_transposed(const double* points, const double* shift, double* rows) {
  (void)work_.constraints.apply_transposed(model_.parallel, linearization_.blocks().data(), points, shift, rows);
}

}  // namespace tanor::detail
