#pragma once

#include <string>
#include <vector>

#include <tanor/system.hpp>

#include "base/vec3.hpp"
#include "statics/exponential_polynomial.hpp"

namespace tanor::detail {

/// A frame that turns with a constant spin and accelerates evenly. At a time tau after the equilibrium its points move
/// by
///
///   u(x) = w + a tau + Omega x (x - c)
///
/// All frames of this kind are steady: a point at rest in one feels forces that do not change there.
struct SteadyFrame {
  Vec3 spin{}, velocity{}, acceleration{};  ///< Omega, rad/s; w, m/s; a, m/s^2
  Vec3 centre{};                            ///< c, m

  bool turns() const { return squared(spin) > 0.0; }
  bool moves() const { return turns() || squared(velocity) > 0.0 || squared(acceleration) > 0.0; }
  Vec3 velocity_at(Vec3 x, double tau = 0.0) const { return velocity + tau * acceleration + cross(spin, x - centre); }
  /// Returns where a point of the frame that is at x when tau = 0 is then.
  Vec3 carry(Vec3 x, double tau) const;
  /// Returns the same at all times, and a vector as it is seen in the frame.
  TripleOf<ExponentialPolynomial> carry(Vec3 x) const;
  TripleOf<ExponentialPolynomial> turn_back(const TripleOf<ExponentialPolynomial>& a) const;
  /// Returns "which turns with [0, 0, 5] rad/s about …".
  std::string describe() const;
};

/// Lists what depends on time, by name and field: "hoop (normal)".
std::vector<std::string> list_what_depends_on_time(const System& system);

/// Finds the frame in which nothing depends on time: the one at rest if there is one, else one that does not turn if
/// there is one. Supports, constraints and forces determine it, at several instants and configurations at once; whether
/// they are steady in it is decided from their expressions (find_unsteady_part). Throws InputError naming what is not,
/// or acts on what moves. The system must have no friction.
SteadyFrame find_steady_frame(const System& system, double t);

/// Adds the energy of the frame's inertia to a system taken at its instant: the force -m (a + Omega x (w + Omega x
/// (r - c))) on each point.
void add_inertia(const SteadyFrame& frame, System* system);

}  // namespace tanor::detail
