#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/normal_form.hpp"

/// \file Residuals of NormalForm beside their own neighbourhood: one that is far, fast or heavy has no say about
/// others. Each function asks first what is cheap: where that is little beside the slowest neighbourhood, it is little
/// beside each.
namespace tanor {

/// Of the rows of K at hand; 1 where a contact slides.
const std::vector<double>& NormalForm::gradient_norms() const {
  std::vector<double>& norms = norms_;
  norms.assign(num_rows(), 0.0);
  for (const Incidence& incidence : model_.incidences) {
    double& own = norms[static_cast<std::size_t>(incidence.row)];
    own = std::max(own, norm(load(blocks_.data(), incidence.block)));
  }
  for (double& own : norms) own = own > 0.0 ? own : 1.0;
  return norms;
}

/// The largest |w0| and |phi + K'w0|/|gradient| of each neighbourhood; `scale`: of all.
void NormalForm::measure_accelerations(double scale) {
  if (knows_accelerations_) return;
  knows_accelerations_ = true;
  const Scales& scales = model_.scales;
  accelerations_.assign(scales.size(), scale > 0.0 ? scale : 1.0);
  if (scales.are_one()) return;
  model_.largest_norms(w0_, &accelerations_);
  accelerations_.back() = scale;
  const std::vector<double>& norms = gradient_norms();
  for (std::size_t a = 0; a < num_rows(); ++a) {
    double& own = accelerations_[scales.of_row(a)];
    own = larger(own, std::abs(right_side_[a]) / norms[a]);
  }
  // Where all cancels nothing is left but what v itself brings about.
  for (std::size_t k = 0; k < accelerations_.size(); ++k) {
    if (!(accelerations_[k] > 0.0)) accelerations_[k] = scales.speed(k) * scales.speed(k) / scales.length(k);
  }
}

/// Largest over the neighbourhoods of |K'w + phi|, in `rows_`, over their accelerations; `largest` and `scale` of all.
double NormalForm::relative_residual(double largest, double scale) {
  constexpr double little = 1e-13;
  const Scales& scales = model_.scales;
  const double relative = largest / (scale > 0.0 ? scale : 1.0);
  if (scales.are_one() || largest <= little * scales.least_acceleration()) return relative;
  measure_accelerations(scale);
  const std::vector<double>& norms = gradient_norms();
  double worst = 0.0;
  for (std::size_t a = 0; a < num_rows(); ++a)
    worst = larger(worst, std::abs(rows_[a]) / (norms[a] * accelerations_[scales.of_row(a)]));
  return worst;
}

/// Largest over the neighbourhoods of |K'v + xi_t|, in `rows_`, over their speeds; `largest` of all.
double NormalForm::relative_rates(double largest) const {
  constexpr double little = 1e-14;
  const Scales& scales = model_.scales;
  if (scales.are_one()) return largest / scales.speed(0);
  if (largest <= little * scales.least_speed()) return largest / scales.least_speed();
  const std::vector<double>& norms = gradient_norms();
  double worst = 0.0;
  for (std::size_t a = 0; a < num_rows(); ++a)
    worst = larger(worst, std::abs(rows_[a]) / (norms[a] * scales.speed(scales.of_row(a))));
  return worst;
}

/// The largest |xi|/length of rows where it is more than `allowed` and than `times` the rounding of their positions,
/// eps |r|/length; 0: there is none. `violation`: the largest of all.
double NormalForm::beyond_rounding(const double* r, double violation, double allowed, double times) {
  const Scales& scales = model_.scales;
  if (!(violation <= std::max(allowed, times * rounding_floor(r)))) return violation;
  if (scales.are_one()) return 0.0;
  auto& [places, at_rest, position, rates, lengths] = beyond_;
  model_.largest_norms(r, &places);
  at_rest.resize(size(), 0.0);
  for (std::vector<double>* array : {&position, &rates}) array->resize(num_rows());
  lengths.assign(num_rows(), 0.0);
  model_.constraints.measure(r, at_rest.data(), position.data(), rates.data());
  model_.constraints.write_lengths(lengths.data());
  double worst = 0.0;
  for (std::size_t a = 0; a < num_rows(); ++a) {
    if (!(lengths[a] > 0.0)) continue;
    const double far = std::max(1.0, places[scales.of_row(a)] / lengths[a]);
    const double rounding = times * 4.0 * std::numeric_limits<double>::epsilon() * far;
    if (!(position[a] <= std::max(allowed, rounding))) worst = larger(worst, position[a]);
  }
  return worst;
}

}  // namespace tanor
