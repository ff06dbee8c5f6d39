#include "dynamics/motion_series.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/stopwatch.hpp"
#include "schur/refinement.hpp"

namespace tanor::detail {

namespace {

/// Appends the incidences of forces, whose blocks begin at `first_force`, to those of constraints.
std::vector<Incidence> join(std::vector<Incidence> constraints, const std::vector<Incidence>& forces,
                            std::size_t first_force) {
  for (Incidence incidence : forces) {
    incidence.block += static_cast<Index>(first_force);
    constraints.push_back(incidence);
  }
  return constraints;
}

}  // namespace

MotionSeries::MotionSeries(Workspace& work, std::span<const char> takes_part, IndexRanges points)
    : work_(work),
      model_(work.model()),
      constraints_(model_.system, model_.numbering, model_.incidences, work.time(), takes_part),
      forces_(model_.system, model_.numbering, work.time()),
      gather_(join(constraints_.turning(model_.incidences), forces_.incidences(), work.constraints.num_blocks()),
              model_.num_points()),
      points_(std::move(points)),
      first_force_(work.constraints.num_blocks()),
      blocks_(3 * (first_force_ + forces_.num_blocks()), 0.0),
      right_side_(model_.num_rows()),
      rows_(model_.num_rows()) {
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

double MotionSeries::expand(double t, const std::vector<double>& lambda, int passes, SeriesFactor& factor,
                            std::span<double* const> coefficients) {
  {
    const Stopwatch watch(&work_.times.evaluate);
    begin(t, coefficients);
  }
  lambda_ = lambda;
  begun_at_ = t;
  multipliers_.clear();
  for (int k = 0; k + 2 < static_cast<int>(coefficients.size()); ++k) {
    {
      const Stopwatch watch(&work_.times.evaluate);
      advance(k, coefficients);
    }
    if (k > 0) solve_order(k, passes, factor, coefficients[static_cast<std::size_t>(k) + 2]);
    if (model_.is_rheonomic()) multipliers_.insert(multipliers_.end(), lambda_.begin(), lambda_.end());
  }
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

/// Computes order k >= 1: all of r_{k+2} but M^-1 K_0 lambda_k/((k+1)(k+2)), into coefficients[k + 2], and minus the
/// required K_0'r_{k+2}, into right_side_. Orders must follow one another; k = 0 only prepares the others.
void MotionSeries::advance(int k, std::span<double* const> coefficients) {
  const Parallel& parallel = model_.parallel;
  constraints_.advance(parallel, k, coefficients, lambda_.data(), blocks_.data(), right_side_.data());
  if (forces_.num_blocks() > 0) forces_.advance(parallel, k, coefficients, blocks_.data() + 3 * first_force_);
  work_.constraints.open.clear(right_side_.data());
  work_.constraints.open.clear_blocks(blocks_.data());
  if (k == 0) return;
  // (k+1)(k+2) r_{k+2} = M^-1 (f_k + sum over j = 1 … k of K_j lambda_{k-j})
  double* const next = coefficients[static_cast<std::size_t>(k) + 2];
  gather_.write_sums(parallel, blocks_.data(), 1.0 / ((k + 1.0) * (k + 2.0)), model_.inverse_mass.data(), points_,
                     next);
}

/// Solves S mu = -(K_0'r_{k+2} + the lower ones), then r_{k+2} += M^-1 K_0 mu, lambda_k = (k+1)(k+2) mu.
void MotionSeries::solve_order(int k, int passes, SeriesFactor& factor, double* next) {
  work_.team().fetch_guests(next);
  const auto measure = [&] { factor.apply_transposed(next, right_side_.data(), rows_.data()); };
  measure();
  const double scale = (k + 1.0) * (k + 2.0);
  refine_solution(passes, measure, [&](int pass) {
    factor.correct(rows_.data(), next);
    model_.parallel.for_ranges(rows_.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t a = begin; a < end; ++a) lambda_[a] = (pass == 0 ? 0.0 : lambda_[a]) + scale * rows_[a];
    });
  });
}

/// Since K'v + xi_t = 0, the power (K lambda).v is -lambda.(K_s'v_s + xi_t), which is exactly 0 where nothing moves.
double MotionSeries::power_of_constraints(double t, const double* r, const double* v_supports, int terms) {
  const std::size_t d = model_.num_rows();
  if (multipliers_.empty() || d == 0) return 0.0;
  work_.set_time(t);
  (void)work_.constraints.evaluate_rates(model_.parallel, r, v_supports, rows_.data());
  const double s = t - begun_at_;
  constraints_.scale_rates(s, terms, rows_.data());
  for (const std::size_t row : work_.team().rows_elsewhere()) rows_[row] = 0.0;
  double power = 0.0;
  for (int k = terms - 2; k >= 0; --k) {
    const double* const lambda = multipliers_.data() + static_cast<std::size_t>(k) * d;
    power = power * s - std::inner_product(rows_.begin(), rows_.end(), lambda, 0.0);
  }
  return power;
}

void write_first_coefficients(const Kinematics& at, const double* w, std::size_t size,
                              std::span<double* const> coefficients) {
  std::copy(at.x, at.x + size, coefficients[0]);
  std::copy(at.v, at.v + size, coefficients[1]);
  if (w != coefficients[2]) std::copy(w, w + size, coefficients[2]);
  for (std::size_t i = 0; i < size; ++i) coefficients[2][i] *= 0.5;
}

bool is_finite(std::span<const double> numbers) {
  return std::ranges::all_of(numbers, [](double x_i) { return std::isfinite(x_i); });
}

}  // namespace tanor::detail
