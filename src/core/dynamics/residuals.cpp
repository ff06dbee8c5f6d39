#include "dynamics/residuals.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/numbers.hpp"

namespace tanor::detail {

namespace {

std::size_t count_rods(const Constraints& constraints) {
  return constraints.family<RodKernel<false, false>>().size() + constraints.family<RodKernel<false, true>>().size() +
         constraints.family<RodKernel<true, false>>().size() + constraints.family<RodKernel<true, true>>().size();
}

}  // namespace

Residuals::Residuals(const Workspace& work, const std::vector<double>& blocks)
    : work_(work),
      model_(work.model()),
      blocks_(blocks),
      all_are_rods_(count_rods(work.constraints) == work.constraints.num_blocks()) {
  terms_.reserve(model_.num_rows());
  if (work.scales.are_one()) return;
  // A step that is the first one to need these does not allocate.
  for (std::vector<double>* scales : {&accelerations_, &beyond_.places}) scales->reserve(work.scales.size());
  for (std::vector<double>* rows : {&norms_, &beyond_.lengths}) rows->reserve(model_.num_rows());
  if (all_are_rods_) return;
  beyond_.at_rest.reserve(3 * model_.num_points());
  for (std::vector<double>* rows : {&beyond_.position, &beyond_.rates}) rows->reserve(model_.num_rows());
}

/// Returns the norms of the present rows of K, or 1 for a contact that slides.
const std::vector<double>& Residuals::gradient_norms() {
  norms_.assign(model_.num_rows(), 0.0);
  for (const Incidence& incidence : model_.incidences) {
    double& own = norms_[static_cast<std::size_t>(incidence.row)];
    own = std::max(own, norm(load(blocks_.data(), incidence.block)));
  }
  for (double& own : norms_) own = own > 0.0 ? own : 1.0;
  return norms_;
}

const std::vector<double>& Residuals::measure_accelerations(const Problem& problem) {
  const auto& [w0, b, scale] = problem;
  if (knows_accelerations_) return accelerations_;
  knows_accelerations_ = true;
  const Scales& scales = work_.scales;
  accelerations_.assign(scales.size(), scale > 0.0 ? scale : 1.0);
  if (scales.are_one()) return accelerations_;
  work_.largest_norms(w0, &accelerations_);
  accelerations_.back() = scale;
  const std::vector<double>& norms = gradient_norms();
  for (std::size_t a = 0; a < model_.num_rows(); ++a) {
    double& own = accelerations_[scales.of_row(a)];
    own = larger(own, std::abs(b[a]) / norms[a]);
  }
  work_.team().find_largest(accelerations_);
  // Where all forces cancel, the accelerations that v itself brings about are the scale.
  for (std::size_t k = 0; k < accelerations_.size(); ++k) {
    if (!(accelerations_[k] > 0.0)) accelerations_[k] = scales.speed(k) * scales.speed(k) / scales.length(k);
  }
  return accelerations_;
}

double Residuals::relative_residual(const Problem& problem, const std::vector<double>& rows, double largest) {
  constexpr double little = 1e-13;
  const Scales& scales = work_.scales;
  const double relative = largest / (problem.scale > 0.0 ? problem.scale : 1.0);
  if (scales.are_one() || largest <= little * scales.least_acceleration()) return relative;
  measure_accelerations(problem);
  const std::vector<double>& norms = gradient_norms();
  double worst = 0.0;
  for (std::size_t a = 0; a < model_.num_rows(); ++a)
    worst = larger(worst, std::abs(rows[a]) / (norms[a] * accelerations_[scales.of_row(a)]));
  return work_.team().largest(worst);
}

bool Residuals::are_rounding(const Problem& problem, const std::vector<double>& rows, const double* dw) {
  terms_.resize(model_.num_rows());
  for (std::size_t a = 0; a < terms_.size(); ++a) terms_[a] = std::abs(problem.b[a]);
  for (const Incidence& incidence : model_.incidences) {
    const Vec3 g = load(blocks_.data(), incidence.block), w = load(dw, incidence.point);
    terms_[static_cast<std::size_t>(incidence.row)] += std::abs(g.x * w.x) + std::abs(g.y * w.y) + std::abs(g.z * w.z);
  }
  bool are_all = true;
  for (std::size_t a = 0; a < terms_.size() && are_all; ++a) are_all = std::abs(rows[a]) <= 2.0 * eps * terms_[a];
  return work_.team().all(are_all);
}

double Residuals::relative_rates(const std::vector<double>& rows, double largest) {
  constexpr double little = 1e-14;
  const Scales& scales = work_.scales;
  if (scales.are_one()) return largest / scales.speed(0);
  if (largest <= little * scales.least_speed()) return largest / scales.least_speed();
  const std::vector<double>& norms = gradient_norms();
  double worst = 0.0;
  for (std::size_t a = 0; a < model_.num_rows(); ++a)
    worst = larger(worst, std::abs(rows[a]) / (norms[a] * scales.speed(scales.of_row(a))));
  return work_.team().largest(worst);
}

/// Returns the rounding eps |r|/L of the positions, below which |xi|/length cannot fall, at its largest.
double Residuals::rounding_floor(const double* r) const {
  return work_.team().largest(4.0 * eps * std::max(1.0, model_.largest_norm(r) / model_.smallest_length));
}

double Residuals::beyond_rounding(const double* r, const double* xi, double violation, double allowed, double times) {
  const Scales& scales = work_.scales;
  if (!(violation <= std::max(allowed, times * rounding_floor(r)))) return violation;
  if (scales.are_one()) return 0.0;
  work_.largest_norms(r, &beyond_.places);
  work_.team().find_largest(beyond_.places);
  find_lengths();
  // Gradients of rods are unit vectors, so that xi alone tells.
  const bool none = all_are_rods_ && !has_rod_beyond(xi, allowed, times);
  return work_.team().largest(none ? 0.0 : largest_beyond(r, allowed, times));
}

/// Finds the lengths [d] of the rows, which are constant in most systems.
void Residuals::find_lengths() {
  std::vector<double>& lengths = beyond_.lengths;
  if (!lengths.empty() && !work_.constraints.depends_on_time()) return;
  lengths.assign(model_.num_rows(), 0.0);
  work_.constraints.write_lengths(lengths.data());
}

/// Returns true if |xi| of a rod exceeds `allowed` lengths and the rounding of its positions.
bool Residuals::has_rod_beyond(const double* xi, double allowed, double times) const {
  const std::vector<double>&places = beyond_.places, &lengths = beyond_.lengths;
  const double rounding = times * 4.0 * eps;
  const auto has_beyond = [&](std::size_t begin, std::size_t end) {
    bool is_beyond = false;
    for (std::size_t a = begin; a < end; ++a) {
      const double place = std::max(lengths[a], places[work_.scales.of_row(a)]);
      is_beyond |= !(std::abs(xi[a]) <= std::max(allowed * lengths[a], rounding * place));
    }
    return is_beyond;
  };
  return model_.parallel.join_over_ranges(model_.num_rows(), false, has_beyond, std::logical_or<>());
}

/// Returns the largest |xi|/|gradient|/length of such rows.
double Residuals::largest_beyond(const double* r, double allowed, double times) {
  auto& [places, at_rest, position, rates, lengths] = beyond_;
  at_rest.resize(3 * model_.num_points(), 0.0);
  for (std::vector<double>* array : {&position, &rates}) array->resize(model_.num_rows());
  work_.constraints.measure(r, at_rest.data(), position.data(), rates.data());
  double worst = 0.0;
  for (std::size_t a = 0; a < model_.num_rows(); ++a) {
    if (!(lengths[a] > 0.0)) continue;
    const double far = std::max(1.0, places[work_.scales.of_row(a)] / lengths[a]);
    const double rounding = times * 4.0 * eps * far;
    if (!(position[a] <= std::max(allowed, rounding))) worst = larger(worst, position[a]);
  }
  return worst;
}

}  // namespace tanor::detail
