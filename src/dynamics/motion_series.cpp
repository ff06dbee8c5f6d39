#include "dynamics/motion_series.hpp"

#include <algorithm>
#include <array>

namespace tanor {

namespace {

/// Behind those of constraints, those of forces, whose blocks begin at `first_force`.
std::vector<Incidence> join(std::vector<Incidence> constraints, const std::vector<Incidence>& forces,
                            std::size_t first_force) {
  for (Incidence incidence : forces) {
    incidence.block += static_cast<Index>(first_force);
    constraints.push_back(incidence);
  }
  return constraints;
}

}  // namespace

MotionSeries::MotionSeries(const Workspace& work)
    : model_(work.model()),
      constraints_(model_.system, model_.numbering, model_.incidences, work.time()),
      forces_(model_.system, model_.numbering, work.time()),
      gather_(join(constraints_.turning(model_.incidences), forces_.incidences(), work.constraints.num_blocks()),
              model_.num_points()),
      first_force_(work.constraints.num_blocks()),
      blocks_(3 * (first_force_ + forces_.num_blocks()), 0.0),
      ones_(std::max<std::size_t>(1, model_.num_rows()), 1.0) {
  for (const tanor::Support& support : model_.system.supports) {
    if (support.displacement.is_constant()) continue;
    supports_.push_back({support.displacement, {}});
    for (const Index point : support.points)
      supports_.back().points.push_back(model_.numbering.inner_point[static_cast<std::size_t>(point)]);
    for (const ScalarFunction& component : support.displacement.components) {
      double value = 0.0;
      if (!component.expand(work.time(), {&value, 1})) obstacle_ = "a support moves by a function alone";
    }
  }
  if (model_.has_friction()) obstacle_ = "friction is found by iteration and has no series in time";
  if (!constraints_.obstacle().empty()) obstacle_ = constraints_.obstacle();
  if (!forces_.obstacle().empty()) obstacle_ = forces_.obstacle();
}

const std::string& MotionSeries::obstacle() const {
  return obstacle_;
}

double MotionSeries::smooth_until() const {
  return smooth_until_;
}

void MotionSeries::begin(double t, std::span<double* const> coefficients) {
  const int order = static_cast<int>(coefficients.size()) - 1;
  constraints_.begin(t, order);
  forces_.begin(t, order);
  smooth_until_ = std::min(constraints_.smooth_until(), forces_.smooth_until());
  for (std::size_t k = 3; k < coefficients.size(); ++k)
    std::fill(coefficients[k] + 3 * model_.num_moving(), coefficients[k] + 3 * model_.num_points(), 0.0);
  std::array<double, ScalarFunction::largest_order + 1> series;
  for (const Support& support : supports_) {
    for (std::size_t c = 0; c < 3; ++c) {
      const ScalarFunction& component = support.displacement.components[c];
      (void)component.expand(t, std::span(series).first(coefficients.size()));
      smooth_until_ = std::min(smooth_until_, component.smooth_until(t));
      for (std::size_t k = 3; k < coefficients.size(); ++k) {
        for (const Index point : support.points) coefficients[k][3 * static_cast<std::size_t>(point) + c] = series[k];
      }
    }
  }
}

void MotionSeries::advance(int k, std::span<double* const> coefficients, const double* last_lambda, double* rows) {
  const Parallel& parallel = model_.parallel;
  constraints_.advance(parallel, k, coefficients, last_lambda, blocks_.data(), rows);
  if (forces_.num_blocks() > 0) forces_.advance(parallel, k, coefficients, blocks_.data() + 3 * first_force_);
  if (k == 0) return;
  // (k+1)(k+2) r_{k+2} = M^-1 (f_k + sum over j = 1 … k of K_j lambda_{k-j})
  double* const next = coefficients[static_cast<std::size_t>(k) + 2];
  const std::size_t moving = model_.num_moving();
  gather_.write_scaled(parallel, blocks_.data(), ones_.data(), model_.inverse_mass.data(), moving, next);
  const double factor = 1.0 / ((k + 1.0) * (k + 2.0));
  parallel.for_ranges(3 * moving, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) next[i] *= factor;
  });
}

}  // namespace tanor
