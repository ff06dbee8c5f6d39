#pragma once

#include <cstddef>

#include "motion/scheme.hpp"

namespace tanor {

/// Inside a step: quintic Hermite interpolation of x from (x, v, a) at both of its ends, and its derivative as v.
/// Errors O(h^6) and O(h^5), whatever the scheme was. Looks at the two states, which have to stay as they are.
class DenseOutput {
 public:
  DenseOutput(const State& from, const State& to) : from_(from), to_(to), h_(to.t - from.t) {}

  double time(double fraction) const { return from_.t + fraction * h_; }

  /// x and v at from.t + fraction h, `size()` numbers each.
  ///
  ///   x(s) = x0 + F0 (x1 - x0) + h (F1 v0 + F2 v1) + h^2 (F3 a0 + F4 a1),   v(s) = x'(s)/h
  void evaluate(const Parallel& parallel, double fraction, double* x, double* v) const {
    const double s = fraction, s2 = s * s, s3 = s2 * s, s4 = s3 * s, s5 = s4 * s;
    const double f0 = 10 * s3 - 15 * s4 + 6 * s5, g0 = 30 * s2 - 60 * s3 + 30 * s4;
    const double f1 = s - 6 * s3 + 8 * s4 - 3 * s5, g1 = 1 - 18 * s2 + 32 * s3 - 15 * s4;
    const double f2 = -4 * s3 + 7 * s4 - 3 * s5, g2 = -12 * s2 + 28 * s3 - 15 * s4;
    const double f3 = 0.5 * (s2 - 3 * s3 + 3 * s4 - s5), g3 = 0.5 * (2 * s - 9 * s2 + 12 * s3 - 5 * s4);
    const double f4 = 0.5 * (s3 - 2 * s4 + s5), g4 = 0.5 * (3 * s2 - 8 * s3 + 5 * s4);
    parallel.for_ranges(from_.x.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const double moved = to_.x[i] - from_.x[i];
        const double v0 = from_.v[i], v1 = to_.v[i], a0 = from_.a[i], a1 = to_.a[i];
        x[i] = from_.x[i] + f0 * moved + h_ * (f1 * v0 + f2 * v1 + h_ * (f3 * a0 + f4 * a1));
        v[i] = g0 * moved / h_ + g1 * v0 + g2 * v1 + h_ * (g3 * a0 + g4 * a1);
      }
    });
  }

 private:
  const State &from_, &to_;
  double h_;
};

}  // namespace tanor
