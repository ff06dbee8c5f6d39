#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <tanor/dynamics.hpp>

/// \file
/// Where a system rests, and whether it stays there.
namespace tanor {

enum class EquilibriumMethod {
  Auto,    ///< Newton's method, damped from far; leaves unstable equilibria where a stable one is wanted
  Newton,  ///< the same without leaving what it finds
  Descent  ///< down the slope of the energy along the constraints, then Newton's method
};

/// What a small push does to an equilibrium.
enum class Stability {
  None,            ///< no equilibrium was found
  Stable,          ///< Z'WZ is positive definite: a strict minimum of the energy, but for motions of the whole
  Marginal,        ///< some move costs no energy to second order, and none gains some
  Unstable,        ///< some move gains energy
  NotConservative  ///< some force has no potential: energy decides nothing
};

/// Which equilibria are an answer.
enum class AcceptedEquilibria { Stable, Marginal, Any };

/// Tensions that rods have where the load alone does not say them (self-stress).
struct Prestress {
  std::string rods;              ///< name of a group of rods
  std::vector<double> tensions;  ///< N, one a rod or one for all
};

/// To which side constraints of one equation a member may give way: xi >= 0, such as points on a floor that does not
/// hold them down, or xi <= 0, such as ropes that may be slack.
enum class OneSide { AtLeast, AtMost };

/// A group of constraints that act to one side: where xi is not 0 they carry nothing.
struct OneSided {
  std::string constraint;  ///< name of a group whose members have one equation each
  OneSide side = OneSide::AtLeast;
};

struct EquilibriumOptions {
  EquilibriumMethod method = EquilibriumMethod::Auto;
  double force_tolerance = 1e-10;  ///< of the largest force, > 0
  int max_iterations = 500;        ///< > 0, of one search; Auto may search several times
  AcceptedEquilibria accept = AcceptedEquilibria::Stable;
  double at = 0.0;     ///< s: the time of all that depends on time
  int load_steps = 1;  ///< > 0: gravity and constant forces grow in so many equal steps
  std::vector<Prestress> prestress{};
  std::vector<OneSided> one_sided{};
  bool ignore_friction = false;  ///< else Coulomb friction is an InputError: it rests in many places
  SolverOptions solver{};        ///< ordering and threads
};

/// What a small push does where a system rests, by the moves Z that the constraints leave free.
struct StabilityReport {
  Stability status = Stability::None;
  std::size_t unstable_directions = 0, zero_modes = 0, rigid_zero_modes = 0;  ///< rigid ones are among zero modes
  /// Lowest omega^2 of Z'WZ q = omega^2 Z'MZ q that is no zero mode, 1/s^2, and its shape, 3n, q'Mq = 1; NaN and empty
  /// where nothing can move or energy decides nothing.
  double lowest_omega2 = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> lowest_shape;
};

/// How an equilibrium was searched.
struct EquilibriumSearch {
  EquilibriumMethod method_used = EquilibriumMethod::Newton;
  int iterations = 0, factorizations = 0;  ///< of all searches
  std::vector<double> residuals;           ///< N, of each iteration
};

/// An equilibrium f + K lambda = 0, xi = 0 at rest. Arrays are in the user's order.
struct [[nodiscard]] EquilibriumResult {
  Outcome outcome;  ///< ok: found and accepted
  StabilityReport stability;
  EquilibriumSearch search;
  std::vector<double> positions;  ///< 3n, m; the best that was found where outcome is not ok
  /// [equations] lambda; where they are not unique the smallest, or such that the place is stable with them where the
  /// smallest are none; NaN where they join supports alone, or points that prestress holds rigid.
  std::vector<double> multipliers;
  /// 3n, N: K lambda; the load that each support carries; NaN where a multiplier that is NaN takes part.
  std::vector<double> reactions, support_forces;
  std::vector<bool> multipliers_unique;  ///< [equations]
  std::size_t self_stress_states = 0;    ///< ways in which rods can pull against each other without a load
  std::vector<std::string> dependences;  ///< "rods[17] depends on rods[3], rods[9]"
  double residual_force = 0.0,
         largest_force = 0.0;  ///< N: the largest |f + K lambda| of a point; what it is small beside
  double violation = 0.0;      ///< largest |xi|/|gradient|/length
  double energy = 0.0;         ///< J, of all forces that have a potential
  double buckling_load_factor = std::numeric_limits<double>::quiet_NaN();  ///< NaN: nobody asked
  /// [equations] one-sided ones that do not touch: they carry nothing; empty: there are no one-sided ones.
  std::vector<bool> open;
  std::vector<std::string> left_out;  ///< what took no part, by name; what was found on the way
};

/// Finds an equilibrium from the system's positions, which need not satisfy the constraints; velocities are not read.
///
/// Newton's method on the equations of equilibrium with the stiffness of all forces and constraints, damped from far so
/// that it descends. One-sided constraints are closed and released until each either touches and presses or keeps its
/// distance and carries nothing; stability counts those that touch, as held both ways. Throws InputError as `validate`
/// does, and for options out of their range, Coulomb friction, coordinates, a prestress of what is no group of rods,
/// and one-sided ones with more than one equation a member.
TANOR_API EquilibriumResult find_equilibrium(const System& system, const EquilibriumOptions& options = {});

/// The system without the members that are `open`: what holds it at rest, for `modes` and for motions.
TANOR_API System without_open_constraints(const System& system, const std::vector<bool>& open);

}  // namespace tanor
