#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <span>

#include <tanor/system.hpp>

#include "base/instruction_sets.hpp"
#include "base/pack.hpp"
#include "base/vec3.hpp"
#include "schur/lane_plan.hpp"

/// \file Arithmetic of rods in groups of eight equal islands, or of eight pieces of trees, side by side in the lanes of
/// a vector. See instruction_sets.hpp.
///
/// Two programs eliminate S. That of equal islands is written down in a schedule. Pieces of trees (tree_pieces.cpp) are
/// eliminated from the leaves to the roots: a point whose branches are eliminated answers a force F of the rods that
/// are left by dw = s + W F. Its mobility W is 1/m less what its branches hold.
namespace tanor::detail::lanes {

/// How the rods of a group join its places.
struct Shape {
  std::size_t num_rods, num_places;
  const IslandStructure* structure;  ///< of equal islands; null for pieces of trees
  const Index* parent;               ///< [rod][lane] of pieces, whose rod k joins the child at place k to its parent
  bool have_same_parents;

  bool are_pieces() const { return structure == nullptr; }
};

/// Symmetric 3 x 3 matrices.
struct Mobility {
  Pack<> xx, xy, xz, yy, yz, zz;
};
/// The factor of a rod of a tree: h = W u of the parent (before the rod) over the pivot d, and 1/d. Its direction u
/// from the child to the parent is stored apart.
struct RodFactor {
  Pack3<> h;
  Pack<> inverse_pivot;
};
/// The roots of a group of pieces, which may be joints of others: W, s, and the force from above, which becomes dw.
struct Joint {
  Mobility mobility;
  Pack3<> s, dw;
};
/// Positions and motion of the points.
struct Motion {
  const Pack3<>*r, *v;
  const Pack3<>* w0;            ///< null if all points have the same
  const Pack3<>* offset;        ///< [rod] in the direction of u; null if there are none
  const Pack<>* length_second;  ///< [rod] l''; null if 0
};
/// The points of a group.
struct Points {
  const Pack<>* inverse_mass;
  Mobility* mobility;  ///< of pieces
  Pack3<>* s;          ///< what eliminated branches and other forces make; null if 0, but for pieces
};
/// The rods of a group.
struct Rods {
  Pack3<>* u;
  Pack<>* factor;                ///< as in IslandSchedule [slot], or RodFactor [rod]
  Pack<>*b, *z;                  ///< b = phi + K'w0, and b + K's of pieces, then lambda
  const Pack<>* inverse_masses;  ///< 1/m of both ends, summed, of pieces

  RodFactor& rod_factor(std::size_t k) const { return reinterpret_cast<RodFactor*>(factor)[k]; }
};

/// The largest numbers that were found in each lane.
struct Findings {
  Pack<> largest_inverse = Pack<>{} + 1.0;  ///< S_aa over the pivots; infinite if one of these is not positive
  Largest right_side, residual, own_residual;

