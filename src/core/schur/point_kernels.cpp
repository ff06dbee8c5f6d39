#include "schur/point_kernels.hpp"

#include "base/distance.hpp"
#include "base/lane_parts.hpp"

namespace tanor::detail {

namespace {

/// Returns w0 of eight points of a group.
template <class Lanes>
[[gnu::always_inline]] inline auto load_free(const Lanes& part, const double* w0, const Vec3* uniform,
                                             std::size_t group) {
  using Lane = typename Lanes::Lane;
  if (uniform == nullptr) return part.load_points(w0 + 3 * num_lanes * group);
  return typename Lanes::Vector{Lane{} + uniform->x, Lane{} + uniform->y, Lane{} + uniform->z};
}

/// Evaluates u = a/|a| in a's place, and phi = (v.v - (u.v)^2)/|a|.
template <class Lanes, class Vector>
[[gnu::always_inline]] inline void evaluate_distance(const Lanes& part, Vector a, const Vector& v, Pack3<>* gradient,
                                                     Pack<>* phi) {
  typename Lanes::Lane inverse;
  normalise(&a.x, &a.y, &a.z, &inverse);
  part.of(*phi) = second_derivative_of_distance(a, v, inverse);
  part.write(a, gradient);
}

}  // namespace

void evaluate_spheres(std::size_t count, const double* r, const double* v, const OfGuides& centers, Pack3<>* gradients,
                      Pack<>* phi) {
  for_each_part([ =, &centers ](const auto& part) __attribute__((always_inline)) {
    for (std::size_t k = 0; k < count; ++k)
      evaluate_distance(part, part.load_points(r + 3 * num_lanes * k) - part.of(centers[k]),
                        part.load_points(v + 3 * num_lanes * k), &gradients[k], &phi[k]);
  });
}

void evaluate_circles(std::size_t count, const double* r, const double* v, const OfGuides& centers,
                      const OfGuides& normals, Pack3<>* gradients, Pack<>* phi) {
  for_each_part([ =, &centers, &normals ]<class Lanes>(const Lanes& part) __attribute__((always_inline)) {
    for (std::size_t k = 0; k < count; ++k) {
      const auto n = part.of(normals[k]);
      const auto a = part.load_points(r + 3 * num_lanes * k) - part.of(centers[k]),
                 velocity = part.load_points(v + 3 * num_lanes * k);
      part.of(phi[k]) = typename Lanes::Lane{};
      part.write(n, &gradients[k]);
      // The part of a in the plane is a - (n.a) n, and likewise for v.
      evaluate_distance(part, a - dot(n, a) * n, velocity - dot(n, velocity) * n, &gradients[count + k],
                        &phi[count + k]);
    }
  });
}

void factorize_points(int num_rows, std::size_t count, const Pack3<>* gradients, PointFactor* factors,
                      Pack<>* smallest) {
  for_each_part([=]<class Lanes>(const Lanes& part) __attribute__((always_inline)) {
    using Lane = typename Lanes::Lane;
    Lane least = part.of(*smallest);
    const auto include = [&](const Lane& pivot) __attribute__((always_inline)) {
      const Lane checked = pivot > 0.0 ? pivot : Lane{};
      least = checked < least ? checked : least;
    };
    for (std::size_t k = 0; k < count; ++k) {
      PointFactor& factor = factors[k];
      const auto g0 = part.of(gradients[k]);
      const Lane inverse_d0 = 1.0 / dot(g0, g0);
      part.of(factor.inverse_d0) = inverse_d0;
      if (num_rows == 1) continue;
      const auto g1 = part.of(gradients[count + k]);
      const Lane c10 = dot(g1, g0), l10 = c10 * inverse_d0;
      const Lane d1 = dot(g1, g1) - c10 * l10, inverse_d1 = 1.0 / d1;
      part.of(factor.l10) = l10;
      part.of(factor.inverse_d1) = inverse_d1;
      include(d1);
      if (num_rows == 2) continue;
      const auto g2 = part.of(gradients[2 * count + k]);
      const Lane c20 = dot(g2, g0), l20 = c20 * inverse_d0;
      const Lane c21 = dot(g2, g1) - c20 * l10, l21 = c21 * inverse_d1;
      const Lane d2 = dot(g2, g2) - c20 * l20 - c21 * l21;
      part.of(factor.l20) = l20;
      part.of(factor.l21) = l21;
      part.of(factor.inverse_d2) = 1.0 / d2;
      include(d2);
    }
    part.of(*smallest) = least;
  });
}

void solve_points(int num_rows, std::size_t count, const PointFactor* factors, const Pack<>* b, Pack<>* x) {
  for_each_part([=]<class Lanes>(const Lanes& part) __attribute__((always_inline)) {
    using Lane = typename Lanes::Lane;
    for (std::size_t k = 0; k < count; ++k) {
      const PointFactor& factor = factors[k];
      const Lane y0 = -part.of(b[k]);
      Lane x0 = y0 * part.of(factor.inverse_d0);
      if (num_rows > 1) {
        const Lane l10 = part.of(factor.l10), y1 = -part.of(b[count + k]) - l10 * y0;
        Lane x1 = y1 * part.of(factor.inverse_d1);
        if (num_rows > 2) {
          const Lane l20 = part.of(factor.l20), l21 = part.of(factor.l21);
          const Lane x2 = (-part.of(b[2 * count + k]) - l20 * y0 - l21 * y1) * part.of(factor.inverse_d2);
          x1 -= l21 * x2;
          x0 -= l20 * x2;
          part.of(x[2 * count + k]) = x2;
        }
        x0 -= l10 * x1;
        part.of(x[count + k]) = x1;
      }
      part.of(x[k]) = x0;
    }
  });
}

void add_free(int num_rows, std::size_t count, const Pack3<>* gradients, const double* w0, const Vec3* uniform,
              Pack<>* phi, Largest* largest) {
  for_each_part([=]<class Lanes>(const Lanes& part) __attribute__((always_inline)) {
    Seen<Lanes::width> seen;
    for (std::size_t m = 0; m < static_cast<std::size_t>(num_rows); ++m) {
      for (std::size_t k = 0; k < count; ++k) {
        const auto b =
            part.of(phi[m * count + k]) + dot(part.of(gradients[m * count + k]), load_free(part, w0, uniform, k));
        seen.see(magnitude(b));
        part.of(phi[m * count + k]) = b;
      }
    }
    seen.write(part, largest);
  });
}

void add_reactions(int num_rows, std::size_t count, const Pack3<>* gradients, const Pack<>* b, const Pack<>* x,
                   const double* w0, const Vec3* uniform, double* w, Largest* largest) {
  for_each_part([=]<class Lanes>(const Lanes& part) __attribute__((always_inline)) {
    Seen<Lanes::width> seen;
    const std::size_t end = static_cast<std::size_t>(num_rows) * count;
    for (std::size_t k = 0; k < count; ++k) {
      typename Lanes::Vector dw{};
      for (std::size_t row = k; row < end; row += count) dw = dw + part.of(x[row]) * part.of(gradients[row]);
      for (std::size_t row = k; row < end; row += count)
        seen.see(magnitude(part.of(b[row]) + dot(part.of(gradients[row]), dw)));
      part.store_points(load_free(part, w0, uniform, k) + dw, w + 3 * num_lanes * k);
    }
    seen.write(part, largest);
  });
}

void scale_by_mass(int num_rows, std::size_t count, const double* inverse_mass, Pack<>* x) {
  for_each_part([=](const auto& part) __attribute__((always_inline)) {
    for (int m = 0; m < num_rows; ++m) {
      // The quotient is nearly always m itself.
      for (std::size_t k = 0; k < count; ++k)
        part.of(x[static_cast<std::size_t>(m) * count + k]) *= 1.0 / part.load(inverse_mass + num_lanes * k);
    }
  });
}

void solve_single_rows(std::size_t count, const Pack3<>* gradients, const Pack<>* phi, const double* inverse_mass,
                       const double* w0, const Vec3* uniform, double* lambda, double* w, Largest* right_side,
                       Largest* residual) {
  for_each_part([=]<class Lanes>(const Lanes& part) __attribute__((always_inline)) {
    Seen<Lanes::width> seen_b, seen_left;
    for (std::size_t k = 0; k < count; ++k) {
      const auto g = part.of(gradients[k]), free = load_free(part, w0, uniform, k);
      const auto b = part.of(phi[k]) + dot(g, free);
      // 1/(g.g) = 2 - g.g, since g.g = 1 but for rounding.
      const auto answer = -b * (2.0 - dot(g, g));
      const auto dw = answer * g;
      part.store_points(free + dw, w + 3 * num_lanes * k);
      // The quotient is nearly always m itself.
      part.store(answer * (1.0 / part.load(inverse_mass + num_lanes * k)), lambda + num_lanes * k);
      seen_b.see(magnitude(b));
      seen_left.see(magnitude(b + dot(g, dw)));
    }
    seen_b.write(part, right_side);
    seen_left.write(part, residual);
  });
}

}  // namespace tanor::detail
