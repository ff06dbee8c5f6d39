#pragma once

#include <cstddef>
#include <span>

#include <tanor/system.hpp>

#include "base/pack.hpp"
#include "base/vec3.hpp"
#include "schur/tree_pieces.hpp"

/// \file Arithmetic of pieces of trees (tree_pieces.hpp) from the leaves to the roots and back, eight side by side in
/// the lanes of a vector. See instruction_sets.hpp.
///
/// A point whose branches are eliminated answers a force F of the rods that are left by dw = s + W F. Its mobility W is
/// 1/m less what its branches hold.
namespace tanor::detail::trees {

/// The parents of the rods of a group.
struct Shape {
  const Index* parent;  ///< [rod][lane]
  std::size_t num_rods, num_places;
  bool have_same_parents;
};

/// Symmetric 3 x 3 matrices.
struct Mobility {
  Pack<> xx, xy, xz, yy, yz, zz;
};
/// The factor of a rod: h = W u of the parent (before the rod) over the pivot d, and 1/d. Its direction u from the
/// child to the parent is stored apart.
struct RodFactor {
  Pack3<> h;
  Pack<> inverse_pivot;
};
/// Positions and motion of the points.
struct Motion {
  const Pack3<>*r, *v;
  const Pack3<>* w0;            ///< null if all points have the same
  const Pack3<>* offset;        ///< [rod] from the child to the parent; null if there are none
  const Pack<>* length_second;  ///< [rod] l''; null if 0
};
/// The roots of a group of pieces, which may be joints of others: W, s, and the force from above, which becomes dw.
struct Joint {
  Mobility mobility;
  Pack3<> s, dw;
};
/// The effect of eliminated branches at each point.
struct Points {
  const Pack<>* inverse_mass;
  Mobility* mobility;
  Pack3<>* s;
};
/// The rods of a group.
struct Rods {
  Pack3<>* u;
  RodFactor* factor;
  Pack<>*b, *z;                  ///< b = phi + K'w0, and z = b + u.(s_p - s_c), which becomes lambda
  const Pack<>* inverse_masses;  ///< 1/m of both ends, summed
};

/// Frees all points: W = 1/m and s = 0.
void free_points(const Shape& shape, const Points& points);
/// Makes all points 0.
void clear(const Shape& shape, Pack3<>* points);
/// Computes w := w0 + dw.
void add(const Shape& shape, Vec3 w0, const Pack3<>* dw, Pack3<>* w);
/// Evaluates u of rods at r.
void find_directions(const Shape& shape, const Pack3<>* r, const Pack3<>* offset, const Rods& rods);
/// Evaluates u and b of rods.
void evaluate(const Shape& shape, const Motion& motion, const Rods& rods, Largest* right_side);
/// Computes h/d and pivots d = u'(W_c + W_p) u, and W_p -= h h'/d. Returns the largest S_aa/d, infinite if a pivot is
/// not positive.
double eliminate(const Shape& shape, const Points& points, const Rods& rods);
/// Computes z of rows with b, and s_p -= z h/d. On entry, s is what other forces make.
void substitute_up(const Shape& shape, const Points& points, const Rods& rods);
/// Does all three in one pass, so that one rod's evaluation runs while another one's pivot is waited for.
double evaluate_and_eliminate(const Shape& shape, const Motion& motion, const Points& points, const Rods& rods,
                              Largest* right_side);
/// Computes lambda = -z/d - (h/d).F_p in z's place, F_p += u lambda and F_c -= u lambda. On entry, F of the roots is
/// the force that acts there from outside.
void substitute_down(const Shape& shape, const Rods& rods, Pack3<>* F);
/// Computes dw := F/m in F's place, or to += F/m.
void accelerate(const Shape& shape, const Points& points, Pack3<>* F);
void accelerate(const Shape& shape, const Points& points, const Pack3<>* F, Pack3<>* to);
/// Computes F := K lambda from lambda [rod].
void find_reactions(const Shape& shape, const Rods& rods, const Pack<>* lambda, Pack3<>* F);
/// Evaluates xi at r in b's place, and the largest |xi|/length.
void evaluate_values(const Shape& shape, const Pack3<>* r, const Pack3<>* offset, const Pack<>* length,
                     const Rods& rods, Largest* largest);
/// Evaluates K'v + xi_t at (r, v) in b's place, and the largest one. `length_first` is l' [rod]; null if 0.
void evaluate_rates(const Shape& shape, const Pack3<>* r, const Pack3<>* v, const Pack3<>* offset,
                    const Pack<>* length_first, const Rods& rods, Largest* largest);
/// Finds the largest |K'dw + b|.
void find_residual(const Shape& shape, const Rods& rods, const Pack3<>* dw, Largest* residual);

/// Take W, or dw, of joints at their places.
void take_mobilities(std::span<const JointPlace> places, const Joint* joints, Mobility* mobility);
void take_joints(std::span<const JointPlace> places, const Joint* joints, Pack3<>* points);
/// Computes s of joints from the force [place] on them, if it is not null, and from what hangs there.
void answer_at_joints(std::span<const JointPlace> places, const Joint* joints, const Pack3<>* force, Pack3<>* s);
/// Hands F of joints down, with the `known` forces [place] unless they are null.
void pull_joints(std::span<const JointPlace> places, const Pack3<>* F, const Pack3<>* known, Joint* joints);

/// Copies points that stand anywhere into lanes and back. A number ~p stands for point p, which is not written.
void gather_places(const double* from, const Index* points, std::size_t count, Pack3<>* to);
void scatter_places(const Pack3<>* from, const Index* points, std::size_t count, double* to);
/// Writes directions as blocks of K but for rods of nobody; the direction of block ~k is turned.
void scatter_directions(const Pack3<>* u, const Index* rows, const Index* blocks, std::size_t count, double* to);
/// Do the same with numbers of rows; -1 is no row.
void gather_some(const double* from, const Index* rows, std::size_t count, Pack<>* to);
void scatter_some(const Pack<>* from, const Index* rows, std::size_t count, double* to);

/// Numbers of parents, lane by lane, in arrays of cells of packs. In one place:
struct SameParent {
  std::size_t place;
  [[gnu::always_inline]] explicit SameParent(const Index* parents) : place(static_cast<std::size_t>(parents[0])) {}
  template <class Cell>
  [[gnu::always_inline]] Pack<> get(const Cell* cells, std::size_t k) const {
    return reinterpret_cast<const Pack<>*>(cells + place)[k];
  }
  template <class Cell>
  [[gnu::always_inline]] void set(Cell* cells, std::size_t k, const Pack<>& value) const {
    reinterpret_cast<Pack<>*>(cells + place)[k] = value;
  }
};
/// In a place of each lane's own:
struct OwnParents {
  std::size_t place[num_lanes];
  [[gnu::always_inline]] explicit OwnParents(const Index* parents) {
    for (std::size_t lane = 0; lane < num_lanes; ++lane) place[lane] = static_cast<std::size_t>(parents[lane]);
  }
  template <class Cell>
  [[gnu::always_inline]] Pack<> get(const Cell* cells, std::size_t k) const {
    const double* const from = reinterpret_cast<const double*>(cells) + num_lanes * k;
    const auto at = [&](std::size_t lane) __attribute__((always_inline)) {
      return from[place[lane] * (sizeof(Cell) / sizeof(double)) + lane];
    };
    return Pack<>{at(0), at(1), at(2), at(3), at(4), at(5), at(6), at(7)};
  }
  template <class Cell>
  [[gnu::always_inline]] void set(Cell* cells, std::size_t k, const Pack<>& value) const {
    double* const to = reinterpret_cast<double*>(cells) + num_lanes * k;
    for (std::size_t lane = 0; lane < num_lanes; ++lane)
      to[place[lane] * (sizeof(Cell) / sizeof(double)) + lane] = value[lane];
  }
};
template <class Parent>
[[gnu::always_inline]] inline Pack3<> get(const Parent& parent, const Pack3<>* points) {
  return {parent.get(points, 0), parent.get(points, 1), parent.get(points, 2)};
}
template <class Parent>
[[gnu::always_inline]] inline void set(const Parent& parent, Pack3<>* points, const Pack3<>& value) {
  parent.set(points, 0, value.x);
  parent.set(points, 1, value.y);
  parent.set(points, 2, value.z);
}

}  // namespace tanor::detail::trees
