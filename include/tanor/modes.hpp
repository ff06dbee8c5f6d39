#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <tanor/equilibrium.hpp>

namespace tanor {

struct ModesOptions {
  static constexpr std::size_t all = static_cast<std::size_t>(-1);

  std::size_t count = 10;  ///< number of modes, the lowest omega^2 first; `all` is allowed up to 300 degrees of freedom
  double time = 0.0;       ///< s; the time of what depends on time
  /// [equations] lambda of the equilibrium. Where it is empty or NaN, the minimum-norm solution of f + K lambda = 0 is
  /// used.
  std::vector<double> multipliers{};
  /// Tensions of rods for dependent rows whose tensions the forces do not determine, if `multipliers` are not given.
  std::vector<Prestress> prestress{};
  /// Largest |f + K lambda| that counts as an equilibrium, relative to the largest force.
  double force_tolerance = 1e-6;
  double tolerance = 1e-10;  ///< for Lanczos' method: residual of a mode over 1/(omega^2 + s)
  /// True to include forces that depend on velocities, and equilibria of forces without a potential. More than 300
  /// degrees of freedom are then an InputError.
  bool damped = false;
  bool ignore_friction = false;  ///< if false, Coulomb friction is an InputError, since it allows many equilibria
  bool freeze_time = false;      ///< as in EquilibriumOptions
  SolverOptions solver{};
};

/// Positions that are no equilibrium.
class TANOR_API NotAtRest : public InputError {
 public:
  using InputError::InputError;
};

/// Small vibrations about an equilibrium: x(t) = r + Re(q e^(i omega t)) with
///
/// Z'WZ q = omega^2 Z'MZ q,   K'Z = 0,   W = -df/dr - sum over rows of lambda Hess xi
///
/// without damping (Gould 1985 for the inertia; docs/statics.md). With damping, x(t) = r + Re(q e^(lambda t)) with
///
/// (lambda^2 M + lambda D + W) q + K mu = 0,   K'q = 0,   D = -df/dv,   lambda = -decay + i omega
///
/// where W and D need not be symmetric. decay < 0 is an oscillation that grows (flutter), or divergence if omega = 0.
/// If the points rest in a frame that turns (EquilibriumOptions::freeze_time), and Coriolis forces couple their
/// motions, the modes are of this second kind in any case, with D = 2 m Omega x.
struct [[nodiscard]] Modes {
  /// Not ok if some modes were not found, if forces have no potential (undamped), or if self-stress makes W ambiguous.
  /// The other members are then empty.
  Outcome outcome;
  /// rad/s, the lowest omega^2 first; a negative omega is a shape that grows as e^(-omega t). With damping, the
  /// imaginary part of lambda, not negative, the smallest |lambda| first; each pair of conjugate lambda appears once.
  std::vector<double> omega;
  std::vector<double> decay;             ///< 1/s, minus the real part of lambda; empty without damping
  std::vector<double> shapes;            ///< [modes x 3n], m, in the user's order, supports 0; q'Mq = 1
  std::vector<double> shapes_imaginary;  ///< the same for complex shapes, q^H M q = 1; empty without damping
  /// Largest |M^-1/2 (W q + K mu - omega^2 M q)| over the largest |omega^2| of these modes. With damping, that of
  /// lambda^2 M + lambda D + W over the largest |lambda|^2 of all.
  double residual_max = 0.0;
  std::size_t degrees_of_freedom = 0;  ///< 3(n - supports) - rank K
  /// Modes that grow, also those not asked for; only those asked for with damping and many freedoms.
  std::size_t unstable_directions = 0;
  std::size_t zero_modes = 0;         ///< modes asked for with omega = 0 to rounding; their omega is set to 0
  std::size_t rigid_zero_modes = 0;   ///< zero modes that are motions of bodies that nothing holds
  std::vector<double> multipliers;    ///< [equations] lambda at the equilibrium
  /// 3n, N: K lambda there, and the load that each support carries; NaN as in EquilibriumResult.
  std::vector<double> reactions, support_forces;
  std::vector<std::string> left_out;  ///< what has no part in vibrations: friction, drag, velocities

  std::size_t count() const { return omega.size(); }
  std::span<const double> shape(std::size_t mode) const {
    const std::size_t size = shapes.size() / omega.size();
    return std::span(shapes).subspan(mode * size, size);
  }
};

/// Finds the lowest modes about `positions` [3n], m. Throws NotAtRest if these are no equilibrium, naming the point
/// with the largest unbalanced force.
TANOR_API Modes modes(const System& system, std::span<const double> positions, const ModesOptions& options = {});

struct BucklingOptions {
  /// Names of the forces that the load factor multiplies: gravity and constant ones.
  std::vector<std::string> loads;
  double time = 0.0;              ///< s
  double force_tolerance = 1e-6;  ///< as in ModesOptions
  bool ignore_friction = false;
  bool freeze_time = false;  ///< as in EquilibriumOptions
  SolverOptions solver{};
};

/// Buckling of an equilibrium. Under p times the loads the points stay where they are, with multipliers lambda_0 + p
/// lambda_1; the equilibrium buckles at the smallest p > 0 at which Z'W(p)Z is singular.
struct [[nodiscard]] Buckling {
  Outcome outcome;            ///< not ok if the shape moves under the load, or is unstable without it
  double load_factor = 0.0;   ///< infinite if no load in this direction causes buckling
  std::vector<double> shape;  ///< [3n] buckling shape, q'Mq = 1; empty if there is none
};

TANOR_API Buckling find_buckling(const System& system, std::span<const double> positions,
                                 const BucklingOptions& options);

}  // namespace tanor