  /// Includes the largest |b| and residual of one island in each lane.
  [[gnu::always_inline]] void include(const Pack<>& largest_b, const Pack<>& largest_left) {
    right_side.see(largest_b);
    residual.see(largest_left);
    own_residual.see(largest_left / (largest_b + std::numeric_limits<double>::min()));
  }
};

/// Frees all points: W = 1/m and s = 0.
void free_points(const Shape& shape, const Points& points);
/// Evaluates u of rods at r.
void find_directions(const Shape& shape, const Pack3<>* r, const Pack3<>* offset, Pack3<>* u);
/// Evaluates u and b of rods, and the largest |b|.
void evaluate(const Shape& shape, const Motion& motion, const Rods& rods, Pack<>* right_side);
/// Factorizes S. The pivot of a rod of a tree is d = u'(W_c + W_p) u, and W_p -= h h'/d.
void eliminate(const Shape& shape, const Points& points, const Rods& rods, Findings* found);
/// Solves S lambda = -(b + K's), of pieces the way up to the roots: z, and s_p -= z h/d.
void substitute_up(const Shape& shape, const Points& points, const Rods& rods);
/// Does all three for pieces, in one pass, so that one rod's evaluation runs while another one's pivot is waited for.
void evaluate_and_eliminate(const Shape& shape, const Motion& motion, const Points& points, const Rods& rods,
                            Pack<>* right_side, Findings* found);
/// Ends a solve of whole islands with the factor that there is: lambda, unless `is_substituted` up to the roots, then
/// F = K lambda, and the rest as `accelerate`. Includes the residual and the right side in what was found.
void finish(const Shape& shape, const Points& points, const Rods& rods, bool is_substituted, Pack3<>* F,
            const Pack3<>* w0, Vec3 uniform, Pack3<>* w, const Pack<>* right_side, Findings* found);
/// Computes the forces F = K lambda, and points += F/m unless these are null. On the way down pieces,
/// lambda = -z/d - (h/d).F_p takes z's place, unless it is known. If there is a force on the roots from outside, it is
/// added to F.
void substitute_down(const Shape& shape, const Pack<>* inverse_mass, const Rods& rods, bool lambda_is_known,
                     const Pack3<>* on_roots, Pack3<>* F, Pack3<>* points);
/// Computes dw = F/m in F's place and w := w0 + dw. If w0 is null, it is `uniform` for all points.
void accelerate(const Shape& shape, const Pack<>* inverse_mass, Pack3<>* F, const Pack3<>* w0, Vec3 uniform,
                Pack3<>* w);
/// Finds the largest |K'dw + b|.
void find_residual(const Shape& shape, const Rods& rods, const Pack3<>* dw, Pack<>* residual);
/// Evaluates xi at r in b's place, and the largest |xi|/length.
void evaluate_values(const Shape& shape, const Pack3<>* r, const Pack3<>* offset, const Pack<>* length, Pack<>* b,
                     Pack<>* largest);
/// Evaluates K'v + xi_t in b's place with K of u, and the largest one. `length_first` is l' [rod]; null if 0.
void evaluate_rates(const Shape& shape, const Pack3<>* u, const Pack3<>* v, const Pack<>* length_first, Pack<>* b,
                    Pack<>* largest);

/// Take W, or dw, of joints at their places.
void take_mobilities(std::span<const JointPlace> places, const Joint* joints, Mobility* mobility);
void take_joints(std::span<const JointPlace> places, const Joint* joints, Pack3<>* points);
/// Computes s of joints from the force [place] on them, if it is not null, and from what hangs there.
void answer_at_joints(std::span<const JointPlace> places, const Joint* joints, const Pack3<>* force, Pack3<>* s);
/// Hands F of joints down, with the `known` forces [place] unless they are null.
void pull_joints(std::span<const JointPlace> places, const Pack3<>* F, const Pack3<>* known, Joint* joints);

// ---- the ends of rods ----

/// Numbers in arrays of cells of packs, in one place of all lanes:
struct SamePlace {
  std::size_t place;
  [[gnu::always_inline]] explicit SamePlace(std::size_t given) : place(given) {}
  [[gnu::always_inline]] explicit SamePlace(const Index* places) : place(static_cast<std::size_t>(places[0])) {}
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
struct OwnPlaces {
  std::size_t place[num_lanes];
  [[gnu::always_inline]] explicit OwnPlaces(const Index* places) {
    for (std::size_t lane = 0; lane < num_lanes; ++lane) place[lane] = static_cast<std::size_t>(places[lane]);
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
template <class Place>
[[gnu::always_inline]] inline Pack3<> get(const Place& place, const Pack3<>* points) {
  return {place.get(points, 0), place.get(points, 1), place.get(points, 2)};
}
template <class Place>
[[gnu::always_inline]] inline void set(const Place& place, Pack3<>* points, const Pack3<>& value) {
  place.set(points, 0, value.x);
  place.set(points, 1, value.y);
  place.set(points, 2, value.z);
}

/// The ends of rods; u points from the first to the second. Those of equal islands are the same in all lanes:
struct EqualEnds {
  static constexpr bool are_of_pieces = false;
  const std::array<int, 2>* ends;
  [[gnu::always_inline]] SamePlace first(std::size_t k) const { return SamePlace(&ends[k][0]); }
  [[gnu::always_inline]] SamePlace second(std::size_t k) const { return SamePlace(&ends[k][1]); }
};
/// The rods of pieces go from child to parent. Parents are the same in all lanes, or each lane has its own:
template <class Parent>
struct PieceEnds {
  static constexpr bool are_of_pieces = true;
  const Index* parents;
  [[gnu::always_inline]] SamePlace first(std::size_t k) const { return SamePlace(k); }
  [[gnu::always_inline]] Parent second(std::size_t k) const { return Parent(parents + num_lanes * k); }
};
/// Returns the numbers at the second end less those at the first one.
template <class Ends>
[[gnu::always_inline]] inline Pack3<> difference(const Ends& ends, std::size_t k, const Pack3<>* points) {
  return get(ends.second(k), points) - get(ends.first(k), points);
}
/// Adds a force to the second end, and takes it from the first one.
template <class Ends>
[[gnu::always_inline]] inline void pull(const Ends& ends, std::size_t k, const Pack3<>& force, Pack3<>* F) {
  set(ends.first(k), F, get(ends.first(k), F) - force);
  set(ends.second(k), F, get(ends.second(k), F) + force);
}

/// Calls body(ends) with the kind of ends that the shape has.
template <class Body>
[[gnu::always_inline]] inline void with_ends(const Shape& shape, const Body& body) {
  if (!shape.are_pieces()) return body(EqualEnds{shape.structure->topology.rods.data()});
  shape.have_same_parents ? body(PieceEnds<SamePlace>{shape.parent}) : body(PieceEnds<OwnPlaces>{shape.parent});
}

}  // namespace tanor::detail::lanes
