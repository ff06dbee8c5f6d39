#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "base/vec3.hpp"

namespace tanor::detail {

/// A 3 x 3 matrix, stored row by row: the derivative of the force on one point with respect to the position of one
/// point.
struct Block3 {
  std::array<double, 9> entries{};

  double operator()(int row, int column) const { return entries[static_cast<std::size_t>(3 * row + column)]; }

  Block3& operator+=(const Block3& other) {
    for (std::size_t k = 0; k < 9; ++k) entries[k] += other.entries[k];
    return *this;
  }
  /// Adds s a b'.
  void add_product(double s, Vec3 a, Vec3 b) {
    const std::array<double, 3> column{a.x, a.y, a.z}, row{b.x, b.y, b.z};
    for (std::size_t k = 0; k < 9; ++k) entries[k] += s * column[k / 3] * row[k % 3];
  }
  /// Adds s I.
  void add_identity(double s) {
    for (const std::size_t k : {0, 4, 8}) entries[k] += s;
  }
};

inline Vec3 operator*(const Block3& a, Vec3 x) {
  return {a(0, 0) * x.x + a(0, 1) * x.y + a(0, 2) * x.z, a(1, 0) * x.x + a(1, 1) * x.y + a(1, 2) * x.z,
          a(2, 0) * x.x + a(2, 1) * x.y + a(2, 2) * x.z};
}

/// A pair of points that exert forces on each other which depend on r_j - r_i and v_j - v_i alone. With B the
/// derivative of the force on j with respect to r_j, the other three derivatives are -B, -B and B.
struct Coupling {
  int i, j;
};

/// A pair of points where the force on point `on` depends on the motion of point `of`.
struct Influence {
  int on, of;
};

}  // namespace tanor::detail
