#pragma once

#include "dynamics/mechanics.hpp"

namespace tanor {

/// The inverse problem in one of its forms, in the inner order of points and rows. A form steps in variables x of its
/// own (positions, or generalized coordinates); r, v, w, eta are always 3n, point by point.
class EquationsOfMotion : public Mechanics {
 public:
  /// Nearest consistent start in the M-norm, into r and v; `StartMode::Check` throws InputError naming the worst place.
  virtual StartReport start(double t, double* r, double* v, StartMode mode) = 0;
  /// Nearest r on the constraints, and nearest v with K'v + xi_t = 0 (K at an admissible r), in the M-norm; [3n].
  virtual ProjectionReport project_point_positions(double t, double* r) = 0;
  virtual ProjectionReport project_point_velocities(double t, const double* r, double* v) = 0;
  /// Its own x and x' of a consistent (r, v), `size()` each.
  virtual Outcome set_state(double t, const double* r, const double* v, double* x, double* x_dot) = 0;
  /// Writes the points of x and x', with x'' and the reactions that were found with it.
  virtual void write_points(const Kinematics& at, const double* x_ddot, const Reactions& found, double* r, double* v,
                            double* w) = 0;
  /// Accelerations where nothing is known of earlier instants: contacts at rest choose whether they stick or slide. May
  /// change x' of those by rounding.
  virtual Outcome begin(double t, const double* x, double* x_dot, const Request& request,
                        const AccelerationOutput& to) = 0;
  /// After a step that was accepted, where its last accelerations were found: variables that serve the neighbourhood of
  /// (x, x') best; x'' goes along, with what was found with it.
  virtual void recentre(double t, double* x, double* x_dot, double* x_ddot, Reactions* found) = 0;
  /// Goes on with a motion from elsewhere: its earlier steps are unknown, the work is counted on.
  virtual void resume(const Counters& counters, const PhaseTimes& times) = 0;

  /// Where other processes have parts of the system: the states of their points that equations here need. A null `v`
  /// is not wanted.
  virtual void fetch_guests(double* r, double* v) = 0;

  virtual Energy energy(double t, const double* x, const double* v) = 0;
  /// Potential energy where all points are at r [3n], J.
  virtual double potential(double t, const double* r) = 0;
  /// eta [3n] of what was found with accelerations at this state, where K stands; of supports: what the constraints do
  /// there.
  virtual void write_reactions(const Kinematics& at, const Reactions& found, double* eta) = 0;
  /// lambda [d] := the multipliers of the same reactions with the least norm, where several serve, at this state.
  virtual void minimize_multipliers(const Kinematics& at, double* lambda) = 0;
  /// Likewise tau [3n], of contacts that slide and of those that stick.
  virtual void write_friction(const Reactions& found, double* tau) const = 0;

  /// Adds what it found out about the system.
  virtual void describe(PlanSummary* plan) const = 0;
};

}  // namespace tanor
