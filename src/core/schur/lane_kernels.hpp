#pragma once

#include <array>
#include <cstddef>
#include <span>

#include <tanor/system.hpp>

#include "base/pack.hpp"
#include "base/vec3.hpp"
#include "schur/findings.hpp"
#include "schur/lane_plan.hpp"
#include "schur/path_separators.hpp"

/// \file Arithmetic of rods in groups of eight equal islands, or pieces of trees or paths, side by side in lanes.
///
/// Three programs eliminate S. That of equal islands is written down in a schedule. Pieces of trees (tree_pieces.cpp)
/// are eliminated from the leaves to the roots: a point whose branches are eliminated answers a force F of the rods
/// that are left by dw = s + W F. Its mobility W is 1/m less what its branches hold. Pieces of paths (path_pieces.cpp)
/// are eliminated from the first rod on; the last one is a separator (path_separators.hpp).
namespace tanor::detail::lanes {

/// Symmetric 3 x 3 matrices of some lanes.
template <std::size_t width>
struct MobilityOf {
  Pack<width> xx, xy, xz, yy, yz, zz;

  [[gnu::always_inline]] Pack3<width> operator*(const Pack3<width>& F) const {
    return {xx * F.x + xy * F.y + xz * F.z, xy * F.x + yy * F.y + yz * F.z, xz * F.x + yz * F.y + zz * F.z};
  }
};
using Mobility = MobilityOf<num_lanes>;
/// The factor of a rod of a tree: h = W u of the parent (before the rod) over the pivot d, and 1/d. u points to it.
struct RodFactor {
  Pack3<> h;
  Pack<> inverse_pivot;
};
/// The factor of a rod of a path, S = L D L': L of the next row, and 1/D; and y = -L^-1 b. Separators have none.
struct PathFactor {
  Pack<> l, inverse_pivot, y;
};
/// The roots of a group of pieces, which may be joints of others: W, s, and the force from above, which becomes dw.
struct Joint {
  Mobility mobility;
  Pack3<> s, dw;
};
/// Arrays of points or blocks that the next pieces of a path need, eight a rod of the lanes. They are prefetched little
/// by little, since a burst of misses would stop everything.
struct Upcoming {
  const double* arrays[3] = {nullptr, nullptr, nullptr};

  [[gnu::always_inline]] void fetch(std::size_t k) const {
    for (const double* const array : arrays) {
      for (std::size_t line = 0; array != nullptr && line < 3; ++line)
        __builtin_prefetch(array + num_lanes * (3 * k + line), 0, 2);
    }
  }
};
/// Positions and motion of the points.
struct Motion {
  const Pack3<>*r, *v;
  const Pack3<>* w0;  ///< null if all points have the same
  Upcoming upcoming;  ///< of pieces of paths
};
/// How the rods of a group join its places.
struct Joints {
  Program program;
  std::size_t num_rods, num_places;
  const IslandSchedule* schedule;  ///< of equal islands, else null
  const Index* parent;             ///< [rod][lane] of trees, whose rod k joins the child at place k to it, else null
  bool have_same_parents;
};
/// A group: its rods, and its arrays.
struct Arrays : Joints {
  // of the points, [place]
  const Pack<>* inverse_mass;
  Mobility* mobility;  ///< of trees
  Pack3<>* s;          ///< what eliminated branches and other forces make; null if 0, but for trees
  Pack3<>* dw;         ///< forces F = K lambda on the way to it
  Pack3<>* points;     ///< positions or velocities that are projected
  // of the rods, [rod]
  Pack3<>* u;
  Pack<>* factor;                                      ///< as in IslandSchedule [slot], RodFactor or PathFactor
  Pack<>*b, *z;                                        ///< b = phi + K'w0, and b + K's of trees, then lambda
  Pack3<>* directions;                                 ///< u where velocities are projected
  Pack<>* sum;                                         ///< of multipliers
  const Pack3<>* offset;                               ///< in the direction of u; null if there are none
  const Pack<>*length, *length_first, *length_second;  ///< l' and l'' are null if no length moves
  Border* border;                                      ///< of paths
  // what is found
  Pack<>*right_side, *residual;
  Findings* found;

  RodFactor& rod_factor(std::size_t k) const { return reinterpret_cast<RodFactor*>(factor)[k]; }
  PathFactor& path_factor(std::size_t k) const { return reinterpret_cast<PathFactor*>(factor)[k]; }
};

/// Evaluates u and b of rods, and the largest |b|. If it `eliminates`, pieces also are factorized and substituted up,
/// in one pass, so that one rod's evaluation runs while another one's pivot is waited for.
void evaluate(const Arrays& arrays, const Motion& motion, bool eliminates);
/// Solves S lambda = -(b + K's), of trees the way up to the roots: z, and s_p -= z h/d; of paths y = -L^-1 b.
void substitute_up(const Arrays& arrays);
/// Ends a solve of pieces of paths: lambda, unless it is known, and dw = M^-1 K lambda. Also computes w := w0 + dw,
/// with w0 as in Motion, and the residual, but for that of separators, unless these are null.
void accelerate_pieces(const Arrays& arrays, bool lambda_is_known, const Upcoming& upcoming, const Pack3<>* w0,
                       Vec3 uniform, Pack3<>* w, Pack<>* residual);

// ---- the ends of rods: each kernel is run for some lanes after the others, see lane_parts.hpp ----

/// Numbers in arrays of cells of packs, in one place of all lanes:
template <class Lanes>
struct SamePlace {
  static constexpr std::size_t width = Lanes::width;
  using Lane = typename Lanes::Lane;
  Lanes part;
  std::size_t place;

