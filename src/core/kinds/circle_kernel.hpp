#pragma once

#include <array>
#include <vector>

#include <tanor/kinds/constraint/circle.hpp>

#include "kinds/kernel.hpp"
#include "kinds/tables.hpp"

namespace tanor::detail {

/// xi is s = n.a (height over the plane) and rho - radius, with rho = |p|, p = a - s n, a = r - center.
struct CircleKernel {
  static constexpr int num_points = 1, num_rows = 2, num_blocks = 2;
  static constexpr bool unit_gradient = true;
  using Group = Circles;

  std::vector<std::array<Index, 1>> points;
  std::vector<Index> geometry;
  VectorTable<AsGiven> center;
  VectorTable<ToUnit> normal;
  ScalarTable radius;  // one a member

  void add(const Circles& circles) {
    center.add(circles.center);
    normal.add(circles.normal);
  }
  ScalarTable& own() { return radius; }
  /// Returns the radius of the position r at t, by the same steps as below.
  template <class Shape>
  static double measure(const Shape& circles, double t, Vec3 r) {
    const Vec3 a = r - make_moving(circles.center(t)).value;
    const Vec3 n = ToUnit{}(circles.normal(t)).value;
    return norm(a - dot(n, a) * n);
  }

  void set_time(double t) {
    center.set_time(t);
    normal.set_time(t);
    radius.set_time(t);
  }
  bool depends_on_time() const { return !center.is_constant() || !normal.is_constant() || !radius.is_constant(); }
  bool gradients_are_constant() const { return false; }
  double scale(std::size_t k) const { return radius[k].value; }

  [[gnu::always_inline]] Local<2, 2> operator()(std::size_t k, const double* r, const double* v) const {
    const MovingVec3 &c = center[geometry[k]], &n = normal[geometry[k]];
    const MovingScalar& R = radius[k];
    // a, a', a'' at w = 0
    const Vec3 a = load(r, points[k][0]) - c.value, a1 = load(v, points[k][0]) - c.first, a2 = -c.second;
    // s = n.a
    const double s = dot(n.value, a);
    const double s1 = dot(n.first, a) + dot(n.value, a1);
    const double s2 = dot(n.second, a) + 2.0 * dot(n.first, a1) + dot(n.value, a2);
    // p = a - s n
    const Vec3 p = a - s * n.value;
    const Vec3 p1 = a1 - s1 * n.value - s * n.first;
    const Vec3 p2 = a2 - s2 * n.value - 2.0 * s1 * n.first - s * n.second;
    // rho'' = (p'.p' - rho'^2)/rho + u.p''
    const Distance rho(p, p1);
    return {{s, rho.value - R.value},
            {s1, rho.first - R.first},
            {s2, rho.second + dot(rho.unit, p2) - R.second},
            {n.value, rho.unit}};
  }
};

}  // namespace tanor::detail
