#pragma once

#include <span>

#include "base/parallel.hpp"
#include "base/vec3.hpp"

namespace tanor::detail {

/// A rod that is eliminated after the pieces of its path: the last one of a piece. The separators of a path are a path
/// themselves.
///
/// A piece is eliminated as if its first rod had the product 1 with the separator before it, so that it needs to know
/// nothing of that one. The true product is `coupling`.
struct Separator {
  Vec3 first, u;                       ///< directions of the first rod of the piece, and of this one
  double inverse_mass_before = 0.0;    ///< of the point between the separator before and that first rod
  double inverse_mass_behind = 0.0;    ///< of the point behind this one
  double diagonal = 0.0, pivot = 0.0;  ///< S_aa, and what the piece leaves of it
  double spread = 1.0;                 ///< what the elimination of the piece makes of the product 1
  double taken = 0.0, taken_y = 0.0;   ///< what the piece takes from the separator before, for that product
  double coupling = 0.0;

  double l = 0.0, inverse_pivot = 0.0;  ///< of the separators' factor L D L'
  double spike = 0.0;                   ///< product with the last one
  double b = 0.0, y = 0.0;              ///< of a right side: its own, and what the piece leaves of it
  double x = 0.0;                       ///< the solution
  struct {
    Vec3 first, last;
  } dw;  ///< of the first and the last point of the piece
  struct {
    Vec3 first;           ///< r of the first point
    Vec3 before, behind;  ///< what the piece adds to r of the points before and behind it
  } r;
  double b_of_first = 0.0;  ///< what the piece before adds to the right side of the first rod

  Vec3 force() const { return x * u; }
};

/// Factorizes S of the separators of one path, after its pieces. The last one is eliminated after all others, since
/// that of a ring closes it and is coupled with the first one; the coupling is 0 in an open path. Returns the largest
/// S_aa/pivot, infinite if a pivot is not positive.
double factorize_separators(std::span<Separator> separators, bool is_ring);
/// Lets each piece know r of the points between pieces, to which the pieces on both sides add.
void join_points(std::span<Separator> separators, bool is_ring);
/// Computes x from y, for S x = -b.
void solve_separators(std::span<Separator> separators);
/// Returns the largest |K'dw + b|.
double residual_of_separators(std::span<const Separator> separators, bool is_ring);

}  // namespace tanor::detail
