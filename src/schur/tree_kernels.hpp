#pragma once

#include <cstddef>

#include <tanor/system.hpp>

#include "base/vec3.hpp"

/// \file Arithmetic of TreeSolver along the rods of one island, from the leaves to the root and back. See
/// instruction_sets.hpp.
///
/// A point i whose branches are eliminated answers a force F of the rods that are left by dw = s + W F: its mobility W
/// is 1/m less what its branches hold.
namespace tanor_kernels::trees {

using tanor::Index, tanor::Vec3;

/// Joins a point to the next one towards the root; a support in the child's place has no mobility.
struct Rod {
  Index row, child, parent;
};

/// Symmetric 3 x 3.
struct Mobility {
  double xx = 0.0, xy = 0.0, xz = 0.0, yy = 0.0, yz = 0.0, zz = 0.0;
};

/// Of an island: all rods of the tree, children before parents.
struct Tree {
  const Rod* rods;
  std::size_t num_rods;
  Index num_moving;            ///< points from here on are supports
  const double* inverse_mass;  ///< [point]
  Vec3* u;                     ///< [rod] unit, from the child to the parent
  Vec3* h;                     ///< [rod] W u of the parent, before the rod, over the pivot
  double* inverse_pivot;       ///< [rod]
};

/// Where points are and how they move [3n], and what becomes of the rods [row, block].
struct Motion {
  const double *r, *v, *w0;
  const Vec3* uniform;          ///< w0 of moving points; null: `w0` says it
  const Vec3* offset;           ///< [rod] from the child to the parent; null: none
  const double* length_second;  ///< [rod] l''; null: 0
  const signed char* sign;      ///< [rod] of the block
  const std::size_t* block;     ///< [rod]
  double *blocks, *b;
};

/// u, the blocks and b = phi + K'w0 of rods; returns the largest |b|, at least `largest`.
double evaluate(const Tree& tree, const Motion& motion, double largest);

/// Smallest and largest S_aa/pivot.
struct PivotRange {
  double smallest = 1.0, largest = 1.0;
};

/// h/d and pivots d = u'(W_c + W_p) u; W_p -= h h'/d. `mobility` [point] is 1/m on entry.
void eliminate(const Tree& tree, Mobility* mobility, PivotRange* range);

/// All three in one go, `s` and z as below: one rod's evaluation runs while another one's pivot is waited for.
double evaluate_and_eliminate(const Tree& tree, const Motion& motion, double largest, Mobility* mobility, double* s,
                              double* z, PivotRange* range);

/// z = b + u.(s_p - s_c) [row], s_p -= z h/d. `s` [3n] is what other forces do on entry; without b it is 0.
void substitute_up(const Tree& tree, const double* b, double* s, double* z);

/// lambda = -z/d - (h/d).F_p [row] in z's place, F_p += u lambda, F_c -= u lambda. `force` [3n] is 0 on entry, K lambda
/// of the points in the end.
void substitute_down(const Tree& tree, double* force, double* lambda);

}  // namespace tanor_kernels::trees

namespace tanor {
namespace trees = tanor_kernels::trees;
}
