#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <tanor/equilibrium.hpp>

namespace tanor {

struct ModesOptions {
  static constexpr std::size_t all = static_cast<std::size_t>(-1);

  std::size_t count = 10;  ///< modes, the lowest omega^2 first; `all`: where at most 300 freedoms are
  double time = 0.0;       ///< s, at which what depends on time stands still
  /// [equations] lambda of the equilibrium; empty, or NaN of some: the smallest one of f + K lambda = 0.
  std::vector<double> multipliers{};
  /// Where rows depend on each other and forces do not determine the tensions, and `multipliers` are not given.
  std::vector<Prestress> prestress{};
  double force_tolerance = 1e-6;  ///< largest |f + K lambda| that passes for an equilibrium, of the largest force
  double tolerance = 1e-10;       ///< of Lanczos' method: residual of a mode over 1/(omega^2 + s)
  /// Small motions with what acts on velocities, and about equilibria of forces without a potential; up to 300 degrees
  /// of freedom, beyond them an InputError that says so.
  bool damped = false;
  bool ignore_friction = false;  ///< else Coulomb friction is an InputError: it rests in many places
  SolverOptions solver{};
};

/// Small vibrations about an equilibrium: x(t) = r + Re(q e^(i omega t)) with
///
///   Z'WZ q = omega^2 Z'MZ q,   K'Z = 0,   W = -df/dr - sum over rows of lambda Hess xi
///
/// without damping (Gould 1985 for the inertia; docs/statics.md). Damped: x(t) = r + Re(q e^(lambda t)) with
///
///   (lambda^2 M + lambda D + W) q + K mu = 0,   K'q = 0,   D = -df/dv,   lambda = -decay + i omega
///
/// where W and D need not be symmetric: decay < 0 is an oscillation that grows (flutter), or with omega = 0 divergence.
struct [[nodiscard]] Modes {
  /// Not ok: some modes were not found, forces have no potential (undamped), or self-stress makes W ambiguous; what is
  /// below is then empty.
  Outcome outcome;
  /// rad/s, the lowest omega^2 first; negative: a shape that grows as e^(-omega t). Damped: the imaginary part of
  /// lambda, not negative, the smallest |lambda| first; each pair of conjugate lambda once.
  std::vector<double> omega;
  std::vector<double> decay;             ///< 1/s, minus the real part of lambda; empty: without damping
  std::vector<double> shapes;            ///< [modes x 3n], m, in the user's order, supports 0; q'Mq = 1
  std::vector<double> shapes_imaginary;  ///< the same of complex shapes, q^H M q = 1; empty: without damping
  /// Largest |M^-1/2 (W q + K mu - omega^2 M q)| over the largest |omega^2| of these modes; damped: of lambda^2 M +
  /// lambda D + W over the largest |lambda|^2 of all.
  double residual_max = 0.0;
  std::size_t degrees_of_freedom = 0;   ///< 3(n - supports) - rank K
  std::size_t unstable_directions = 0;  ///< modes that grow, asked for or not; damped, of many freedoms: asked for
  std::size_t zero_modes = 0;           ///< modes with omega = 0 to rounding, of those asked for; their omega is 0
  std::size_t rigid_zero_modes = 0;     ///< of these, motions of bodies that nothing holds
  std::vector<double> multipliers;      ///< [equations] lambda at the equilibrium
  std::vector<std::string> left_out;    ///< what has no part in vibrations: friction, drag, velocities

  std::size_t count() const { return omega.size(); }
  std::span<const double> shape(std::size_t mode) const {
    const std::size_t size = shapes.size() / omega.size();
    return std::span(shapes).subspan(mode * size, size);
  }
};

/// The lowest modes about `positions` [3n], m. Throws InputError where these are no equilibrium, naming the point with
/// the largest force that nothing balances.
TANOR_API Modes modes(const System& system, std::span<const double> positions, const ModesOptions& options = {});

struct BucklingOptions {
  /// Names of the forces that are multiplied by the load factor: gravity and constant ones.
  std::vector<std::string> loads;
  double time = 0.0;              ///< s
  double force_tolerance = 1e-6;  ///< as in ModesOptions
  bool ignore_friction = false;
  SolverOptions solver{};
};

/// Under p times the loads the points stay where they are, with multipliers lambda_0 + p lambda_1; the equilibrium
/// buckles at the smallest p > 0 at which Z'W(p)Z is singular.
struct [[nodiscard]] Buckling {
  Outcome outcome;            ///< not ok: the shape moves under the load, or is unstable without it
  double load_factor = 0.0;   ///< infinite where no load in this direction buckles it
  std::vector<double> shape;  ///< [3n] in which it buckles; q'Mq = 1; empty where it never does
};

TANOR_API Buckling find_buckling(const System& system, std::span<const double> positions,
                                 const BucklingOptions& options);

}  // namespace tanor
