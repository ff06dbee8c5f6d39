#pragma once

/// \file Hand-written built-in constraints at one instant. A kernel returns for a member k:
///   xi    the constraint itself
///   rate  d xi/dt = K'v + xi_t
///   phi   d2 xi/dt2 along r + e v, t + e: v' Hess(xi) v + 2 v' grad(xi_t) + xi_tt (docs/theory.md)
///   gradient blocks, 3 numbers each: one for each point of the member and row; a rod has a single one, its unit
///   vector.
/// Kernels are pure: numbers in, numbers out. They are inlined into every loop, where the compiler removes what is not
/// used.
///
/// A kernel has `Group`, the kind that it serves; add(group), which keeps what all members of a group share; and own(),
/// the table of the members' numbers. Tests compare kernels with the kind's definition.

#include "base/vec3.hpp"

namespace tanor::detail {

template <int Rows, int Blocks>
struct Local {
  double xi[Rows], rate[Rows], phi[Rows];
  Vec3 gradient[Blocks];
  double gradient_norm[Rows]{};  ///< largest over the blocks of a row; unset where unit_gradient
};

/// rho = |a| and its derivatives along a straight line with velocity b: u = a/rho,
/// rho' = u.b, rho'' = (b.b - rho'^2)/rho.
struct Distance {
  Vec3 unit;
  double value, first, second;

  [[gnu::always_inline]] Distance(Vec3 a, Vec3 b) {
    value = norm(a);
    unit = (1.0 / value) * a;
    first = dot(unit, b);
    // The division rounds once less than second_derivative_of_distance: long motions keep half a digit more.
    second = (dot(b, b) - first * first) / value;
  }
};

}  // namespace tanor::detail
