#pragma once

#include <tanor/kinds.hpp>

namespace tanor::detail {

/// Returns the magnitude that the law's own file gives, N, or 0 for a law that gives a force. T is double, or Forward
/// for the derivative in |N|.
template <class Law, class T>
T magnitude_of(const Law& law, double speed, const T& normal) {
  if constexpr (HasForceOfFriction<Law>)
    return 0.0;
  else if constexpr (ReadsNormalForce<Law>)
    return KindOf<Law>::magnitude(law, speed, normal);
  else
    return KindOf<Law>::magnitude(law, speed);
}

}  // namespace tanor::detail
