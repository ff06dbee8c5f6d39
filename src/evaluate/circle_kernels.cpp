#include "evaluate/circle_kernels.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/instruction_sets.hpp"
#include "base/sine_cosine.hpp"

namespace tanor_kernels::circles {

TANOR_EACH_INSTRUCTION_SET
void place(const Circle* __restrict circles, std::size_t count, const double* __restrict q,
           const double* __restrict q_dot, Place<1>* __restrict places) {
  std::array<double, chunk_size> sines, cosines;  // NOLINT: filled before use
  double largest = 0.0;
  for (std::size_t k = 0; k < count; ++k) {
    tanor::sine_cosine(q[k], &sines[k], &cosines[k]);
    largest = std::abs(q[k]) > largest ? std::abs(q[k]) : largest;
  }
  if (!(largest <= tanor::largest_angle)) {
    for (std::size_t k = 0; k < count; ++k) {
      sines[k] = std::sin(q[k]);
      cosines[k] = std::cos(q[k]);
    }
  }
  for (std::size_t k = 0; k < count; ++k) {
    const double c = cosines[k], s = sines[k], rate = q_dot[k];
    const auto& [a, b, center] = circles[k];
    // r' = q' t with t = dr/dq, r'' - q'' t = -q'^2 u
    const Vec3 u = c * a + s * b, t = c * b - s * a;
    places[k] = {center + u, rate * t, -rate * rate * u, {t}};
  }
}

}  // namespace tanor_kernels::circles
