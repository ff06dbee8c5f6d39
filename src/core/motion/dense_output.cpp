#include "motion/scheme.hpp"

namespace tanor::detail {

std::span<const double> Scheme::looks() const {
  static constexpr double both_ends[] = {0.0, 1.0};
  return both_ends;
}

///   x(s) = x0 + F0 (x1 - x0) + h (F1 v0 + F2 v1) + h^2 (F3 a0 + F4 a1),   v(s) = x'(s)/h
void Scheme::interpolate(const Parallel& parallel, const State& from, const State& to, double fraction, double* x,
                         double* v) const {
  const double h = to.t - from.t;
  const double s = fraction, s2 = s * s, s3 = s2 * s, s4 = s3 * s, s5 = s4 * s;
  const double f0 = 10 * s3 - 15 * s4 + 6 * s5, g0 = 30 * s2 - 60 * s3 + 30 * s4;
  const double f1 = s - 6 * s3 + 8 * s4 - 3 * s5, g1 = 1 - 18 * s2 + 32 * s3 - 15 * s4;
  const double f2 = -4 * s3 + 7 * s4 - 3 * s5, g2 = -12 * s2 + 28 * s3 - 15 * s4;
  const double f3 = 0.5 * (s2 - 3 * s3 + 3 * s4 - s5), g3 = 0.5 * (2 * s - 9 * s2 + 12 * s3 - 5 * s4);
  const double f4 = 0.5 * (s3 - 2 * s4 + s5), g4 = 0.5 * (3 * s2 - 8 * s3 + 5 * s4);
  if (!knows_acceleration()) {
    const double h0 = 3 * s2 - 2 * s3, h1 = s - 2 * s2 + s3, h2 = s3 - s2;
    const double k0 = 6 * s - 6 * s2, k1 = 1 - 4 * s + 3 * s2, k2 = 3 * s2 - 2 * s;
    parallel.for_ranges(from.x.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const double moved = to.x[i] - from.x[i];
        x[i] = from.x[i] + h0 * moved + h * (h1 * from.v[i] + h2 * to.v[i]);
        v[i] = k0 * moved / h + k1 * from.v[i] + k2 * to.v[i];
      }
    });
    return;
  }
  parallel.for_ranges(from.x.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const double moved = to.x[i] - from.x[i];
      const double v0 = from.v[i], v1 = to.v[i], a0 = from.a[i], a1 = to.a[i];
      x[i] = from.x[i] + f0 * moved + h * (f1 * v0 + f2 * v1 + h * (f3 * a0 + f4 * a1));
      v[i] = g0 * moved / h + g1 * v0 + g2 * v1 + h * (g3 * a0 + g4 * a1);
    }
  });
}

}  // namespace tanor::detail
