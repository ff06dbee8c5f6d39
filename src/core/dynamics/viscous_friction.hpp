#pragma once

#include <span>
#include <vector>

#include "base/block3.hpp"
#include "evaluate/tangents.hpp"

namespace tanor::detail {

/// True if all friction that acts is viscous, a force of the velocity like others, or if none acts.
bool is_friction_viscous(const System& system);

/// Viscous friction as a force of positions and velocities, for equations that know no other friction:
///
///   tau = -c T T'(v - u)
///
/// It stands at the configuration where T was written last.
class ViscousFriction {
 public:
  /// `tangents` outlives this object. All friction of the system is viscous.
  ViscousFriction(const System& system, const Tangents& tangents);

  /// Adds M^-1 tau to w [3n].
  void add_accelerations(const double* v, std::span<const double> inverse_mass, double* w) const;
  /// Adds -c T T' to the derivatives of forces in the velocity of their own point [moving point].
  void add_derivatives(std::span<Block3> derivatives) const;
  double power(const double* v) const;  ///< W

 private:
  Vec3 force(std::size_t contact, const double* v) const {
    return -coefficients_[contact] * tangents_.sliding_velocity(contact, v);
  }

  const Tangents& tangents_;
  std::vector<double> coefficients_;  // [contact] c, N s/m
};

}  // namespace tanor::detail
