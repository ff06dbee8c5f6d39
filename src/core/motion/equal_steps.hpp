#pragma once

#include <algorithm>
#include <cmath>

namespace tanor::detail {

/// Divides the time from `begin` to `end` into equal steps, the fewest that are no longer than `step`. The last one
/// ends exactly at `end`.
class EqualSteps {
 public:
  EqualSteps(double begin, double end, double step)
      : begin_(begin), end_(end), count_(std::max(1.0, std::ceil((end - begin) / step - 1e-9))) {}

  double begin() const { return begin_; }
  double count() const { return count_; }
  double length() const { return (end_ - begin_) / count_; }
  /// Returns the time after k steps.
  double time(double k) const { return k == count_ ? end_ : begin_ + k * length(); }
  /// Returns the k whose time is nearest to t.
  double nearest(double t) const { return std::round((t - begin_) / length()); }

 private:
  double begin_, end_, count_;
};

}  // namespace tanor::detail
