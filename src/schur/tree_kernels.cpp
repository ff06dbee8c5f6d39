#include "schur/tree_kernels.hpp"

#include <algorithm>
#include <cmath>

#include "base/instruction_sets.hpp"
#include "base/parallel.hpp"

namespace tanor_kernels::trees {

using tanor::load, tanor::store, tanor::dot;

namespace {

[[gnu::always_inline]] inline Vec3 times(const Mobility& W, Vec3 u) {
  return {W.xx * u.x + W.xy * u.y + W.xz * u.z, W.xy * u.x + W.yy * u.y + W.yz * u.z,
          W.xz * u.x + W.yz * u.y + W.zz * u.z};
}

/// W -= scaled h', symmetric
[[gnu::always_inline]] inline void subtract(Mobility* W, Vec3 h, Vec3 scaled) {
  W->xx -= scaled.x * h.x;
  W->xy -= scaled.x * h.y;
  W->xz -= scaled.x * h.z;
  W->yy -= scaled.y * h.y;
  W->yz -= scaled.y * h.z;
  W->zz -= scaled.z * h.z;
}

/// Returns |b|.
[[gnu::always_inline]] inline double evaluate_rod(const Tree& tree, const Motion& motion, std::size_t a) {
  const auto& [row, child, parent] = tree.rods[a];
  Vec3 apart = load(motion.r, parent) - load(motion.r, child);
  if (motion.offset != nullptr) apart = apart + motion.offset[a];
  const Vec3 rate = load(motion.v, parent) - load(motion.v, child);
  // u = a/|a|, phi = (v.v - (u.v)^2)/|a| - l''
  const double inverse = 1.0 / std::sqrt(dot(apart, apart));
  const Vec3 u = inverse * apart;
  const double along = dot(u, rate);
  double b = inverse * (dot(rate, rate) - along * along);
  if (motion.length_second != nullptr) b -= motion.length_second[a];
  if (motion.uniform == nullptr) {
    b += dot(u, load(motion.w0, parent) - load(motion.w0, child));
  } else if (child >= tree.num_moving) {  // else the same w0 of both drops out
    b += dot(u, *motion.uniform - load(motion.w0, child));
  }
  tree.u[a] = u;
  motion.b[row] = b;
  store(motion.blocks, motion.block[a], static_cast<double>(motion.sign[a]) * u);
  return std::abs(b);
}

[[gnu::always_inline]] inline void eliminate_rod(const Tree& tree, std::size_t a, Mobility* mobility,
                                                 PivotRange* range) {
  const auto& [row, child, parent] = tree.rods[a];
  const Vec3 u = tree.u[a], h = times(mobility[parent], u);
  double pivot = dot(u, h), diagonal = tree.inverse_mass[parent];
  if (child < tree.num_moving) {
    pivot += dot(u, times(mobility[child], u));
    diagonal += tree.inverse_mass[child];
  }
  const double inverse = 1.0 / pivot, ratio = dot(u, u) * diagonal * inverse;
  range->smallest = std::min(range->smallest, ratio);
  range->largest = tanor::larger(range->largest, ratio);
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

TANOR_EACH_INSTRUCTION_SET
double evaluate(const Tree& tree, const Motion& motion, double largest) {
  for (std::size_t a = 0; a < tree.num_rods; ++a) {
    largest = tanor::larger(largest, evaluate_rod(tree, motion, a));
  }
  return largest;
}

TANOR_EACH_INSTRUCTION_SET
void eliminate(const Tree& tree, Mobility* mobility, PivotRange* range) {
  PivotRange found = *range;
  for (std::size_t a = 0; a < tree.num_rods; ++a) eliminate_rod(tree, a, mobility, &found);
  *range = found;
}

TANOR_EACH_INSTRUCTION_SET
double evaluate_and_eliminate(const Tree& tree, const Motion& motion, double largest, Mobility* mobility, double* s,
                              double* z, PivotRange* range) {
  PivotRange found = *range;
  for (std::size_t a = 0; a < tree.num_rods; ++a) {
    largest = tanor::larger(largest, evaluate_rod(tree, motion, a));
    eliminate_rod(tree, a, mobility, &found);
    substitute_rod(tree, a, motion.b[tree.rods[a].row], s, z);
  }
  *range = found;
  return largest;
}

TANOR_EACH_INSTRUCTION_SET
void substitute_up(const Tree& tree, const double* b, double* s, double* z) {
  for (std::size_t a = 0; a < tree.num_rods; ++a)
    substitute_rod(tree, a, b != nullptr ? b[tree.rods[a].row] : 0.0, s, z);
}

TANOR_EACH_INSTRUCTION_SET
void substitute_down(const Tree& tree, double* force, double* lambda) {
  for (std::size_t a = tree.num_rods; a-- > 0;) {
    const auto& [row, child, parent] = tree.rods[a];
    const Vec3 F = load(force, parent);
    const double lambda_a = -lambda[row] * tree.inverse_pivot[a] - dot(tree.h[a], F);
    lambda[row] = lambda_a;
    const Vec3 own = lambda_a * tree.u[a];
    store(force, parent, F + own);
    if (child < tree.num_moving) store(force, child, load(force, child) - own);
  }
}

}  // namespace tanor_kernels::trees
