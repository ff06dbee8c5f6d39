#pragma once

#include <array>
#include <vector>

#include <tanor/kinds/constraint/sphere.hpp>

#include "kinds/kernel.hpp"
#include "kinds/tables.hpp"

namespace tanor::detail {

/// xi is |r - center| - radius.
struct SphereKernel {
  static constexpr int num_points = 1, num_rows = 1, num_blocks = 1;
  static constexpr bool unit_gradient = true;
  using Group = Spheres;

  std::vector<std::array<Index, 1>> points;
  std::vector<Index> geometry;
  VectorTable<AsGiven> center;
  ScalarTable radius;  // one a member

  void add(const Spheres& spheres) { center.add(spheres.center); }
  ScalarTable& own() { return radius; }

  void set_time(double t) {
    center.set_time(t);
    radius.set_time(t);
  }
  bool depends_on_time() const { return !center.is_constant() || !radius.is_constant(); }
  bool gradients_are_constant() const { return false; }
  double scale(std::size_t k) const { return radius[k].value; }

  [[gnu::always_inline]] Local<1, 1> operator()(std::size_t k, const double* r, const double* v) const {
    const MovingVec3& c = center[geometry[k]];
    const MovingScalar& R = radius[k];
    const Distance rho(load(r, points[k][0]) - c.value, load(v, points[k][0]) - c.first);
    return {
        {rho.value - R.value}, {rho.first - R.first}, {rho.second - dot(rho.unit, c.second) - R.second}, {rho.unit}};
  }
};

}  // namespace tanor::detail
