#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace tanor::detail {

/// Chooses step lengths from the error of the last step over the tolerance by proportional-integral control (Hairer &
/// Wanner II, IV.2). A step grows at most 5 times, and not at all right after a rejection.
class StepControl {
 public:
  explicit StepControl(int order, double last_error = 1e-4, bool after_rejection = false)
      : exponent_(1.0 / order), last_error_(last_error), after_rejection_(after_rejection) {}

  double last_error() const { return last_error_; }
  bool is_after_rejection() const { return after_rejection_; }

  /// Bound of the next step, whatever its scheme proposes, s.
  double limit = std::numeric_limits<double>::infinity();

  /// Returns the factor for the next step after an accepted one.
  double accept(double error) {
    const double e = std::max(error, 1e-10);
    const double beta = 0.04;
    // The factor 0.9 e^-(exponent - 0.75 beta) last^beta
    const double factor = 0.9 * std::exp(beta * std::log(last_error_) - (exponent_ - 0.75 * beta) * std::log(e));
    last_error_ = std::max(error, 1e-4);
    const double most = after_rejection_ ? 1.0 : 5.0;
    after_rejection_ = false;
    return std::clamp(factor, 0.2, most);
  }

  /// Returns the factor for trying again after a rejected one.
  double reject(double error) {
    after_rejection_ = true;
    return std::clamp(0.9 * std::pow(error, -exponent_), 0.1, 0.9);
  }

 private:
  double exponent_;
  double last_error_;
  bool after_rejection_;
};

}  // namespace tanor::detail
