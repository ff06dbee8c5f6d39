#pragma once

#include <algorithm>
#include <cmath>

namespace tanor::detail {

/// Brackets a point where a function falls through 0 and narrows it by the ITP method (Oliveira & Takahashi, ACM Trans.
/// Math. Softw. 47, 2020), which is superlinear for a smooth function and takes at most one evaluation more than
/// bisection otherwise.
class RootBracket {
 public:
  /// Requires value_low > 0 >= value_high and low < high. `tolerance` is absolute, half the width at which the bracket
  /// is narrow.
  RootBracket(double low, double value_low, double high, double value_high, double tolerance)
      : low_(low), high_(high), value_low_(value_low), value_high_(value_high), tolerance_(tolerance) {
    constexpr double less = 0.999;  // so that rounding costs no further evaluation
    radius_ = less * tolerance * std::exp2(std::ceil(std::log2(std::max(1.0, (high - low) / (2.0 * tolerance)))) + 1.0);
    stretch_ = 0.2 / (high - low);
  }

  double low() const { return low_; }
  double high() const { return high_; }
  bool is_narrow() const { return high_ - low_ <= 2.0 * tolerance_ || value_high_ == 0.0; }

  /// Returns the slope of the line through both ends, which is negative.
  double slope() const { return (value_high_ - value_low_) / (high_ - low_); }
  /// Returns the point where that line vanishes.
  double root() const { return low_ + (high_ - low_) * (value_low_ / (value_low_ - value_high_)); }

  /// Returns the point to evaluate next: the root of the line, moved towards the middle and never far from it for long.
  double next() const {
    const double width = high_ - low_, middle = 0.5 * (low_ + high_), line = root();
    const double side = line <= middle ? 1.0 : -1.0;
    const double shift = stretch_ * width * width;
    const double moved = shift <= std::abs(middle - line) ? line + side * shift : middle;
    const double reach = std::max(0.0, radius_ - 0.5 * width);
    return std::abs(moved - middle) <= reach ? moved : middle - side * reach;
  }

  void narrow(double x, double value) {
    radius_ *= 0.5;
    (value > 0.0 ? low_ : high_) = x;
    (value > 0.0 ? value_low_ : value_high_) = value;
  }
  /// Narrows the bracket by values f(x) until it is narrow. Returns false where a value is not finite.
  template <class Function>
  bool narrow_by(const Function& f) {
    while (!is_narrow()) {
      const double x = next();
      if (x <= low_ || x >= high_) break;
      const double value = f(x);
      if (!std::isfinite(value)) return false;
      narrow(x, value);
    }
    return true;
  }

 private:
  double low_, high_, value_low_, value_high_, tolerance_;
  double radius_ = 0.0, stretch_ = 0.0;
};

}  // namespace tanor::detail
