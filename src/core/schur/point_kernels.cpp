#include "schur/point_kernels.hpp"

#include "base/distance.hpp"

namespace tanor::detail {

namespace {

/// G'G = L D L' of some points, with L below the diagonal and 1/D on it.
template <class Lanes, std::size_t rows>
struct Leaf {
  using Lane = typename Lanes::Lane;
  Lane at[rows][rows];

  [[gnu::always_inline]] void factorize(const typename Lanes::Vector* g, Lane* largest) {
    // 1/(g.g) = 2 - g.g, since g.g = 1 but for rounding.
    if constexpr (rows == 1) return void(at[0][0] = 2.0 - dot(g[0], g[0]));
    for (std::size_t i = 0; i < rows; ++i) {
      Lane c[rows];
      const Lane diagonal = dot(g[i], g[i]);
      Lane pivot = diagonal;
      for (std::size_t j = 0; j < i; ++j) {
        c[j] = dot(g[i], g[j]);
        for (std::size_t k = 0; k < j; ++k) c[j] -= c[k] * at[j][k];
        at[i][j] = c[j] * at[j][j];
        pivot -= c[j] * at[i][j];
      }
      at[i][i] = 1.0 / pivot;
      if (i > 0) lanes::include(diagonal * at[i][i], largest);
    }
  }
  /// Computes x := -(G'G)^-1 b.
  [[gnu::always_inline]] void solve(const Lane* b, Lane* x) const {
    for (std::size_t i = 0; i < rows; ++i) {
      x[i] = -b[i];
      for (std::size_t k = 0; k < i; ++k) x[i] -= at[i][k] * x[k];
    }
    for (std::size_t i = 0; i < rows; ++i) x[i] *= at[i][i];
    for (std::size_t i = rows; i-- > 1;) {
      for (std::size_t k = 0; k < i; ++k) x[k] -= at[i][k] * x[i];
    }
  }
};

/// Runs body(part, rows) with a compile-time number of rows.
template <class Body>
void for_rows(std::size_t num_rows, const Body& body) {
  const auto run = [&](auto rows) {
    for_each_part([ body, rows ](const auto& part) __attribute__((always_inline)) { body(part, rows); });
  };
  if (num_rows == 1) return run(std::integral_constant<std::size_t, 1>());
  if (num_rows == 2) return run(std::integral_constant<std::size_t, 2>());
  run(std::integral_constant<std::size_t, 3>());
}

/// Returns w0 of a group.
template <class Lanes>
[[gnu::always_inline]] inline auto load_free(const Lanes& part, const PointGroups& points, std::size_t group) {
  using Lane = typename Lanes::Lane;
  if (points.uniform == nullptr) return part.load_points(points.w0 + 3 * num_lanes * group);
  const auto [x, y, z] = *points.uniform;
  return typename Lanes::Vector{Lane{} + x, Lane{} + y, Lane{} + z};
}

/// Evaluates u = a/|a| and phi = (v.v - (u.v)^2)/|a|.
template <class Lanes, class Vector>
[[gnu::always_inline]] inline void evaluate_distance(const Lanes& part, const Vector& a, const Vector& v,
                                                     Pack3<>* gradient, Pack<>* phi) {
  typename Lanes::Lane inverse;
  Vector u = a;
  normalise(&u.x, &u.y, &u.z, &inverse);
  part.of(*phi) = second_derivative_of_distance(u, v, inverse);
  part.write(u, gradient);
}

}  // namespace

void evaluate_spheres(const PointGroups& points, const OfGuides& centers, Pack3<>* gradients, Pack<>* phi) {
  for_each_part([ =, count = points.count, r = points.r, v = points.v ](const auto& part)
                    __attribute__((always_inline)) {
                      for (std::size_t k = 0; k < count; ++k)
                        evaluate_distance(part, part.load_points(r + 3 * num_lanes * k) - part.of(centers[k]),
                                          part.load_points(v + 3 * num_lanes * k), &gradients[k], &phi[k]);
                    });
}

void evaluate_circles(const PointGroups& points, const OfGuides& centers, const OfGuides& normals, Pack3<>* gradients,
                      Pack<>* phi) {
  for_each_part([ =, count = points.count, r = points.r, v = points.v ]<class Lanes>(const Lanes& part)
                    __attribute__((always_inline)) {
                      for (std::size_t k = 0; k < count; ++k) {
                        const auto n = part.of(normals[k]);
                        const auto a = part.load_points(r + 3 * num_lanes * k) - part.of(centers[k]),
                                   velocity = part.load_points(v + 3 * num_lanes * k);
                        part.of(phi[k]) = typename Lanes::Lane{};
                        part.write(n, &gradients[k]);
                        // The part of a in the plane is a - (n.a) n, and likewise for v.
                        evaluate_distance(part, a - dot(n, a) * n, velocity - dot(n, velocity) * n,
                                          &gradients[count + k], &phi[count + k]);
                      }
                    });
}

void solve_points(std::size_t num_rows, const PointGroups& points_of, const Pack3<>* gradients, const Pack<>* phi,
                  PointFactor* factors, Pack<>* lambda, lanes::Findings* found) {
  for_rows(
      num_rows,
      [ =, points_at = &points_of ]<class Lanes>(const Lanes& part, auto rows) __attribute__((always_inline)) {
        using Lane = typename Lanes::Lane;
        const PointGroups points = *points_at;
        Lane largest = part.of(found->largest_inverse);
        Seen<Lanes::width> seen_b, seen_left;
        for (std::size_t k = 0; k < points.count; ++k) {
          typename Lanes::Vector g[rows];
          for (std::size_t m = 0; m < rows; ++m) g[m] = part.of(gradients[m * points.count + k]);
          Leaf<Lanes, rows> leaf;
          leaf.factorize(g, &largest);
          for (std::size_t i = 0; rows > 1 && i < rows; ++i) {
            for (std::size_t j = 0; j <= i; ++j) part.of(factors[k].at[i][j]) = leaf.at[i][j];
          }
          if (phi == nullptr) continue;
          const auto free = load_free(part, points, k);
          Lane b[rows], x[rows];
          for (std::size_t m = 0; m < rows; ++m) {
            b[m] = part.of(phi[m * points.count + k]) + dot(g[m], free);
            seen_b.see(magnitude(b[m]));
          }
          leaf.solve(b, x);
          auto dw = x[0] * g[0];
          for (std::size_t m = 1; m < rows; ++m) dw = dw + x[m] * g[m];
          part.store_points(free + dw, points.w + 3 * num_lanes * k);
          // The quotient is nearly always m itself.
          const Lane mass = 1.0 / part.load(points.inverse_mass + num_lanes * k);
          for (std::size_t m = 0; m < rows; ++m) {
            part.of(lambda[m * points.count + k]) = x[m] * mass;
            seen_left.see(magnitude(b[m] + dot(g[m], dw)));
          }
        }
        part.of(found->largest_inverse) = largest;
        seen_b.write(part, &found->right_side);
        seen_left.write(part, &found->residual);
      });
}

void substitute_points(std::size_t num_rows, const PointGroups& points, const PointFactor* factors, const Pack<>* b,
                       Pack<>* lambda) {
  for_rows(
      num_rows, [ =, count = points.count, inverse_mass = points.inverse_mass ]<class Lanes>(
                    const Lanes& part, auto rows) __attribute__((always_inline)) {
        for (std::size_t k = 0; k < count; ++k) {
          Leaf<Lanes, rows> leaf;
          typename Lanes::Lane own[rows], x[rows];
          leaf.at[0][0] = typename Lanes::Lane{} + 1.0;  // gradients have unit length
          for (std::size_t i = 0; i < rows; ++i) {
            own[i] = part.of(b[i * count + k]);
            for (std::size_t j = 0; rows > 1 && j <= i; ++j) leaf.at[i][j] = part.of(factors[k].at[i][j]);
          }
          leaf.solve(own, x);
          const auto mass = 1.0 / part.load(inverse_mass + num_lanes * k);
          for (std::size_t m = 0; m < rows; ++m) part.of(lambda[m * count + k]) = x[m] * mass;
        }
      });
}

}  // namespace tanor::detail
