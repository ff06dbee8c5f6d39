#pragma once

#include <algorithm>
#include <cmath>

#include "base/block3.hpp"

/// \file The friction cone K_mu = {r : |r_t| <= mu r_n} and its projections. Contacts have their numbers in the order
/// (normal, tangent, tangent), as x, y and z of a Vec3.
namespace tanor::detail {

inline double tangential(Vec3 a) {
  return std::hypot(a.y, a.z);
}

/// Returns u + mu |u_t| n (De Saxce and Feng 1991). Signorini's and Coulomb's laws say that this velocity is in the
/// dual cone, r is in the cone, and the two are orthogonal.
inline Vec3 with_dilatancy(Vec3 u, double mu) {
  return {u.x + mu * tangential(u), u.y, u.z};
}

/// Returns the projection of y onto K_mu.
inline Vec3 project_onto_cone(Vec3 y, double mu) {
  const double t = tangential(y);
  if (t <= mu * y.x) return y;
  if (y.x <= -mu * t) return {};
  const double normal = (y.x + mu * t) / (1.0 + mu * mu), scale = t > 0.0 ? mu * normal / t : 0.0;
  return {normal, scale * y.y, scale * y.z};
}

/// Returns the derivative of the projection, symmetric and between 0 and I:
///
///   gg'/(1 + mu^2) + (mu p_n/|y_t|) diag(0, I - dd'),  g = (1, mu d), d = y_t/|y_t|
inline Block3 derive_projection(Vec3 y, double mu) {
  Block3 result;
  const double t = tangential(y);
  if (y.x <= -mu * t) return result;
  if (t <= mu * y.x) {
    result.add_identity(1.0);
    return result;
  }
  const Vec3 g{1.0, mu * y.y / t, mu * y.z / t}, across{0.0, -y.z / t, y.y / t};
  const double normal = (y.x + mu * t) / (1.0 + mu * mu);
  result.add_product(1.0 / (1.0 + mu * mu), g, g);
  result.add_product(mu * normal / t, across, across);
  return result;
}

}  // namespace tanor::detail
