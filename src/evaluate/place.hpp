#pragma once

#include "base/vec3.hpp"

namespace tanor {

/// Where one point is: r = r(q, t) with S coordinates.
template <int S>
struct Place {
  Vec3 r, v, psi;
  Vec3 tangent[S];
};

}  // namespace tanor
