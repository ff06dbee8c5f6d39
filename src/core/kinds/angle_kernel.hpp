#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include <tanor/kinds/constraint/angle.hpp>

#include "kinds/kernel.hpp"
#include "kinds/tables.hpp"

namespace tanor::detail {

/// xi is cos = u.w of the directions u = a/|a|, w = b/|b| from the corner j to i and k, minus the wanted cosine. Near a
/// straight angle the cosine itself has no digits left of it. With e = u - s w and the sign s of the cosine,
/// cos = s (1 - |e|^2/2) keeps them, so xi = s (1 - s wanted - |e|^2/2).
struct AngleKernel {
  static constexpr int num_points = 3, num_rows = 1, num_blocks = 3;
  static constexpr bool unit_gradient = false;
  using Group = Angles;

  std::vector<std::array<Index, 3>> points;
  ScalarTable cosine;        // one a member
  std::vector<double> size;  // m, of the neighbourhood, one a member

  ScalarTable& own() { return cosine; }

  void set_time(double t) { cosine.set_time(t); }
  bool depends_on_time() const { return !cosine.is_constant(); }
  bool gradients_are_constant() const { return false; }
  double scale(std::size_t k) const { return size[k]; }

  [[gnu::always_inline]] Local<1, 3> operator()(std::size_t m, const double* r, const double* v) const {
    const auto [i, j, k] = points[m];
    const MovingScalar& wanted = cosine[m];
    const Vec3 a1 = load(v, i) - load(v, j), b1 = load(v, k) - load(v, j);
    const Distance a(load(r, i) - load(r, j), a1), b(load(r, k) - load(r, j), b1);
    // u' = (a' - rho' u)/rho ; u'' = -(2 rho' u' + rho'' u)/rho since a'' = 0
    const Vec3 u = a.unit, w = b.unit;
    const Vec3 u1 = (1.0 / a.value) * (a1 - a.first * u), w1 = (1.0 / b.value) * (b1 - b.first * w);
    const Vec3 u2 = (-1.0 / a.value) * (2.0 * a.first * u1 + a.second * u);
    const Vec3 w2 = (-1.0 / b.value) * (2.0 * b.first * w1 + b.second * w);
    const double s = dot(u, w) < 0.0 ? -1.0 : 1.0;
    const Vec3 e = u - s * w;
    const Vec3 grad_i = (-s / a.value) * (e - dot(e, u) * u), grad_k = (1.0 / b.value) * (e - dot(e, w) * w);
    Local<1, 3> local{{s * ((1.0 - s * wanted.value) - 0.5 * dot(e, e))},
                      {dot(grad_i, a1) + dot(grad_k, b1) - wanted.first},
                      {dot(u2, w) + 2.0 * dot(u1, w1) + dot(u, w2) - wanted.second},
                      {grad_i, -(grad_i + grad_k), grad_k}};
    // A straight angle has no gradient. Rounding's share of 1/length keeps ratios finite there.
    constexpr double rounding = 1e-16;
    local.gradient_norm[0] = std::max({norm(grad_i), norm(grad_k), norm(local.gradient[1]), rounding / a.value});
    return local;
  }
};

}  // namespace tanor::detail
