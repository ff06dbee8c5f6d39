#pragma once

#include <tanor/kinds.hpp>

namespace tanor {

/// The magnitude that the law's own file says, N; 0 of laws that say a force. T: double, or Forward for the derivative
/// in |N|.
template <class Law, class T>
T magnitude_of(const Law& law, double speed, const T& normal) {
  if constexpr (HasForceOfFriction<Law>)
    return 0.0;
  else if constexpr (ReadsNormalForce<Law>)
    return KindOf<Law>::magnitude(law, speed, normal);
  else
    return KindOf<Law>::magnitude(law, speed);
}

}  // namespace tanor
