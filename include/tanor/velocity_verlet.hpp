#pragma once

#include <cstddef>
#include <functional>

#include <tanor/constrainer.hpp>
#include <tanor/error.hpp>
#include <tanor/export.hpp>

/// \file
/// The time loop for hosts that have none of their own.
namespace tanor {

/// Progress of a run after a step.
struct VelocityVerletProgress {
  std::size_t steps;  ///< number of steps done so far
  double time;
  const ConstraintReport& positions;   ///< report of the step's constrain_positions
  const ConstraintReport& velocities;  ///< report of the step's constrain_velocities
};

/// A run of velocity Verlet with the constraints of a Constrainer, as its comment describes it.
struct VelocityVerlet {
  double step = 0.0;  ///< h, not 0; a negative step runs backwards
  std::size_t steps = 0;
  double time = 0.0;  ///< start time of the run
  /// Positions and velocities, which satisfy the constraints (project_positions and constrain_velocities make them do
  /// so). They become those at the end of the run. Supports move on with their velocities.
  PointArray positions{}, velocities{};
  /// Forces at the positions, also at the start of the run.
  PointArray forces{};
  /// Writes the forces at the present positions, which belong to that time. If absent, the forces stay as they are.
  std::function<void(double time)> set_forces{};
  /// Called after every step; a return of false ends the run. It may edit the constraints, but not the points.
  std::function<bool(const VelocityVerletProgress&)> observe{};
  bool measures = false;   ///< see PositionStep::measures
  double tolerance = 0.0;  ///< see PositionStep::tolerance
};

/// Result of a run.
struct [[nodiscard]] VelocityVerletReport {
  Outcome outcome;  ///< if not ok, positions, velocities and forces are those of the last good step
  std::size_t steps = 0;
  double time = 0.0;
};

/// Runs the loop. The Constrainer belongs to the run until it ends. Throws InputError, like the calls of the
/// Constrainer.
TANOR_API VelocityVerletReport run(Constrainer* constrainer, const VelocityVerlet& run);

}  // namespace tanor
