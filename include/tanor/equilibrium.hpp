#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <tanor/dynamics.hpp>

/// \file
/// Equilibria of a system and their stability.
namespace tanor {

enum class EquilibriumMethod {
  Auto,    ///< Newton's method, damped far away; leaves unstable equilibria if a stable one is wanted
  Newton,  ///< the same, but it keeps the equilibrium that it finds
  Descent  ///< descent of the energy along the constraints, then Newton's method
};

/// Effect of a small perturbation on an equilibrium.
enum class Stability {
  None,            ///< no equilibrium was found
  Stable,          ///< Z'WZ is positive definite: a strict minimum of the energy, except for motions of the whole
  Marginal,        ///< some move costs no energy to second order, and none gains energy, or Coriolis forces hold those
  Unstable,        ///< some move gains energy
  NotConservative  ///< some force has no potential, so that energy decides nothing
};

/// Equilibria that are accepted as an answer.
enum class AcceptedEquilibria { Stable, Marginal, Any };

/// Tensions of rods that the load alone does not determine (self-stress).
struct Prestress {
  std::string rods;              ///< name of a group of rods
  std::vector<double> tensions;  ///< N, one for each rod or one for all
};

/// A group of constraints that act to one side. A member whose xi is not 0 carries nothing.
struct OneSided {
  std::string constraint;  ///< name of a group whose members have one equation each
  OneSide side = OneSide::AtLeast;
};

struct EquilibriumOptions {
  EquilibriumMethod method = EquilibriumMethod::Auto;
  double force_tolerance = 1e-10;  ///< relative to the largest force, > 0
  int max_iterations = 500;        ///< for one search, > 0; Auto may search several times
  AcceptedEquilibria accept = AcceptedEquilibria::Stable;
  double at = 0.0;     ///< s; the time of what depends on time
  int load_steps = 1;  ///< > 0; number of equal steps in which gravity and constant forces grow
  std::vector<Prestress> prestress{};
  std::vector<OneSided> one_sided{};
  bool ignore_friction = false;  ///< if false, Coulomb friction is an InputError, since it allows many equilibria
  /// If true, all that depends on time is taken as it is at `at`. If false, rest is that in a frame that turns with a
  /// constant spin or accelerates evenly, and what is not steady in such a frame is an InputError.
  bool freeze_time = false;
  SolverOptions solver{};  ///< ordering and threads
};

/// Effect of a small perturbation on a system at rest, in the moves Z that the constraints leave free.
struct [[nodiscard]] StabilityReport {
  Stability status = Stability::None;
  std::size_t unstable_directions = 0, zero_modes = 0, rigid_zero_modes = 0;  ///< rigid ones are among zero modes
  /// Lowest omega^2 of Z'WZ q = omega^2 Z'MZ q that is no zero mode, 1/s^2, and its shape, 3n, q'Mq = 1. They are NaN
  /// and empty if nothing can move or energy decides nothing.
  double lowest_omega2 = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> lowest_shape;
};

/// Record of the search for an equilibrium.
struct EquilibriumSearch {
  EquilibriumMethod method_used = EquilibriumMethod::Newton;
  int iterations = 0, factorizations = 0;  ///< over all searches
  std::vector<double> residuals;           ///< N, at each iteration
};

/// An equilibrium f + K lambda = 0, xi = 0 at rest. Arrays are in the user's order.
struct [[nodiscard]] EquilibriumResult {
  Outcome outcome;  ///< ok if found and accepted
  StabilityReport stability;
  EquilibriumSearch search;
  std::vector<double> positions;  ///< 3n, m; the best that was found if outcome is not ok
  /// 3n, m/s: those of the frame in which the points rest, which supports and constraints carry along; 0 without one.
  std::vector<double> velocities;
  /// [equations] lambda. If it is not unique, it is the minimum-norm one, or one with which the equilibrium is stable
  /// if it is not so with the former. NaN if none was found, and where prestress holds; 0 for rows between supports.
  std::vector<double> multipliers;
  /// 3n, N: K lambda, and the load that each support carries; NaN where a multiplier that is NaN takes part.
  std::vector<double> reactions, support_forces;
  std::vector<bool> multipliers_unique;  ///< [equations]
  std::vector<double> self_stress;       ///< [equations] as in Solution; empty also where a `prestress` says what holds
  std::size_t self_stress_states = 0;    ///< states in which rods pull against each other without a load
  std::vector<std::string> dependences;  ///< "rods[17] depends on rods[3], rods[9]"
  /// Largest |f + K lambda| of a point, N, and the largest force, N, to which tolerances are relative.
  double residual_force = 0.0, largest_force = 0.0;
  double violation = 0.0;  ///< largest |xi|/|gradient|/length
  double energy = 0.0;     ///< J, sum over all forces that have a potential, and over the inertia of the frame
  double buckling_load_factor = std::numeric_limits<double>::quiet_NaN();  ///< NaN if not wanted
  /// [equations] True for one-sided equations that are open and carry nothing; empty if there are no one-sided ones.
  std::vector<bool> open;
  std::vector<std::string> left_out;  ///< names of what took no part, and findings of the search
};

/// Finds an equilibrium from the system's positions, which need not satisfy the constraints; velocities are not read.
///
/// It applies Newton's method to the equations of equilibrium with the stiffness of all forces and constraints, damped
/// far away so that it descends. One-sided constraints are closed and released until each either touches and presses or
/// keeps its distance and carries nothing; stability counts those that touch as held both ways. Throws InputError as
/// `validate` does, and for options out of range, Coulomb friction, coordinates, a prestress of what is no group of
/// rods, and one-sided constraints with more than one equation per member.
TANOR_API EquilibriumResult find_equilibrium(const System& system, const EquilibriumOptions& options = {});

/// Returns a state of rest for `observe`. Accelerations are NaN where the frame moves in which it rests.
TANOR_API Solution state_at_rest(const EquilibriumResult& found, double time = 0.0);

/// Returns the system without the members that are `open`, for `modes` and for motions. The remaining ones hold it at
/// rest, to both sides.
TANOR_API System without_open_constraints(const System& system, const std::vector<bool>& open);

}  // namespace tanor
