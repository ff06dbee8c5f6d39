#pragma once

#include <cstddef>
#include <functional>

#include <tanor/constrainer.hpp>
#include <tanor/error.hpp>
#include <tanor/export.hpp>

/// \file
/// The time loop for hosts that have none of their own.
namespace tanor {

/// Where a run is after a step.
struct VelocityVerletProgress {
  std::size_t steps;  ///< done so far
  double time;
  const ConstraintReport& positions;   ///< of the step's constrain_positions
  const ConstraintReport& velocities;  ///< of its constrain_velocities
};

/// Steps of velocity Verlet with the constraints of a Constrainer, as its comment writes them down.
struct VelocityVerlet {
  double step = 0.0;  ///< h, not 0; negative: backwards
  std::size_t steps = 0;
  double time = 0.0;  ///< where the run begins
  /// They obey the constraints (project_positions and constrain_velocities see to it), and are those of the run's end.
  /// Supports go on with their velocities.
  PointArray positions{}, velocities{};
  /// At the positions, also where the run begins.
  PointArray forces{};
  /// Writes the forces at the positions as they are now, which are those of that time. Absent: they remain.
  std::function<void(double time)> set_forces{};
  /// Called after every step; false ends the run there. It may edit the constraints, but not the points.
  std::function<bool(const VelocityVerletProgress&)> observe{};
  bool measures = false;   ///< see PositionStep::measures
  double tolerance = 0.0;  ///< see PositionStep::tolerance
};

/// How a run ended.
struct [[nodiscard]] VelocityVerletReport {
  Outcome outcome;  ///< not ok: positions, velocities and forces are those of the last good step
  std::size_t steps = 0;
  double time = 0.0;
};

/// Throws InputError, like the calls of the Constrainer, which belongs to the run until it ends.
TANOR_API VelocityVerletReport run(Constrainer* constrainer, const VelocityVerlet& run);

}  // namespace tanor
