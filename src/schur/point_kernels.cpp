#include "schur/point_kernels.hpp"

#include <cmath>

#include "base/instruction_sets.hpp"

namespace tanor_kernels {

namespace {

[[gnu::always_inline]] inline void load_free(const double* w0, const Vec3* uniform, std::size_t group, Eight3* w) {
  if (uniform == nullptr) return load_points(w0 + 3 * num_lanes * group, &w->x, &w->y, &w->z);
  const Eight nothing{};
  *w = {nothing + uniform->x, nothing + uniform->y, nothing + uniform->z};
}

/// Eight points from their guides' centers, and how they move.
struct Apart {
  Eight x, y, z, vx, vy, vz;
};
[[gnu::always_inline]] inline void load_apart(const double* r, const double* v, const Eight3& center, std::size_t group,
                                              Apart* a) {
  load_points(r + 3 * num_lanes * group, &a->x, &a->y, &a->z);
  load_points(v + 3 * num_lanes * group, &a->vx, &a->vy, &a->vz);
  a->x -= center.x;
  a->y -= center.y;
  a->z -= center.z;
}

/// u = a/|a|, phi = (v.v - (u.v)^2)/|a|
[[gnu::always_inline]] inline void evaluate_distance(Apart* a, Eight3* gradient, Eight* phi) {
  Eight inverse;
  normalise(&a->x, &a->y, &a->z, &inverse);
  const Eight speed = a->x * a->vx + a->y * a->vy + a->z * a->vz;
  *phi = (a->vx * a->vx + a->vy * a->vy + a->vz * a->vz - speed * speed) * inverse;
  *gradient = {a->x, a->y, a->z};
}

}  // namespace

TANOR_EACH_INSTRUCTION_SET
void evaluate_spheres(std::size_t count, const double* r, const double* v, const OfGuides& centers, Eight3* gradients,
                      Eight* phi) {
  for (std::size_t k = 0; k < count; ++k) {
    Apart a;
    load_apart(r, v, centers[k], k, &a);
    evaluate_distance(&a, &gradients[k], &phi[k]);
  }
}

TANOR_EACH_INSTRUCTION_SET
void evaluate_circles(std::size_t count, const double* r, const double* v, const OfGuides& centers,
                      const OfGuides& normals, Eight3* gradients, Eight* phi) {
  const Eight nothing{};
  for (std::size_t k = 0; k < count; ++k) {
    Apart a;
    load_apart(r, v, centers[k], k, &a);
    // In the plane: a - (n.a) n, and its derivative
    const Eight nx = normals[k].x, ny = normals[k].y, nz = normals[k].z;
    const Eight s = nx * a.x + ny * a.y + nz * a.z, s1 = nx * a.vx + ny * a.vy + nz * a.vz;
    a.x -= s * nx;
    a.y -= s * ny;
    a.z -= s * nz;
    a.vx -= s1 * nx;
    a.vy -= s1 * ny;
    a.vz -= s1 * nz;
    phi[k] = nothing;
    gradients[k] = {nx, ny, nz};
    evaluate_distance(&a, &gradients[count + k], &phi[count + k]);
  }
}

TANOR_EACH_INSTRUCTION_SET
void factorize_points(int num_rows, std::size_t count, const Eight3* gradients, PointFactor* factors, Eight* smallest) {
  const Eight nothing{};
  Eight least = *smallest;
  for (std::size_t k = 0; k < count; ++k) {
    PointFactor& factor = factors[k];
    const Eight3& g0 = gradients[k];
    const Eight inverse_d0 = 1.0 / (g0.x * g0.x + g0.y * g0.y + g0.z * g0.z);
    factor.inverse_d0 = inverse_d0;
    if (num_rows == 1) continue;
    const Eight3& g1 = gradients[count + k];
    const Eight c10 = g1.x * g0.x + g1.y * g0.y + g1.z * g0.z, l10 = c10 * inverse_d0;
    const Eight d1 = (g1.x * g1.x + g1.y * g1.y + g1.z * g1.z) - c10 * l10, inverse_d1 = 1.0 / d1;
    factor.l10 = l10;
    factor.inverse_d1 = inverse_d1;
    const Eight checked1 = d1 > 0.0 ? d1 : nothing;
    least = checked1 < least ? checked1 : least;
    if (num_rows == 2) continue;
    const Eight3& g2 = gradients[2 * count + k];
    const Eight c20 = g2.x * g0.x + g2.y * g0.y + g2.z * g0.z, l20 = c20 * inverse_d0;
    const Eight c21 = g2.x * g1.x + g2.y * g1.y + g2.z * g1.z - c20 * l10, l21 = c21 * inverse_d1;
    const Eight d2 = (g2.x * g2.x + g2.y * g2.y + g2.z * g2.z) - c20 * l20 - c21 * l21;
    factor.l20 = l20;
    factor.l21 = l21;
    factor.inverse_d2 = 1.0 / d2;
    const Eight checked2 = d2 > 0.0 ? d2 : nothing;
    least = checked2 < least ? checked2 : least;
  }
  *smallest = least;
}

TANOR_EACH_INSTRUCTION_SET
void solve_points(int num_rows, std::size_t count, const PointFactor* factors, const Eight* b, Eight* x) {
  for (std::size_t k = 0; k < count; ++k) {
    const PointFactor& factor = factors[k];
    const Eight y0 = -b[k];
    Eight x0 = y0 * factor.inverse_d0;
    if (num_rows > 1) {
      const Eight y1 = -b[count + k] - factor.l10 * y0;
      Eight x1 = y1 * factor.inverse_d1;
      if (num_rows > 2) {
        const Eight x2 = (-b[2 * count + k] - factor.l20 * y0 - factor.l21 * y1) * factor.inverse_d2;
        x1 -= factor.l21 * x2;
        x0 -= factor.l20 * x2;
        x[2 * count + k] = x2;
      }
      x0 -= factor.l10 * x1;
      x[count + k] = x1;
    }
    x[k] = x0;
  }
}

TANOR_EACH_INSTRUCTION_SET
void add_free(int num_rows, std::size_t count, const Eight3* gradients, const double* w0, const Vec3* uniform,
              Eight* phi, Largest* largest) {
  Eight worst = largest->value, zero = largest->zero;
  for (int m = 0; m < num_rows; ++m, gradients += count, phi += count) {
    for (std::size_t k = 0; k < count; ++k) {
      Eight3 w;
      load_free(w0, uniform, k, &w);
      const Eight3& g = gradients[k];
      const Eight b = phi[k] + (g.x * w.x + g.y * w.y + g.z * w.z), size = b < 0.0 ? -b : b;
      worst = size > worst ? size : worst;
      zero += 0.0 * b;
      phi[k] = b;
    }
  }
  largest->value = worst;
  largest->zero = zero;
}

TANOR_EACH_INSTRUCTION_SET
void add_reactions(int num_rows, std::size_t count, const Eight3* gradients, const Eight* b, const Eight* x,
                   const double* w0, const Vec3* uniform, double* w, Largest* largest) {
  const Eight nothing{};
  Eight worst = largest->value, zero = largest->zero;
  for (std::size_t k = 0; k < count; ++k) {
    Eight wx = nothing, wy = nothing, wz = nothing;
    for (int m = 0; m < num_rows; ++m) {
      const std::size_t row = static_cast<std::size_t>(m) * count + k;
      wx += x[row] * gradients[row].x;
      wy += x[row] * gradients[row].y;
      wz += x[row] * gradients[row].z;
    }
    for (int m = 0; m < num_rows; ++m) {
      const std::size_t row = static_cast<std::size_t>(m) * count + k;
      const Eight3& g = gradients[row];
      const Eight left = b[row] + (g.x * wx + g.y * wy + g.z * wz), size = left < 0.0 ? -left : left;
      worst = size > worst ? size : worst;
      zero += 0.0 * left;
    }
    Eight3 free;
    load_free(w0, uniform, k, &free);
    store_points(free.x + wx, free.y + wy, free.z + wz, w + 3 * num_lanes * k);
  }
  largest->value = worst;
  largest->zero = zero;
}

TANOR_EACH_INSTRUCTION_SET
void scale_by_mass(int num_rows, std::size_t count, const double* inverse_mass, Eight* x) {
  for (int m = 0; m < num_rows; ++m, x += count) {
    // nearly always m itself
    for (std::size_t k = 0; k < count; ++k) x[k] *= 1.0 / eight_at(inverse_mass + num_lanes * k);
  }
}

TANOR_EACH_INSTRUCTION_SET
void solve_single_rows(std::size_t count, const Eight3* gradients, const Eight* phi, const double* inverse_mass,
                       const double* w0, const Vec3* uniform, double* lambda, double* w, Largest* right_side,
                       Largest* residual) {
  Eight largest_b = right_side->value, zero_b = right_side->zero;
  Eight largest_left = residual->value, zero_left = residual->zero;
  for (std::size_t k = 0; k < count; ++k) {
    const Eight gx = gradients[k].x, gy = gradients[k].y, gz = gradients[k].z;
    Eight3 free;
    load_free(w0, uniform, k, &free);
    const Eight b = phi[k] + (gx * free.x + gy * free.y + gz * free.z);
    // 1/(g.g) = 2 - g.g, since g.g = 1 but for rounding
    const Eight answer = -b * (2.0 - (gx * gx + gy * gy + gz * gz));
    const Eight wx = answer * gx, wy = answer * gy, wz = answer * gz;
    const Eight left = b + (gx * wx + gy * wy + gz * wz);
    store_points(free.x + wx, free.y + wy, free.z + wz, w + 3 * num_lanes * k);
    eight_at(lambda + num_lanes * k) = answer * (1.0 / eight_at(inverse_mass + num_lanes * k));  // nearly always m
    const Eight size_b = b < 0.0 ? -b : b, size_left = left < 0.0 ? -left : left;
    largest_b = size_b > largest_b ? size_b : largest_b;
    largest_left = size_left > largest_left ? size_left : largest_left;
    zero_b += 0.0 * b;
    zero_left += 0.0 * left;
  }
  right_side->value = largest_b;
  right_side->zero = zero_b;
  residual->value = largest_left;
  residual->zero = zero_left;
}

}  // namespace tanor_kernels
