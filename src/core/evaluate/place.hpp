#pragma once

#include "base/vec3.hpp"

namespace tanor::detail {

/// The position of one point, r = r(q, t) with S coordinates, and its derivatives.
template <int S>
struct Place {
  Vec3 r, v, psi;
  Vec3 tangent[S];
};

}  // namespace tanor::detail