  [[gnu::always_inline]] SamePlace(const Lanes& own, std::size_t given) : part(own), place(given) {}
  [[gnu::always_inline]] SamePlace(const Lanes& own, const Index* places)
      : part(own), place(static_cast<std::size_t>(places[0])) {}
  template <class Cell>
  [[gnu::always_inline]] Lane get(const Cell* cells, std::size_t k) const {
    return part.of(reinterpret_cast<const Pack<>*>(cells + place)[k]);
  }
  template <class Cell>
  [[gnu::always_inline]] void set(Cell* cells, std::size_t k, const Lane& value) const {
    part.of(reinterpret_cast<Pack<>*>(cells + place)[k]) = value;
  }
};
/// In a place of each lane's own:
template <class Lanes>
struct OwnPlaces {
  static constexpr std::size_t width = Lanes::width;
  using Lane = typename Lanes::Lane;
  std::size_t first, place[width];

  [[gnu::always_inline]] OwnPlaces(const Lanes& part, const Index* places) : first(part.first()) {
    for (std::size_t lane = 0; lane < Lanes::width; ++lane)
      place[lane] = static_cast<std::size_t>(places[first + lane]);
  }
  template <class Cell>
  [[gnu::always_inline]] Lane get(const Cell* cells, std::size_t k) const {
    const double* const from = reinterpret_cast<const double*>(cells) + num_lanes * k + first;
    return Lanes::put_together([&](std::size_t lane) __attribute__((always_inline)) {
      return from[place[lane] * (sizeof(Cell) / sizeof(double)) + lane];
    });
  }
  template <class Cell>
  [[gnu::always_inline]] void set(Cell* cells, std::size_t k, const Lane& value) const {
    double* const to = reinterpret_cast<double*>(cells) + num_lanes * k + first;
    for (std::size_t lane = 0; lane < Lanes::width; ++lane)
      to[place[lane] * (sizeof(Cell) / sizeof(double)) + lane] = value[lane];
  }
};
template <class Place>
[[gnu::always_inline]] inline Pack3<Place::width> get(const Place& place, const Pack3<>* points) {
  return {place.get(points, 0), place.get(points, 1), place.get(points, 2)};
}
template <class Place>
[[gnu::always_inline]] inline void set(const Place& place, Pack3<>* points, const Pack3<Place::width>& value) {
  place.set(points, 0, value.x);
  place.set(points, 1, value.y);
  place.set(points, 2, value.z);
}

/// The ends of rods; u points from the first to the second. Those of equal islands are the same in all lanes:
struct EqualEnds {
  static constexpr Program program = Program::Islands;
  const std::array<int, 2>* ends;
  template <class Lanes>
  [[gnu::always_inline]] auto first(const Lanes& part, std::size_t k) const {
    return SamePlace<Lanes>(part, &ends[k][0]);
  }
  template <class Lanes>
  [[gnu::always_inline]] auto second(const Lanes& part, std::size_t k) const {
    return SamePlace<Lanes>(part, &ends[k][1]);
  }
};
/// The rods of pieces of trees go from child to parent. Parents are the same in all lanes, or each lane has its own:
template <template <class> class Parent>
struct TreeEnds {
  static constexpr Program program = Program::Trees;
  const Index* parents;
  template <class Lanes>
  [[gnu::always_inline]] auto first(const Lanes& part, std::size_t k) const {
    return SamePlace<Lanes>(part, k);
  }
  template <class Lanes>
  [[gnu::always_inline]] auto second(const Lanes& part, std::size_t k) const {
    return Parent<Lanes>(part, parents + num_lanes * k);
  }
};
/// The ends of rods of a path are neighbouring places:
struct PathEnds {
  static constexpr Program program = Program::Paths;
  template <class Lanes>
  [[gnu::always_inline]] auto first(const Lanes& part, std::size_t k) const {
    return SamePlace<Lanes>(part, k);
  }
  template <class Lanes>
  [[gnu::always_inline]] auto second(const Lanes& part, std::size_t k) const {
    return SamePlace<Lanes>(part, k + 1);
  }
};
/// Returns the numbers at the second end less those at the first one.
template <class Lanes, class Ends>
[[gnu::always_inline]] inline auto difference(const Lanes& part, const Ends& ends, std::size_t k,
                                              const Pack3<>* points) {
  return get(ends.second(part, k), points) - get(ends.first(part, k), points);
}
/// Adds a force to the second end, and takes it from the first one.
template <class Lanes, class Ends, class Vector>
[[gnu::always_inline]] inline void pull(const Lanes& part, const Ends& ends, std::size_t k, const Vector& force,
                                        Pack3<>* F) {
  const auto first = ends.first(part, k);
  set(first, F, get(first, F) - force);
  const auto second = ends.second(part, k);
  set(second, F, get(second, F) + force);
}

/// Calls body(ends) with the kind of ends that the group has.
template <class Body>
[[gnu::always_inline]] inline void with_ends(const Arrays& group, const Body& body) {
  if (group.program == Program::Islands) return body(EqualEnds{group.schedule->topology.rods.data()});
  if (group.program == Program::Paths) return body(PathEnds());
  group.have_same_parents ? body(TreeEnds<SamePlace>{group.parent}) : body(TreeEnds<OwnPlaces>{group.parent});
}

/// Runs body(part, ends, arrays) for the kind of ends that the group has. Each kind has a function of its own for each
/// instruction set, which gcc optimizes better than all in one. Arrays are copied inside, since a body is copied twice.
template <class All, class Body>
void for_group(const All& arrays, const Body& body) {
  with_ends(arrays, [&](auto ends) {
    for_each_part([ body, ends, at = &arrays ](const auto& part) __attribute__((always_inline)) {
      const All own = *at;
      body(part, ends, own);
    });
  });
}

}  // namespace tanor::detail::lanes
