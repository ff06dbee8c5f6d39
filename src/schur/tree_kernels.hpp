#pragma once

#include <cmath>
#include <cstddef>

#include <tanor/system.hpp>

#include "base/eight.hpp"
#include "base/vec3.hpp"

/// \file Arithmetic of TreeSolver from the leaves to the root and back: of branches of one shape, eight side by side in
/// the lanes of a vector, and rod by rod of what they hang on. See instruction_sets.hpp.
///
/// A point whose branches are eliminated answers a force F of the rods that are left by dw = s + W F: its mobility W
/// is 1/m less what its branches hold.
namespace tanor::trees {

/// Symmetric 3 x 3, which acts on vectors of numbers or lanes.
template <class Vector>
struct Mobility {
  using Number = decltype(Vector::x);
  Number xx, xy, xz, yy, yz, zz;

  static Mobility of_free_point(const Number& inverse_mass) {
    const Number nothing{};
    return {inverse_mass, nothing, nothing, inverse_mass, nothing, inverse_mass};
  }
};

/// The largest S_aa/pivot; infinite where a pivot is not positive.
struct LargestInverse {
  double value = 1.0;
  void see(double ratio) { value = std::fmax(value, ratio > 0.0 ? ratio : HUGE_VAL); }
};

// ---- branches of one shape ----

/// Rod k of a branch joins its point k, from the leaves on, to point parent[k]; the branch's own root is the last
/// point. No rod ends at a support.
struct Shape {
  const Index* parent;
  std::size_t num_rods;
  std::size_t num_points() const { return num_rods + 1; }
};

/// What a factor keeps of a rod: its direction u from the child to the parent, W u of the parent (before the rod) over
/// the pivot d, and 1/d.
struct BranchRod {
  Eight3 u, h;
  Eight inverse_pivot;
};
/// b = phi + K'w0 of a rod, and z = b + u.(s_p - s_c), which becomes lambda.
struct BranchRow {
  Eight b, z;
};

/// Where points of branches are and how they move.
struct BranchMotion {
  const Eight3 *r, *v;
  const Eight3* w0;            ///< null: all have the same
  const Eight3* offset;        ///< [rod] from the child to the parent; null: none
  const Eight* length_second;  ///< [rod] l''; null: 0
};
/// What eliminated branches leave at each point.
struct BranchPoints {
  const Eight* inverse_mass;
  Mobility<Eight3>* mobility;
  Eight3* s;
};

/// u and b of rods.
void evaluate(const Shape& shape, const BranchMotion& motion, BranchRod* rods, BranchRow* rows, Largest* right_side);
/// h/d and pivots d = u'(W_c + W_p) u; W_p -= h h'/d.
void eliminate(const Shape& shape, const BranchPoints& points, BranchRod* rods, LargestInverse* largest);
/// z of rows with b, s_p -= z h/d.
void substitute_up(const Shape& shape, const BranchPoints& points, const BranchRod* rods, BranchRow* rows);
/// All three in one pass: one rod's evaluation runs while another one's pivot is waited for.
void evaluate_and_eliminate(const Shape& shape, const BranchMotion& motion, const BranchPoints& points, BranchRod* rods,
                            BranchRow* rows, Largest* right_side, LargestInverse* largest);
/// lambda = -z/d - (h/d).F_p in z's place, F_p += u lambda, F_c -= u lambda; F of the root is what pulls there from
/// outside. Then dw := F/m in F's place.
void substitute_down(const Shape& shape, const Eight* inverse_mass, const BranchRod* rods, BranchRow* rows, Eight3* F);
/// dw := M^-1 K lambda [rod]
void find_reactions(const Shape& shape, const Eight* inverse_mass, const BranchRod* rods, const Eight* lambda,
                    Eight3* dw);
/// xi in b's place, at r, and the largest |xi|/length.
void evaluate_values(const Shape& shape, const Eight3* r, const Eight3* offset, const Eight* length, BranchRow* rows,
                     Largest* largest);
/// Rates of constant lengths in b's place, at (r, v), and the largest.
void evaluate_rates(const Shape& shape, const Eight3* r, const Eight3* v, const Eight3* offset, BranchRow* rows,
                    Largest* largest);
/// The largest |K'dw + b|.
void find_residual(const Shape& shape, const BranchRod* rods, const BranchRow* rows, const Eight3* dw,
                   Largest* residual);

// ---- rod by rod ----

/// Joins a point to the next one towards the root; a support in the child's place has no mobility.
struct Rod {
  Index row, child, parent;
};

/// Rods of an island, children before parents.
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

/// u, the blocks and b = phi + K'w0 of rods.
void evaluate(const Tree& tree, const Motion& motion);

/// As for branches. `mobility` [point] is that of all that is eliminated, on entry and in the end.
void eliminate(const Tree& tree, Mobility<Vec3>* mobility, LargestInverse* largest);

/// As for branches, all three in one pass; `s` [3n] and z [row] as in `substitute_up`.
void evaluate_and_eliminate(const Tree& tree, const Motion& motion, Mobility<Vec3>* mobility, double* s, double* z,
                            LargestInverse* largest);

/// As for branches: z [row], `s` [3n].
void substitute_up(const Tree& tree, const double* b, double* s, double* z);

/// As for branches: lambda [row] in z's place; `force` [3n] is 0 on entry, K lambda of these rods in the end.
void substitute_down(const Tree& tree, double* force, double* lambda);

}  // namespace tanor::trees
