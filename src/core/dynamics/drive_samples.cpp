#include "dynamics/drive_samples.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace tanor::detail {

namespace {

constexpr std::size_t most_samples = 1 << 14;  // in a step, without the knots of tables

}  // namespace

void DriveSamples::reserve() {
  for (std::vector<double>* array : {&fractions_, &widths_, &times_, &knots_, &missed_}) array->reserve(most_of_a_step);
}

/// Places the Chebyshev points (1 - cos(pi j/N))/2, then the midpoints of the pieces. The pieces have equal lengths,
/// but are cut at the knots of tables.
void DriveSamples::place(const DrivenStep& step, DriveLevel level, const ScalarFunction& function) {
  const std::size_t num_nodes = static_cast<std::size_t>(step.degree) + 1 + static_cast<std::size_t>(level);
  const double wanted =
      std::clamp(std::ceil(step.h / step.spacing), static_cast<double>(num_nodes), static_cast<double>(most_samples));
  const auto num_equal = static_cast<std::size_t>(wanted);
  knots_.clear();
  function.append_knots(step.t, step.t + step.h, &knots_);
  if (has_equal_pieces_ && knots_.empty() && num_nodes == num_nodes_ && num_equal == num_samples_)
    return find_times(step);

  polynomial_.place(num_nodes);
  num_nodes_ = num_nodes;
  has_equal_pieces_ = knots_.empty();
  fractions_ = polynomial_.points();
  widths_.clear();
  for (double& at : knots_) at = std::max((at - step.t) / step.h, 0.0);
  std::erase_if(knots_, [](double at) { return !(at < 1.0); });
  for (std::size_t i = 0; i <= num_equal; ++i) knots_.push_back(static_cast<double>(i) / wanted);
  if (!has_equal_pieces_) std::sort(knots_.begin(), knots_.end());
  for (std::size_t i = 1; i < knots_.size(); ++i) {
    fractions_.push_back(0.5 * (knots_[i - 1] + knots_[i]));
    widths_.push_back(knots_[i] - knots_[i - 1]);
  }
  num_samples_ = widths_.size();
  find_times(step);
}

void DriveSamples::find_times(const DrivenStep& step) {
  times_.resize(fractions_.size());
  for (std::size_t i = 0; i < times_.size(); ++i) times_[i] = step.t + fractions_[i] * step.h;
}

DriveSamples::Found DriveSamples::look(const DrivenStep& step, DriveLevel level, const double* values) {
  const double *const samples = values + num_nodes_, *const end = samples + num_samples_;
  missed_.assign(samples, end);
  polynomial_.subtract(values, std::span(fractions_).subspan(num_nodes_), missed_.data());
  const auto [least, most] = std::minmax_element(values, end);
  Found found{.range = *most - *least, .largest = std::max(std::abs(*most), std::abs(*least))};
  if (!found.varies()) return found;
  silence_rounding(step, samples, found.largest);
  found.missed = measure_misses(step, level, samples, found.range);
  return found;
}

/// Sets deviations below the rounding of values and of times to 0.
void DriveSamples::silence_rounding(const DrivenStep& step, const double* samples, double largest) {
  double slope = 0.0;
  for (std::size_t i = 1; i < num_samples_; ++i) {
    const double distance = 0.5 * (widths_[i - 1] + widths_[i]) * step.h;
    if (distance > 0.0) slope = std::max(slope, std::abs(samples[i] - samples[i - 1]) / distance);
  }
  const double noise = 64.0 * std::numeric_limits<double>::epsilon() * (largest + slope * std::abs(step.t));
  for (double& missed : missed_) missed = std::abs(missed) > noise ? missed : 0.0;
}

/// Computes the errors of the step in x and v, and how far the function moves them within the step.
DriveSamples::Misses DriveSamples::measure_misses(const DrivenStep& step, DriveLevel level, const double* samples,
                                                  double range) const {
  Misses result;
  double once = 0.0, twice = 0.0;  // integrals of e from the step's beginning
  for (std::size_t i = 0; i < num_samples_; ++i) {
    const double width = widths_[i] * step.h;
    once += width * missed_[i];
    twice += width * once;
    if (level == DriveLevel::Acceleration) {
      result.v = std::max(result.v, std::abs(once));
      result.x = std::max(result.x, std::abs(twice));
      result.v_done += width * std::abs(samples[i]);
    } else if (level == DriveLevel::Velocity) {
      result.x = std::max(result.x, std::abs(once));
    } else {
      result.x = std::max(result.x, std::abs(missed_[i]));
    }
  }
  if (level == DriveLevel::Acceleration) result.x_done = result.v_done * step.h;
  if (level == DriveLevel::Velocity) result.x_done = range * step.h;
  if (level == DriveLevel::Position) result.x_done = range;
  return result;
}

/// Between p + 1 points a polygon has the error |g''| (h/p)^2/8.
int DriveSamples::count_pieces(DriveLevel level, const double* values, const Found& found) const {
  constexpr double straight = 0.01;
  const double *const s = fractions_.data() + num_nodes_, *const samples = values + num_nodes_;
  double bend = 0.0;
  for (std::size_t i = 1; i + 1 < num_samples_; ++i) {
    const double before = s[i] - s[i - 1], after = s[i + 1] - s[i];
    if (!(before > 0.0 && after > 0.0)) continue;
    const double slope_before = (samples[i] - samples[i - 1]) / before,
                 slope_after = (samples[i + 1] - samples[i]) / after;
    bend = std::max(bend, std::abs(slope_after - slope_before) * 2.0 / (before + after));
  }
  // A contact that is held on a moving guide depends on the second derivative, which bends faster.
  const double factor = level == DriveLevel::Acceleration ? 1.0 : 2.0;
  const double pieces = factor * std::sqrt(bend / 8.0 / (straight * (found.range + straight * found.largest)));
  return static_cast<int>(std::min<double>(std::ceil(pieces), DriveReport::most_pieces));
}

}  // namespace tanor::detail
