#include "report/guide_forces.hpp"

#include <cmath>

namespace tanor::report {

std::vector<double> find_guide_forces(const ShownParts& shown, std::span<const double> positions,
                                      std::span<const double> tensions, std::span<const double> reactions,
                                      std::span<const double> support_forces) {
  std::vector<double> rows(3 * shown.num_points);
  for (std::size_t k = 0; k < shown.num_points; ++k) {
    const std::size_t first = 3 * static_cast<std::size_t>(shown.points[k]);
    for (std::size_t axis = 0; axis < 3; ++axis)
      rows[3 * k + axis] = shown.is_support[k] ? -support_forces[first + axis] : reactions[first + axis];
  }
  const std::vector<double> images = gather_shifted_images(shown, positions);
  for (std::size_t k = 0; k < shown.rods.size(); ++k) {
    const auto [i, j] = shown.rods[k];
    const auto place = [&](std::size_t p) {
      return p < shown.num_points ? &positions[3 * p] : &images[3 * (p - shown.num_points)];
    };
    const double *a = place(i), *b = place(j);
    // T (r_j - r_i)/|r_j - r_i|
    const double length = std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]), pull = tensions[k] / length;
    if (!std::isfinite(pull)) continue;
    const std::size_t far = static_cast<std::size_t>(j) < shown.num_points
                                ? static_cast<std::size_t>(j)
                                : static_cast<std::size_t>(shown.images[j - shown.num_points].point);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double force = pull * (b[axis] - a[axis]);
      if (!shown.is_support[i]) rows[3 * i + axis] -= force;
      if (!shown.is_support[far]) rows[3 * far + axis] += force;
    }
  }
  return rows;
}

}  // namespace tanor::report
