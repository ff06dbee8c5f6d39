#pragma once

namespace tanor {

/// Power that enters a system, W; or work, J.
struct Power {
  double supports = 0.0;  ///< through moving supports and time-dependent constraints
  double forces = 0.0;    ///< through forces without potential
  double friction = 0.0;  ///< through friction at contacts
};

struct Energy {
  double kinetic = 0.0, potential = 0.0;  ///< J
};

}  // namespace tanor
