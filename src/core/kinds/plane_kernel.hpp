#pragma once

#include <array>
#include <vector>

#include <tanor/kinds/constraint/plane.hpp>

#include "kinds/kernel.hpp"
#include "kinds/tables.hpp"

namespace tanor::detail {

/// xi is n.r - offset/|normal| with the unit normal n = normal/|normal|.
struct PlaneKernel {
  static constexpr int num_points = 1, num_rows = 1, num_blocks = 1;
  static constexpr bool unit_gradient = true;
  using Group = Planes;

  std::vector<std::array<Index, 1>> points;
  std::vector<Index> geometry;
  VectorTable<PlaneNormal> normal;
  ScalarTable offset;        // one a member
  std::vector<double> size;  // m, of the neighbourhood, one a member

  void add(const Planes& planes) { normal.add(planes.normal); }
  ScalarTable& own() { return offset; }

  void set_time(double t) {
    normal.set_time(t);
    offset.set_time(t);
  }
  bool depends_on_time() const { return !normal.is_constant() || !offset.is_constant(); }
  bool gradients_are_constant() const { return normal.is_constant(); }
  double scale(std::size_t k) const { return size[k]; }

  [[gnu::always_inline]] Local<1, 1> operator()(std::size_t k, const double* r, const double* v) const {
    const auto& [n, c] = normal[geometry[k]];
    const MovingScalar& o = offset[k];
    const Vec3 x = load(r, points[k][0]), b = load(v, points[k][0]);
    return {{dot(n.value, x) - o.value * c.value},
            {dot(n.value, b) + dot(n.first, x) - (o.first * c.value + o.value * c.first)},
            {2.0 * dot(n.first, b) + dot(n.second, x) -
             (o.second * c.value + 2.0 * o.first * c.first + o.value * c.second)},
            {n.value}};
  }
};

}  // namespace tanor::detail
