#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>

#include <tanor/dynamics.hpp>

#include "base/memory.hpp"
#include "base/parallel.hpp"
#include "dynamics/decisions.hpp"
#include "dynamics/implicit_equations.hpp"
#include "dynamics/instant.hpp"
#include "dynamics/roles.hpp"

namespace tanor::detail {

/// The estimated errors of a step, and its two end points; `size()` numbers each.
struct StepErrors {
  const double *x, *v;
  const double *x_from, *v_from, *x_to, *v_to;
  bool are_of_projections = false;  ///< moves along the constraints' gradients, which count as errors in full
};

/// The largest |error|/(atol + rtol |.|) over the points.
struct ErrorRatios {
  double x, v;  // of positions, of velocities

  /// Returns the larger one, or NaN if one is NaN.
  double largest() const { return larger(x, v); }
};

/// The errors that a step may have at each point if no absolute tolerance is given, m and m/s [num_points].
struct PointTolerances {
  std::span<const double> positions, velocities;
  std::span<const double> accelerations;  ///< m/s^2, no tolerance: the size of those that may act there
};

/// Tells how far a step may have turned constraints: by a small part of a radian, or more.
enum class Turn { Small, Large };

/// A mechanical system as time integration sees it: x'' = a(t, x, v) on a constraint manifold. x and v have `size()`
/// numbers.
///
/// If several processes have parts of the system, each has its own numbers of x and v. An outcome, and a number that
/// decides about a step, is that of all parts together, so that every process makes the same steps. What a role gives
/// is this process's own, and who asks for it agrees on it.
///
/// A configuration is *linearised* when K is evaluated and S is factorized there, by `linearise` or by accelerations
/// that evaluate their gradients. It stays so until the next one.
class Mechanics : public Decisions {
 public:
  virtual std::size_t size() const = 0;
  /// Returns true if x has the same meaning before and after an accepted step.
  virtual bool keeps_variables() const = 0;
  /// Returns true if power is not identically 0.
  virtual bool has_work() const = 0;
  virtual const Parallel& parallel() const = 0;
  virtual PointTolerances point_tolerances() const = 0;

  /// Writes the prescribed motion at t into x and v. Call this before anything else is computed at a new t.
  virtual void prescribe(double t, double* x, double* v) = 0;
  virtual Outcome linearise(double t, const double* x) = 0;
  /// Returns 1/cond(S), or that of H, at the linearised configuration.
  virtual double reciprocal_condition() const = 0;
  /// Returns the rank of K by the last decision.
  virtual std::size_t rank() const = 0;
  virtual Outcome accelerations(const Kinematics& at, const Request& request, const AccelerationOutput& to) = 0;
  /// Does for work() -> Outcome, which finds accelerations, what `together` does. The largest residual and the sum of
  /// powers are written.
  template <class Work>
  Outcome solve_together(const AccelerationOutput& to, const Work& work) {
    return is_alone() ? work() : agree_on_accelerations(to, work);
  }
  /// Returns reactions of the size that accelerations give, all 0.
  virtual Reactions no_reactions() const = 0;

  /// Projects x onto xi(x, t) = 0 by chord iterations along M^-1 K of the linearised configuration. Linearises again
  /// where they stall. After a large turn it linearises at x first if that costs no more than the iterations which it
  /// saves.
  virtual ProjectionReport project_positions(double t, double* x, Turn turn) = 0;
  /// Projects v onto K'v + xi_t = 0 in the M-norm, with the linearisation at (t, x).
  virtual ProjectionReport project_velocities(double t, const double* x, double* v) = 0;

  /// Does for work() -> ProjectionReport what `together` does.
  template <class Work>
  ProjectionReport project_together(const Work& work) {
    return is_alone() ? work() : agree_on_projection(work);
  }

  /// Returns the errors over their tolerances, at the time t where the step begins. The linearised configuration tells
  /// which part of the errors constraints leave, and how coordinates move the points. `atol` = 0 stands for 1e-10 of
  /// the length and of the speed of each point's neighbourhood, see Scales.
  virtual ErrorRatios error_ratios(double t, const StepErrors& errors, double atol, double rtol) = 0;

  /// Exchanges everything beside the state and the discrete state on which later answers depend, to the last bit:
  /// initial guesses of iterative solves, charts, the last multipliers.
  virtual void exchange_memory(Memory& memory) = 0;

  /// The roles stay the same during a motion.
  virtual Roles roles() = 0;
  /// Returns the motion as a power series, which the first call prepares. Returns null if there is none, and writes the
  /// reason to `why_not` unless that is null. All processes must call this.
  virtual SeriesExpansion* series(std::string* why_not) = 0;

  // Each role by its name.
  StepProjector* step_projector() { return roles().step_projector; }
  InexactSolves* inexact_solves() { return roles().inexact_solves; }
  RankMonitor* rank_monitor() { return roles().rank_monitor; }
  RoundingGroups* rounding_groups() { return roles().rounding_groups; }
  UnseenForces* unseen_forces() { return roles().unseen_forces; }
  DriveMonitor* drives() { return roles().drives; }
  EventFunctions* events() { return roles().events; }
  ImplicitFormulation* implicit_formulation() { return roles().implicit_formulation; }
  CornerFunctions* corners() { return roles().corners; }

 private:
  Outcome agree_on_accelerations(const AccelerationOutput& to, const std::function<Outcome()>& work);
  ProjectionReport agree_on_projection(const std::function<ProjectionReport()>& work);
};

}  // namespace tanor::detail
