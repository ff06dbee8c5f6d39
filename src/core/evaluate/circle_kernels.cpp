#include "evaluate/circle_kernels.hpp"

#include <array>
#include <cmath>
#include <limits>

#include "base/instruction_sets.hpp"
#include "base/sine_cosine.hpp"

namespace tanor::detail::circles {

namespace {

using Chunk = std::array<double, chunk_size>;

[[gnu::always_inline]] inline void find_sines(const double* __restrict q, std::size_t count, double* __restrict sines,
                                              double* __restrict cosines) {
  for (std::size_t k = 0; k < count; ++k) sine_cosine(q[k], &sines[k], &cosines[k]);
  unsigned is_far = 0;  // not 0 if some angle is too large for `sine_cosine`
  for (std::size_t k = 0; k < count; ++k) is_far |= std::abs(q[k]) <= largest_angle ? 0U : 1U;
  if (is_far == 0) return;
  for (std::size_t k = 0; k < count; ++k) {
    sines[k] = std::sin(q[k]);
    cosines[k] = std::cos(q[k]);
  }
}

/// A point r = center + u with the tangent t = dr/dq, so that r' = q' t and r'' - q'' t = -q'^2 u.
struct Turned {
  Vec3 u, t;
};
[[gnu::always_inline]] inline Turned turn(const Circles& circles, std::size_t k, double s, double c) {
  const Vec3 a{circles.ax[k], circles.ay[k], circles.az[k]}, b{circles.bx[k], circles.by[k], circles.bz[k]};
  return {c * a + s * b, c * b - s * a};
}

}  // namespace

void place(const Circles& given, std::size_t count, const double* __restrict q, const double* __restrict q_dot,
           Place<1>* __restrict places) {
  dispatch([=, &given] {
    const Circles circles = given;
    Chunk sines, cosines;  // NOLINT: filled before use
    find_sines(q, count, sines.data(), cosines.data());
    for (std::size_t k = 0; k < count; ++k) {
      const auto [u, t] = turn(circles, k, sines[k], cosines[k]);
      const double rate = q_dot[k];
      places[k] = {circles.center[k] + u, rate * t, -rate * rate * u, {t}};
    }
  });
}

double accelerate(const Circles& given, std::size_t count, const double* __restrict q, const double* __restrict q_dot,
                  Vec3 w0, double* __restrict q_ddot, Vec3* __restrict w) {
  return dispatch([=, &given] {
    const Circles circles = given;
    Chunk sines, cosines, x, y, z;  // NOLINT: filled before use
    find_sines(q, count, sines.data(), cosines.data());
    unsigned is_lost = 0;  // not 0 if some number is not finite
    for (std::size_t k = 0; k < count; ++k) {
      const auto [u, t] = turn(circles, k, sines[k], cosines[k]);
      const Vec3 psi = -q_dot[k] * q_dot[k] * u;
      const double along = dot(t, w0 - psi) / dot(t, t);
      q_ddot[k] = along;
      x[k] = psi.x + along * t.x;
      y[k] = psi.y + along * t.y;
      z[k] = psi.z + along * t.z;
      is_lost |= std::abs(x[k] + y[k] + z[k]) <= std::numeric_limits<double>::max() ? 0U : 1U;
    }
    for (std::size_t k = 0; k < count; ++k) w[k] = {x[k], y[k], z[k]};
    return is_lost != 0 ? std::numeric_limits<double>::quiet_NaN() : 0.0;
  });
}

}  // namespace tanor::detail::circles
