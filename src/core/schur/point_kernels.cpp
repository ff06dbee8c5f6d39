#include "schur/point_kernels.hpp"

#include "base/distance.hpp"
#include "base/instruction_sets.hpp"

namespace tanor::detail {

namespace {

[[gnu::always_inline]] inline void load_free(const double* w0, const Vec3* uniform, std::size_t group, Pack3<>* w) {
  if (uniform == nullptr) return load_points(w0 + 3 * num_lanes * group, &w->x, &w->y, &w->z);
  const Pack<> nothing{};
  *w = {nothing + uniform->x, nothing + uniform->y, nothing + uniform->z};
}

/// Positions of eight points relative to the centers of their guides, and their velocities.
struct Apart {
  Pack3<> a, v;
};
[[gnu::always_inline]] inline void load_apart(const double* r, const double* v, const Pack3<>& center,
                                              std::size_t group, Apart* apart) {
  auto& [a, velocity] = *apart;
  load_points(r + 3 * num_lanes * group, &a.x, &a.y, &a.z);
  load_points(v + 3 * num_lanes * group, &velocity.x, &velocity.y, &velocity.z);
  a = a - center;
}

/// Evaluates u = a/|a| and phi = (v.v - (u.v)^2)/|a|.
[[gnu::always_inline]] inline void evaluate_distance(Apart* apart, Pack3<>* gradient, Pack<>* phi) {
  auto& [a, v] = *apart;
  Pack<> inverse;
  normalise(&a.x, &a.y, &a.z, &inverse);
  *phi = second_derivative_of_distance(a, v, inverse);
  a.write(gradient);
}

}  // namespace

void evaluate_spheres(std::size_t count, const double* r, const double* v, const OfGuides& centers, Pack3<>* gradients,
                      Pack<>* phi) {
  dispatch([=, &centers] {
    for (std::size_t k = 0; k < count; ++k) {
      Apart apart;
      load_apart(r, v, centers[k], k, &apart);
      evaluate_distance(&apart, &gradients[k], &phi[k]);
    }
  });
}

void evaluate_circles(std::size_t count, const double* r, const double* v, const OfGuides& centers,
                      const OfGuides& normals, Pack3<>* gradients, Pack<>* phi) {
  dispatch([=, &centers, &normals] {
    const Pack<> nothing{};
    for (std::size_t k = 0; k < count; ++k) {
      Apart apart;
      load_apart(r, v, centers[k], k, &apart);
      // The part of a in the plane is a - (n.a) n, and likewise for v.
      const Pack3<>& n = normals[k];
      apart.a = apart.a - dot(n, apart.a) * n;
      apart.v = apart.v - dot(n, apart.v) * n;
      phi[k] = nothing;
      n.write(&gradients[k]);
      evaluate_distance(&apart, &gradients[count + k], &phi[count + k]);
    }
  });
}

void factorize_points(int num_rows, std::size_t count, const Pack3<>* gradients, PointFactor* factors,
                      Pack<>* smallest) {
  dispatch([=] {
    const Pack<> nothing{};
    Pack<> least = *smallest;
    for (std::size_t k = 0; k < count; ++k) {
      PointFactor& factor = factors[k];
      const Pack3<>& g0 = gradients[k];
      const Pack<> inverse_d0 = 1.0 / dot(g0, g0);
      factor.inverse_d0 = inverse_d0;
      if (num_rows == 1) continue;
      const Pack3<>& g1 = gradients[count + k];
      const Pack<> c10 = dot(g1, g0), l10 = c10 * inverse_d0;
      const Pack<> d1 = dot(g1, g1) - c10 * l10, inverse_d1 = 1.0 / d1;
      factor.l10 = l10;
      factor.inverse_d1 = inverse_d1;
      const Pack<> checked1 = d1 > 0.0 ? d1 : nothing;
      least = checked1 < least ? checked1 : least;
      if (num_rows == 2) continue;
      const Pack3<>& g2 = gradients[2 * count + k];
      const Pack<> c20 = dot(g2, g0), l20 = c20 * inverse_d0;
      const Pack<> c21 = dot(g2, g1) - c20 * l10, l21 = c21 * inverse_d1;
      const Pack<> d2 = dot(g2, g2) - c20 * l20 - c21 * l21;
      factor.l20 = l20;
      factor.l21 = l21;
      factor.inverse_d2 = 1.0 / d2;
      const Pack<> checked2 = d2 > 0.0 ? d2 : nothing;
      least = checked2 < least ? checked2 : least;
    }
    *smallest = least;
  });
}

void solve_points(int num_rows, std::size_t count, const PointFactor* factors, const Pack<>* b, Pack<>* x) {
  dispatch([=] {
    for (std::size_t k = 0; k < count; ++k) {
      const PointFactor& factor = factors[k];
      const Pack<> y0 = -b[k];
      Pack<> x0 = y0 * factor.inverse_d0;
      if (num_rows > 1) {
        const Pack<> y1 = -b[count + k] - factor.l10 * y0;
        Pack<> x1 = y1 * factor.inverse_d1;
        if (num_rows > 2) {
          const Pack<> x2 = (-b[2 * count + k] - factor.l20 * y0 - factor.l21 * y1) * factor.inverse_d2;
          x1 -= factor.l21 * x2;
          x0 -= factor.l20 * x2;
          x[2 * count + k] = x2;
        }
        x0 -= factor.l10 * x1;
        x[count + k] = x1;
      }
      x[k] = x0;
    }
  });
}

void add_free(int num_rows, std::size_t count, const Pack3<>* gradients, const double* w0, const Vec3* uniform,
              Pack<>* phi, Largest* largest) {
  dispatch([=]() mutable {
    Largest seen = *largest;
    for (int m = 0; m < num_rows; ++m, gradients += count, phi += count) {
      for (std::size_t k = 0; k < count; ++k) {
        Pack3<> w;
        load_free(w0, uniform, k, &w);
        const Pack<> b = phi[k] + dot(gradients[k], w);
        seen.see(b < 0.0 ? -b : b);
        phi[k] = b;
      }
    }
    *largest = seen;
  });
}

void add_reactions(int num_rows, std::size_t count, const Pack3<>* gradients, const Pack<>* b, const Pack<>* x,
                   const double* w0, const Vec3* uniform, double* w, Largest* largest) {
  dispatch([=] {
    Largest seen = *largest;
    for (std::size_t k = 0; k < count; ++k) {
      Pack3<> dw{};
      for (int m = 0; m < num_rows; ++m) {
        const std::size_t row = static_cast<std::size_t>(m) * count + k;
        dw = dw + x[row] * gradients[row];
      }
      for (int m = 0; m < num_rows; ++m) {
        const std::size_t row = static_cast<std::size_t>(m) * count + k;
        const Pack<> left = b[row] + dot(gradients[row], dw);
        seen.see(left < 0.0 ? -left : left);
      }
      Pack3<> free;
      load_free(w0, uniform, k, &free);
      free = free + dw;
      store_points(free.x, free.y, free.z, w + 3 * num_lanes * k);
    }
    *largest = seen;
  });
}

void scale_by_mass(int num_rows, std::size_t count, const double* inverse_mass, Pack<>* x) {
  dispatch([=]() mutable {
    for (int m = 0; m < num_rows; ++m, x += count) {
      // The quotient is nearly always m itself.
      for (std::size_t k = 0; k < count; ++k) x[k] *= 1.0 / pack_at(inverse_mass + num_lanes * k);
    }
  });
}

void solve_single_rows(std::size_t count, const Pack3<>* gradients, const Pack<>* phi, const double* inverse_mass,
                       const double* w0, const Vec3* uniform, double* lambda, double* w, Largest* right_side,
                       Largest* residual) {
  dispatch([=] {
    Largest seen_b = *right_side, seen_left = *residual;
    for (std::size_t k = 0; k < count; ++k) {
      const Pack3<>& g = gradients[k];
      Pack3<> free;
      load_free(w0, uniform, k, &free);
      const Pack<> b = phi[k] + dot(g, free);
      // 1/(g.g) = 2 - g.g, since g.g = 1 but for rounding.
      const Pack<> answer = -b * (2.0 - dot(g, g));
      const Pack3<> dw = answer * g;
      const Pack<> left = b + dot(g, dw);
      free = free + dw;
      store_points(free.x, free.y, free.z, w + 3 * num_lanes * k);
      pack_to(lambda + num_lanes * k) = answer * (1.0 / pack_at(inverse_mass + num_lanes * k));  // nearly always m
      seen_b.see(b < 0.0 ? -b : b);
      seen_left.see(left < 0.0 ? -left : left);
    }
    *right_side = seen_b;
    *residual = seen_left;
  });
}

}  // namespace tanor::detail
