#pragma once

#include <cstddef>
#include <span>
#include <string>

#include <tanor/dynamics.hpp>

#include "base/memory.hpp"
#include "base/parallel.hpp"
#include "dynamics/implicit_equations.hpp"
#include "dynamics/instant.hpp"
#include "dynamics/roles.hpp"

namespace tanor {

/// Estimated errors of a step, and where it began and ended; `size()` numbers each.
struct StepErrors {
  const double *x, *v;
  const double *x_from, *v_from, *x_to, *v_to;
  bool are_of_projections = false;  ///< moves along the constraints' gradients, which are errors as a whole
};

/// Largest over the points of |error|/(atol + rtol |.|).
struct ErrorRatios {
  double x, v;  // of positions, of velocities

  /// A NaN wins.
  double largest() const { return larger(x, v); }
};

/// What a step may miss at each point where no absolute tolerance is given, m and m/s [num_points].
struct PointTolerances {
  std::span<const double> positions, velocities;
  std::span<const double> accelerations;  ///< m/s^2, no tolerance: as much as may act there
};

/// How far a step may have turned constraints: by a small part of a radian, or more.
enum class Turn { Small, Large };

/// What motion sees of a mechanical system: x'' = a(t, x, v) on a constraint manifold. x and v have `size()` numbers.
///
/// A configuration is *linearised* when K stands at it and S has its factor, by `linearise` or by accelerations that
/// evaluate their gradients. It stays so until the next one.
class Mechanics {
 public:
  virtual ~Mechanics() = default;

  virtual std::size_t size() const = 0;
  /// x means the same before and after a step that was accepted.
  virtual bool keeps_variables() const = 0;
  /// Power is not identically 0.
  virtual bool has_work() const = 0;
  virtual const Parallel& parallel() const = 0;
  virtual PointTolerances point_tolerances() const = 0;

  /// Of a system that several processes have parts of, the largest number of all and their sum: what is found from
  /// arrays of the state here and decides about a step is asked for by these. Each process asks.
  virtual double largest(double own) = 0;
  virtual double sum(double own) = 0;

  /// Writes the prescribed motion at t into x and v; to be called before anything else is computed at a new t.
  virtual void prescribe(double t, double* x, double* v) = 0;
  virtual Outcome linearise(double t, const double* x) = 0;
  /// 1/cond(S), or of H, at the configuration that is linearised.
  virtual double reciprocal_condition() const = 0;
  /// The rank of K, as it was decided last.
  virtual std::size_t rank() const = 0;
  virtual Outcome accelerations(const Kinematics& at, const Request& request, const AccelerationOutput& to) = 0;
  /// As many numbers as accelerations find, all 0.
  virtual Reactions no_reactions() const = 0;

  /// Projects x onto xi(x, t) = 0 along M^-1 K of the configuration that is linearised, by chord iterations. Linearises
  /// anew where they stall; after a large turn also at x first, where that costs no more than the iterations which it
  /// saves.
  virtual ProjectionReport project_positions(double t, double* x, Turn turn) = 0;
  /// Projects v onto K'v + xi_t = 0 in the M-norm, with the linearisation at (t, x).
  virtual ProjectionReport project_velocities(double t, const double* x, double* v) = 0;

  /// t: at the step's beginning. What constraints leave of errors, and what coordinates do at the points, is that of
  /// the configuration that is linearised. `atol` 0: 1e-10 of the length and of the speed of each point's
  /// neighbourhood, see Scales.
  virtual ErrorRatios error_ratios(double t, const StepErrors& errors, double atol, double rtol) = 0;

  /// Everything beside the state and the discrete state on which later answers depend, to the last bit: what iterative
  /// solves start from, charts, the last multipliers.
  virtual void exchange_memory(Memory& memory) = 0;

  /// They stay the same during a motion.
  virtual Roles roles() = 0;
  /// The motion as a power series, which may be prepared by this call; null: see `why_no_series`.
  virtual SeriesExpansion* series() = 0;
  virtual std::string why_no_series() const = 0;  ///< empty where `series` is there

  // Each role by its name.
  StepProjector* step_projector() { return roles().step_projector; }
  InexactSolves* inexact_solves() { return roles().inexact_solves; }
  RankMonitor* rank_monitor() { return roles().rank_monitor; }
  RoundingGroups* rounding_groups() { return roles().rounding_groups; }
  ForcePassages* force_passages() { return roles().force_passages; }
  DriveMonitor* drives() { return roles().drives; }
  EventFunctions* events() { return roles().events; }
  ImplicitFormulation* implicit_formulation() { return roles().implicit_formulation; }
};

}  // namespace tanor
