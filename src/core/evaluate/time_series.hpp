#pragma once

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include <tanor/time_function.hpp>

namespace tanor::detail {

/// Taylor coefficients of functions of time and of constants, one slot each.
class TimeSeriesTable {
 public:
  std::size_t add(const ScalarFunction& function) {
    functions_.push_back(function);
    return functions_.size() - 1;
  }

  /// Returns true if some function has no series.
  bool has_unknown(double t) const {
    double value = 0.0;
    return std::ranges::any_of(functions_, [&](const ScalarFunction& f) { return !f.expand(t, {&value, 1}); });
  }

  void expand(double t, int order) {
    stride_ = static_cast<std::size_t>(order) + 1;
    coefficients_.resize(functions_.size() * stride_);
    smooth_until_ = std::numeric_limits<double>::infinity();
    for (std::size_t slot = 0; slot < functions_.size(); ++slot) {
      (void)functions_[slot].expand(t, {coefficients_.data() + slot * stride_, stride_});
      smooth_until_ = std::min(smooth_until_, functions_[slot].smooth_until(t));
    }
  }
  /// Returns coefficients 0 … order at the t of the last `expand`.
  const double* operator[](std::size_t slot) const { return coefficients_.data() + slot * stride_; }
  /// Returns the time up to which all series hold, s.
  double smooth_until() const { return smooth_until_; }

 private:
  std::vector<ScalarFunction> functions_;
  std::vector<double> coefficients_;
  std::size_t stride_ = 1;
  double smooth_until_ = std::numeric_limits<double>::infinity();
};

}  // namespace tanor::detail
