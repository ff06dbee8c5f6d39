#pragma once

#include <cmath>
#include <cstddef>

#include <tanor/system.hpp>

#include "base/pack.hpp"
#include "base/vec3.hpp"

/// \file Arithmetic of trees from the leaves to the root and back: of branches of one shape, eight side by side in
/// the lanes of a vector, and rod by rod of the trunks that they hang on. See instruction_sets.hpp.
///
/// A point whose branches are eliminated answers a force F of the rods that are left by dw = s + W F. Its mobility W is
/// 1/m less what its branches hold.
namespace tanor::detail::trees {

/// A symmetric 3 x 3 matrix, which acts on vectors of numbers or of lanes.
template <class Vector>
struct Mobility {
  using Number = decltype(Vector::x);
  Number xx, xy, xz, yy, yz, zz;

  static Mobility of_free_point(const Number& inverse_mass) {
    const Number nothing{};
    return {inverse_mass, nothing, nothing, inverse_mass, nothing, inverse_mass};
  }
  [[gnu::always_inline]] friend Vector operator*(const Mobility& W, const Vector& F) {
    return {W.xx * F.x + W.xy * F.y + W.xz * F.z, W.xy * F.x + W.yy * F.y + W.yz * F.z,
            W.xz * F.x + W.yz * F.y + W.zz * F.z};
  }
};

/// The largest S_aa/pivot, infinite if a pivot is not positive.
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

/// The factor of a rod: its direction u from the child to the parent, h = W u of the parent (before the rod) over the
/// pivot d, and 1/d.
struct BranchRod {
  Pack3<> u, h;
  Pack<> inverse_pivot;
};
/// The row of a rod: b = phi + K'w0, and z = b + u.(s_p - s_c), which becomes lambda.
struct BranchRow {
  Pack<> b, z;
};

/// Positions and motion of the points of branches.
struct BranchMotion {
  const Pack3<>*r, *v;
  const Pack3<>* w0;            ///< null if all points have the same
  const Pack3<>* offset;        ///< [rod] from the child to the parent; null if there are none
  const Pack<>* length_second;  ///< [rod] l''; null if 0
};
/// The effect of eliminated branches at each point.
struct BranchPoints {
  const Pack<>* inverse_mass;
  Mobility<Pack3<>>* mobility;
  Pack3<>* s;
};

/// Evaluates u of rods at r.
void find_directions(const Shape& shape, const Pack3<>* r, const Pack3<>* offset, BranchRod* rods);
/// Evaluates u and b of rods.
void evaluate(const Shape& shape, const BranchMotion& motion, BranchRod* rods, BranchRow* rows, Largest* right_side);
/// Computes h/d and pivots d = u'(W_c + W_p) u, and W_p -= h h'/d.
void eliminate(const Shape& shape, const BranchPoints& points, BranchRod* rods, LargestInverse* largest);
/// Computes z of rows with b, and s_p -= z h/d. On entry, s is what other forces make.
void substitute_up(const Shape& shape, const BranchPoints& points, const BranchRod* rods, BranchRow* rows);
/// Does all three in one pass, so that one rod's evaluation runs while another one's pivot is waited for.
void evaluate_and_eliminate(const Shape& shape, const BranchMotion& motion, const BranchPoints& points, BranchRod* rods,
                            BranchRow* rows, Largest* right_side, LargestInverse* largest);
/// Computes lambda = -z/d - (h/d).F_p in z's place, F_p += u lambda and F_c -= u lambda. F of the root is the force
/// that acts there from outside. Then dw := F/m replaces F.
void substitute_down(const Shape& shape, const Pack<>* inverse_mass, const BranchRod* rods, BranchRow* rows,
                     Pack3<>* F);
/// Computes dw := M^-1 K lambda from lambda [rod].
void find_reactions(const Shape& shape, const Pack<>* inverse_mass, const BranchRod* rods, const Pack<>* lambda,
                    Pack3<>* dw);
/// Evaluates xi at r in b's place, and the largest |xi|/length.
void evaluate_values(const Shape& shape, const Pack3<>* r, const Pack3<>* offset, const Pack<>* length, BranchRow* rows,
                     Largest* largest);
/// Evaluates the rates of constant lengths at (r, v) in b's place, and the largest one.
void evaluate_rates(const Shape& shape, const Pack3<>* r, const Pack3<>* v, const Pack3<>* offset, BranchRow* rows,
                    Largest* largest);
/// Finds the largest |K'dw + b|.
void find_residual(const Shape& shape, const BranchRod* rods, const BranchRow* rows, const Pack3<>* dw,
                   Largest* residual);

// ---- rod by rod ----

/// A rod that joins a point to the next one towards the root. A support in the child's place has no mobility.
struct Rod {
  Index row, child, parent;
};

/// The rods of an island, children before parents.
struct Tree {
  const Rod* rods;
  std::size_t num_rods;
  Index num_moving;            ///< points from here on are supports
  const double* inverse_mass;  ///< [point]
  Vec3* u;                     ///< [rod] unit, from the child to the parent
  Vec3* h;                     ///< [rod] W u of the parent, before the rod, over the pivot
  double* inverse_pivot;       ///< [rod]
};

/// Positions of points and their motion [3n], and the results for the rods [row, block].
struct Motion {
  const double *r, *v, *w0;
  const Vec3* uniform;          ///< w0 of moving points; null if `w0` has it
  const Vec3* offset;           ///< [rod] from the child to the parent; null if there are none
  const double* length_second;  ///< [rod] l''; null if 0
  const signed char* sign;      ///< [rod] sign of the block
  const std::size_t* block;     ///< [rod]
  double *blocks, *b;           ///< the blocks may be null
};

/// Evaluates u and the blocks of rods at r; of `motion` the rest is not read.
void find_directions(const Tree& tree, const Motion& motion);

/// Evaluates u, the blocks and b = phi + K'w0 of rods.
void evaluate(const Tree& tree, const Motion& motion);

/// Eliminates as for branches. `mobility` [point] is that after all eliminations so far, on entry and on return.
void eliminate(const Tree& tree, Mobility<Vec3>* mobility, LargestInverse* largest);

/// Does all three in one pass, as for branches; `s` [3n] and z [row] are as in `substitute_up`.
void evaluate_and_eliminate(const Tree& tree, const Motion& motion, Mobility<Vec3>* mobility, double* s, double* z,
                            LargestInverse* largest);

/// Substitutes as for branches; z is [row], `s` is [3n].
void substitute_up(const Tree& tree, const double* b, double* s, double* z);

/// Substitutes as for branches. lambda [row] replaces z. `force` [3n] is 0 on entry and K lambda of these rods on
/// return.
void substitute_down(const Tree& tree, double* force, double* lambda);

}  // namespace tanor::detail::trees
