#include "dynamics/drive_samples.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace tanor::detail {

namespace {

constexpr std::size_t most_samples = 1 << 14;  // in a step, without the knots of tables

}  // namespace

void DriveSamples::reserve() {
  for (std::vector<double>* array :
       {&fractions_, &widths_, &times_, &knots_, &cosines_, &chebyshev_, &next_, &after_next_, &missed_})
    array->reserve(most_of_a_step);
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

  if (num_nodes != num_nodes_) {
    cosines_.resize(2 * (num_nodes - 1));
    for (std::size_t j = 0; j < cosines_.size(); ++j)
      cosines_[j] = std::cos(std::numbers::pi * static_cast<double>(j) / static_cast<double>(num_nodes - 1));
  }
  num_nodes_ = num_nodes;
  has_equal_pieces_ = knots_.empty();
  num_samples_ = num_equal + knots_.size();
  fractions_.resize(num_nodes_);
  for (std::size_t j = 0; j < num_nodes_; ++j) fractions_[j] = 0.5 * (1.0 - cosines_[j]);
  widths_.clear();
  std::size_t knot = 0;
  double begin = 0.0;
  for (std::size_t i = 1; i <= num_equal; ++i) {
    const double end = static_cast<double>(i) / wanted;
    const auto close_piece = [&](double at) {
      fractions_.push_back(0.5 * (begin + at));
      widths_.push_back(at - begin);
      begin = at;
    };
    for (; knot < knots_.size(); ++knot) {
      const double at = (knots_[knot] - step.t) / step.h;
      if (!(at < end)) break;
      close_piece(std::max(at, begin));
    }
    close_piece(end);
  }
  num_samples_ = widths_.size();
  choose_weights();
  find_times(step);
}

void DriveSamples::find_times(const DrivenStep& step) {
  times_.resize(fractions_.size());
  for (std::size_t i = 0; i < times_.size(); ++i) times_[i] = step.t + fractions_[i] * step.h;
}

DriveSamples::Found DriveSamples::look(const DrivenStep& step, DriveLevel level, const double* values) {
  deviate(values);
  const double* const samples = values + num_nodes_;
  const auto [least, most] = std::minmax_element(values, values + num_nodes_ + num_samples_);
  Found found{.range = *most - *least, .largest = std::max(std::abs(*most), std::abs(*least))};
  if (!found.varies()) return found;
  silence_rounding(step, samples, found.largest);
  found.missed = measure_misses(step, level, samples, found.range);
  return found;
}

/// Computes e at all samples side by side by Clenshaw's scheme:
///
///   p(x) = sum c_k T_k(x),   b_k = c_k + 2 x b_{k+1} - b_{k+2},   p = c_0 + x b_1 - b_2,   x = 1 - 2 s
void DriveSamples::deviate(const double* values) {
  if (weights_ != nullptr) return deviate_by_weights(values);
  const std::size_t degree = num_nodes_ - 1;
  chebyshev_.assign(num_nodes_, 0.0);
  for (std::size_t k = 0; k < num_nodes_; ++k) {
    // c_k = 2/N sum'' f_j cos(pi j k/N), with half the first and the last term
    double sum = 0.0;
    for (std::size_t j = 0; j < num_nodes_; ++j) {
      const double weight = j == 0 || j == degree ? 0.5 : 1.0;
      sum += weight * values[j] * cosines_[j * k % (2 * degree)];
    }
    chebyshev_[k] = (k == 0 || k == degree ? 1.0 : 2.0) / static_cast<double>(degree) * sum;
  }
  next_.assign(num_samples_, 0.0);
  after_next_.assign(num_samples_, 0.0);
  missed_.resize(num_samples_);
  const double* const s = fractions_.data() + num_nodes_;
  for (std::size_t k = degree; k >= 1; --k) {
    for (std::size_t i = 0; i < num_samples_; ++i) {
      const double b = chebyshev_[k] + 2.0 * (1.0 - 2.0 * s[i]) * next_[i] - after_next_[i];
      after_next_[i] = next_[i];
      next_[i] = b;
    }
  }
  for (std::size_t i = 0; i < num_samples_; ++i)
    missed_[i] = values[num_nodes_ + i] - (chebyshev_[0] + (1.0 - 2.0 * s[i]) * next_[i] - after_next_[i]);
}

/// Computes the same with stored weights, for the positions of samples that occur in most calls:
///
///   p(s) = sum_j w_j(s) f_j
void DriveSamples::deviate_by_weights(const double* values) {
  missed_.resize(num_samples_);
  const double* weight = weights_->data();
  for (std::size_t i = 0; i < num_samples_; ++i) {
    double p = 0.0;
    for (std::size_t j = 0; j < num_nodes_; ++j) p += *weight++ * values[j];
    missed_[i] = values[num_nodes_ + i] - p;
  }
}

void DriveSamples::choose_weights() {
  weights_ = nullptr;
  if (!has_equal_pieces_ || num_samples_ != num_nodes_) return;
  if (all_weights_.size() <= num_nodes_) all_weights_.resize(num_nodes_ + 1);
  std::vector<double>& weights = all_weights_[num_nodes_];
  if (weights.empty()) {
    // The deviations at the samples for a unit value at one node are minus the weights of that node.
    std::vector<double> values(2 * num_nodes_, 0.0);
    weights.resize(num_nodes_ * num_nodes_);
    for (std::size_t j = 0; j < num_nodes_; ++j) {
      values[j] = 1.0;
      deviate(values.data());
      values[j] = 0.0;
      for (std::size_t i = 0; i < num_nodes_; ++i) weights[i * num_nodes_ + j] = -missed_[i];
    }
  }
  weights_ = &weights;
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
