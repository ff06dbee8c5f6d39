#pragma once

namespace tanor::detail {

/// Power that enters a system, W; or work, J.
struct Power {
  double supports = 0.0;    ///< through moving supports and time-dependent constraints
  double forces = 0.0;      ///< through forces without potential
  double potentials = 0.0;  ///< by the explicit dU/dt of energies
  double friction = 0.0;    ///< through friction at contacts
  double impacts = 0.0;     ///< J alone, by impacts of one-sided constraints

  /// Adds weight times `other`.
  void add(double weight, const Power& other) {
    supports += weight * other.supports;
    forces += weight * other.forces;
    potentials += weight * other.potentials;
    friction += weight * other.friction;
    impacts += weight * other.impacts;
  }
};

struct Energy {
  double kinetic = 0.0, potential = 0.0;  ///< J
};

}  // namespace tanor::detail
