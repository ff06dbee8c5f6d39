#pragma once

#include <cstddef>
#include <span>

namespace tanor::detail {

/// An answer at one instant as observables read it, in the user's order. Arrays that none of them reads may be empty.
struct ObservedInstant {
  double time = 0.0;                                             ///< s
  std::span<const double> positions, velocities, accelerations;  ///< 3n
  std::span<const double> multipliers;                           ///< [equations]
  std::span<const double> reactions, support_forces;             ///< 3n, N
  std::span<const double> friction;                              ///< 3n, N; empty without friction
  double kinetic = 0.0, potential = 0.0;                         ///< J
  std::size_t degrees_of_freedom = 0;
  std::span<const double> self_stress{};  ///< as in Solution
  bool has_prestress = false;             ///< multipliers that are NaN are left to a prestress
};

/// Tells which parts of it some observables read.
struct Needs {
  bool places = false;       ///< positions and velocities
  bool multipliers = false;  ///< alone
  bool forces = false;       ///< multipliers, reactions, loads of supports, accelerations, and places
  bool friction = false;
  bool energy = false;
  bool freedoms = false;

  /// Returns true if they read what only a solve tells.
  bool solves() const { return multipliers || forces || friction; }

  Needs& operator|=(const Needs& other) {
    places |= other.places;
    multipliers |= other.multipliers;
    forces |= other.forces;
    friction |= other.friction;
    energy |= other.energy;
    freedoms |= other.freedoms;
    return *this;
  }
};

}  // namespace tanor::detail
