#pragma once

#include <tanor/time_function.hpp>

#include "base/vec3.hpp"

namespace tanor::detail {

/// A box with edges along the axes that repeats itself; an edge of 0 does not repeat.
class PeriodicBox {
 public:
  PeriodicBox() = default;
  explicit PeriodicBox(const Vector3& edges) : edges_(make_vec3(edges)) {
    inverses_ = {inverse(edges_.x), inverse(edges_.y), inverse(edges_.z)};
  }

  const Vec3& edges() const { return edges_; }

  /// Returns the shortest d - (whole edges). That of -d is the opposite, bit by bit.
  Vec3 nearest_image(Vec3 d) const {
    return {d.x - edges_.x * round(d.x * inverses_.x), d.y - edges_.y * round(d.y * inverses_.y),
            d.z - edges_.z * round(d.z * inverses_.z)};
  }

 private:
  static double inverse(double edge) { return edge > 0.0 ? 1.0 / edge : 0.0; }
  /// Returns the nearest integer for |x| < 2^51. The function of libm is a call and stops the pipeline.
  static double round(double x) {
    constexpr double shift = 0x1.8p52;
    return (x + shift) - shift;
  }

  Vec3 edges_{}, inverses_{};
};

}  // namespace tanor::detail
