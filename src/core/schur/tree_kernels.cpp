#include "schur/tree_kernels.hpp"

#include <algorithm>
#include <cmath>

#include "base/distance.hpp"
#include "base/instruction_sets.hpp"
#include "base/parallel.hpp"

namespace tanor::detail::trees {

// ---- the same for numbers and lanes ----

namespace {

/// Computes W -= scaled h', which is symmetric.
template <class Vector>
[[gnu::always_inline]] inline void subtract(Mobility<Vector>* W, const Vector& h, const Vector& scaled) {
  W->xx -= scaled.x * h.x;
  W->xy -= scaled.x * h.y;
  W->xz -= scaled.x * h.z;
  W->yy -= scaled.y * h.y;
  W->yz -= scaled.y * h.z;
  W->zz -= scaled.z * h.z;
}

}  // namespace

// ---- branches of one shape ----

namespace {

[[gnu::always_inline]] inline Pack<> magnitude(const Pack<>& x) {
  return x < 0.0 ? -x : x;
}

/// Returns the vector from the child to the parent.
[[gnu::always_inline]] inline Pack3<> distance(const Shape& shape, const Pack3<>* r, const Pack3<>* offset,
                                               std::size_t k) {
  const Pack3<> apart = r[static_cast<std::size_t>(shape.parent[k])] - r[k];
  return offset != nullptr ? apart + offset[k] : apart;
}

/// Returns its direction, and 1/|r_p - r_c| in `inverse`.
[[gnu::always_inline]] inline Pack3<> direction(const Shape& shape, const Pack3<>* r, const Pack3<>* offset,
                                                std::size_t k, Pack<>* inverse) {
  Pack3<> u = distance(shape, r, offset, k);
  normalise(&u.x, &u.y, &u.z, inverse);
  return u;
}

[[gnu::always_inline]] inline void evaluate_rod(const Shape& shape, const BranchMotion& motion, std::size_t k,
                                                BranchRod* rod, BranchRow* row, Largest* right_side) {
  const auto parent = static_cast<std::size_t>(shape.parent[k]);
  Pack<> inverse;
  const Pack3<> u = direction(shape, motion.r, motion.offset, k, &inverse);
  const Pack3<> rate = motion.v[parent] - motion.v[k];
  Pack<> b = second_derivative_of_distance(u, rate, inverse);
  if (motion.length_second != nullptr) b -= motion.length_second[k];
  if (motion.w0 != nullptr) b += dot(u, motion.w0[parent] - motion.w0[k]);
  u.write(&rod->u);
  row->b = b;
  right_side->see(magnitude(b));
}

[[gnu::always_inline]] inline void eliminate_rod(const Shape& shape, std::size_t k, const BranchPoints& points,
                                                 BranchRod* rod, Pack<>* largest) {
  const auto parent = static_cast<std::size_t>(shape.parent[k]);
  const Pack3<> u = rod->u, h = points.mobility[parent] * u;
  const Pack<> pivot = dot(u, h) + dot(u, points.mobility[k] * u);
  const Pack<> diagonal = dot(u, u) * (points.inverse_mass[parent] + points.inverse_mass[k]);
  const Pack<> inverse = 1.0 / pivot, ratio = diagonal * inverse;
  const Pack<> checked = ratio > 0.0 ? ratio : Pack<>{} + HUGE_VAL;
  *largest = checked > *largest ? checked : *largest;
  const Pack3<> scaled = inverse * h;
  subtract(&points.mobility[parent], h, scaled);
  scaled.write(&rod->h);
  rod->inverse_pivot = inverse;
}

[[gnu::always_inline]] inline void substitute_rod(const Shape& shape, std::size_t k, const BranchPoints& points,
                                                  const BranchRod& rod, BranchRow* row) {
  const auto parent = static_cast<std::size_t>(shape.parent[k]);
  const Pack3<> of_parent = points.s[parent];
  row->z = row->b + dot(rod.u, of_parent - points.s[k]);
  (of_parent - row->z * rod.h).write(&points.s[parent]);
}

[[gnu::always_inline]] inline void prepare_points(const Shape& shape, const BranchPoints& points) {
  for (std::size_t i = 0; i < shape.num_points(); ++i)
    points.mobility[i] = Mobility<Pack3<>>::of_free_point(points.inverse_mass[i]);
}

[[gnu::always_inline]] inline void clear(const Shape& shape, Pack3<>* points) {
  const Pack3<> nothing{};
  for (std::size_t i = 0; i < shape.num_points(); ++i) nothing.write(&points[i]);
}

[[gnu::always_inline]] inline void see_lanes(const Pack<>& found, LargestInverse* largest) {
  for (std::size_t lane = 0; lane < num_lanes; ++lane) largest->see(found[lane]);
}

}  // namespace

void find_directions(const Shape& shape, const Pack3<>* r, const Pack3<>* offset, BranchRod* rods) {
  dispatch([=, &shape] {
    for (std::size_t k = 0; k < shape.num_rods; ++k) {
      Pack<> inverse;
      direction(shape, r, offset, k, &inverse).write(&rods[k].u);
    }
  });
}

void evaluate(const Shape& shape, const BranchMotion& motion, BranchRod* rods, BranchRow* rows, Largest* right_side) {
  dispatch([=, &shape, &motion] {
    Largest seen = *right_side;
    for (std::size_t k = 0; k < shape.num_rods; ++k) evaluate_rod(shape, motion, k, &rods[k], &rows[k], &seen);
    *right_side = seen;
  });
}

void eliminate(const Shape& shape, const BranchPoints& points, BranchRod* rods, LargestInverse* largest) {
  dispatch([=, &shape, &points] {
    Pack<> found{};
    prepare_points(shape, points);
    for (std::size_t k = 0; k < shape.num_rods; ++k) eliminate_rod(shape, k, points, &rods[k], &found);
    if (shape.num_rods > 0) see_lanes(found, largest);
  });
}

void substitute_up(const Shape& shape, const BranchPoints& points, const BranchRod* rods, BranchRow* rows) {
  dispatch([=, &shape, &points] {
    for (std::size_t k = 0; k < shape.num_rods; ++k) substitute_rod(shape, k, points, rods[k], &rows[k]);
  });
}

void evaluate_and_eliminate(const Shape& shape, const BranchMotion& motion, const BranchPoints& points, BranchRod* rods,
                            BranchRow* rows, Largest* right_side, LargestInverse* largest) {
  dispatch([=, &shape, &motion, &points] {
    Pack<> found{};
    Largest seen = *right_side;
    prepare_points(shape, points);
    clear(shape, points.s);
    for (std::size_t k = 0; k < shape.num_rods; ++k) {
      evaluate_rod(shape, motion, k, &rods[k], &rows[k], &seen);
      eliminate_rod(shape, k, points, &rods[k], &found);
      substitute_rod(shape, k, points, rods[k], &rows[k]);
    }
    *right_side = seen;
    see_lanes(found, largest);
  });
}

void substitute_down(const Shape& shape, const Pack<>* inverse_mass, const BranchRod* rods, BranchRow* rows,
                     Pack3<>* F) {
  dispatch([=, &shape] {
    for (std::size_t k = shape.num_rods; k-- > 0;) {
      const auto parent = static_cast<std::size_t>(shape.parent[k]);
      const Pack3<> of_parent = F[parent];
      const Pack<> lambda = -rows[k].z * rods[k].inverse_pivot - dot(rods[k].h, of_parent);
      rows[k].z = lambda;
      const Pack3<> own = lambda * rods[k].u;
      (of_parent + own).write(&F[parent]);
      (F[k] - own).write(&F[k]);
    }
    for (std::size_t i = 0; i < shape.num_points(); ++i) (inverse_mass[i] * F[i]).write(&F[i]);
  });
}

void find_reactions(const Shape& shape, const Pack<>* inverse_mass, const BranchRod* rods, const Pack<>* lambda,
                    Pack3<>* dw) {
  dispatch([=, &shape] {
    clear(shape, dw);
    for (std::size_t k = 0; k < shape.num_rods; ++k) {
      const auto parent = static_cast<std::size_t>(shape.parent[k]);
      const Pack3<> own = lambda[k] * rods[k].u;
      (dw[parent] + own).write(&dw[parent]);
      (dw[k] - own).write(&dw[k]);
    }
    for (std::size_t i = 0; i < shape.num_points(); ++i) (inverse_mass[i] * dw[i]).write(&dw[i]);
  });
}

void evaluate_values(const Shape& shape, const Pack3<>* r, const Pack3<>* offset, const Pack<>* length, BranchRow* rows,
                     Largest* largest) {
  dispatch([=, &shape] {
    Largest seen = *largest;
    for (std::size_t k = 0; k < shape.num_rods; ++k) {
      const Pack3<> apart = distance(shape, r, offset, k);
      Pack<> rho = dot(apart, apart);
      take_roots(&rho);
      rows[k].b = rho - length[k];
      seen.see(magnitude(rows[k].b) / length[k]);
    }
    *largest = seen;
  });
}

void evaluate_rates(const Shape& shape, const Pack3<>* r, const Pack3<>* v, const Pack3<>* offset, BranchRow* rows,
                    Largest* largest) {
  dispatch([=, &shape] {
    Largest seen = *largest;
    for (std::size_t k = 0; k < shape.num_rods; ++k) {
      Pack<> inverse;
      const Pack3<> u = direction(shape, r, offset, k, &inverse);
      rows[k].b = dot(u, v[static_cast<std::size_t>(shape.parent[k])] - v[k]);
      seen.see(magnitude(rows[k].b));
    }
    *largest = seen;
  });
}

void find_residual(const Shape& shape, const BranchRod* rods, const BranchRow* rows, const Pack3<>* dw,
                   Largest* residual) {
  dispatch([=, &shape] {
    Largest seen = *residual;
    for (std::size_t k = 0; k < shape.num_rods; ++k) {
      const Pack<> left = dot(rods[k].u, dw[static_cast<std::size_t>(shape.parent[k])] - dw[k]) + rows[k].b;
      seen.see(magnitude(left));
    }
    *residual = seen;
  });
}

// ---- rod by rod ----

namespace {

/// Evaluates u and the block of a rod. Returns 1/|r_p - r_c|.
[[gnu::always_inline]] inline double find_direction(const Tree& tree, const Motion& motion, std::size_t a) {
  const auto& [row, child, parent] = tree.rods[a];
  Vec3 apart = load(motion.r, parent) - load(motion.r, child);
  if (motion.offset != nullptr) apart = apart + motion.offset[a];
  const double inverse = 1.0 / std::sqrt(dot(apart, apart));
  tree.u[a] = inverse * apart;
  if (motion.blocks != nullptr) store(motion.blocks, motion.block[a], static_cast<double>(motion.sign[a]) * tree.u[a]);
  return inverse;
}

[[gnu::always_inline]] inline void evaluate_rod(const Tree& tree, const Motion& motion, std::size_t a) {
  const auto& [row, child, parent] = tree.rods[a];
  const double inverse = find_direction(tree, motion, a);
  const Vec3 u = tree.u[a], rate = load(motion.v, parent) - load(motion.v, child);
  double b = second_derivative_of_distance(u, rate, inverse);
  if (motion.length_second != nullptr) b -= motion.length_second[a];
  if (motion.uniform == nullptr) {
    b += dot(u, load(motion.w0, parent) - load(motion.w0, child));
  } else if (child >= tree.num_moving) {  // otherwise the same w0 of both drops out
    b += dot(u, *motion.uniform - load(motion.w0, child));
  }
  motion.b[row] = b;
}

[[gnu::always_inline]] inline void eliminate_rod(const Tree& tree, std::size_t a, Mobility<Vec3>* mobility,
                                                 LargestInverse* largest) {
  const auto& [row, child, parent] = tree.rods[a];
  const Vec3 u = tree.u[a], h = mobility[parent] * u;
  double pivot = dot(u, h), diagonal = tree.inverse_mass[parent];
  if (child < tree.num_moving) {
    pivot += dot(u, mobility[child] * u);
    diagonal += tree.inverse_mass[child];
  }
  const double inverse = 1.0 / pivot;
  largest->see(dot(u, u) * diagonal * inverse);
  const Vec3 scaled = inverse * h;
  subtract(&mobility[parent], h, scaled);
  tree.h[a] = scaled;
  tree.inverse_pivot[a] = inverse;
}

[[gnu::always_inline]] inline void substitute_rod(const Tree& tree, std::size_t a, double b, double* s, double* z) {
  const auto& [row, child, parent] = tree.rods[a];
  const Vec3 of_parent = load(s, parent);
  const Vec3 apart = child < tree.num_moving ? of_parent - load(s, child) : of_parent;
  const double z_a = b + dot(tree.u[a], apart);
  z[row] = z_a;
  store(s, parent, of_parent - z_a * tree.h[a]);
}

}  // namespace

void find_directions(const Tree& tree, const Motion& motion) {
  dispatch([=, &tree, &motion] {
    for (std::size_t a = 0; a < tree.num_rods; ++a) find_direction(tree, motion, a);
  });
}

void evaluate(const Tree& tree, const Motion& motion) {
  dispatch([=, &tree, &motion] {
    for (std::size_t a = 0; a < tree.num_rods; ++a) evaluate_rod(tree, motion, a);
  });
}

void eliminate(const Tree& tree, Mobility<Vec3>* mobility, LargestInverse* largest) {
  dispatch([=, &tree] {
    LargestInverse found = *largest;
    for (std::size_t a = 0; a < tree.num_rods; ++a) eliminate_rod(tree, a, mobility, &found);
    *largest = found;
  });
}

void evaluate_and_eliminate(const Tree& tree, const Motion& motion, Mobility<Vec3>* mobility, double* s, double* z,
                            LargestInverse* largest) {
  dispatch([=, &tree, &motion] {
    LargestInverse found = *largest;
    for (std::size_t a = 0; a < tree.num_rods; ++a) {
      evaluate_rod(tree, motion, a);
      eliminate_rod(tree, a, mobility, &found);
      substitute_rod(tree, a, motion.b[tree.rods[a].row], s, z);
    }
    *largest = found;
  });
}

void substitute_up(const Tree& tree, const double* b, double* s, double* z) {
  dispatch([=, &tree] {
    for (std::size_t a = 0; a < tree.num_rods; ++a) substitute_rod(tree, a, b[tree.rods[a].row], s, z);
  });
}

void substitute_down(const Tree& tree, double* force, double* lambda) {
  dispatch([=, &tree] {
    for (std::size_t a = tree.num_rods; a-- > 0;) {
      const auto& [row, child, parent] = tree.rods[a];
      const Vec3 F = load(force, parent);
      const double lambda_a = -lambda[row] * tree.inverse_pivot[a] - dot(tree.h[a], F);
      lambda[row] = lambda_a;
      const Vec3 own = lambda_a * tree.u[a];
      store(force, parent, F + own);
      if (child < tree.num_moving) store(force, child, load(force, child) - own);
    }
  });
}

}  // namespace tanor::detail::trees
