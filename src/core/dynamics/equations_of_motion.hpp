#pragma once

#include "dynamics/mechanics.hpp"

namespace tanor::detail {

/// The inverse problem (forward dynamics) in one of its forms, in the inner order of points and rows. A form steps in
/// its own variables x (positions, or generalized coordinates); r, v, w, eta are always 3n, point by point.
class EquationsOfMotion : public Mechanics {
 public:
  /// Moves r and v to the nearest consistent start in the M-norm. `StartMode::Check` throws InputError naming the worst
  /// violation.
  virtual StartReport start(double t, double* r, double* v, StartMode mode) = 0;
  /// Computes the form's own x and x' of a consistent (r, v), `size()` numbers each.
  virtual Outcome set_state(double t, const double* r, const double* v, double* x, double* x_dot) = 0;
  /// Writes r, v and w of all points from x, x' and x'', and from the reactions that were found with x''.
  virtual void write_points(const Kinematics& at, const double* x_ddot, const Reactions& found, double* r, double* v,
                            double* w) = 0;
  /// Computes accelerations where nothing is known of earlier instants, so that contacts at rest choose whether to
  /// stick or to slide. May change x' of those contacts by rounding.
  virtual Outcome begin(double t, const double* x, double* x_dot, const Request& request,
                        const AccelerationOutput& to) = 0;
  /// Fetches the states of points on other processes that equations of this process need. A null `v` is not fetched.
  virtual void fetch_guests(double* r, double* v) = 0;

  virtual Energy energy(double t, const double* x, const double* v) = 0;
  /// Returns the potential energy with all points at r [3n], J.
  virtual double potential(double t, const double* r) = 0;
};

/// The equations of this process: beside what all processes decide together, what each does for itself.
class OwnEquations : public EquationsOfMotion {
 public:
  /// Moves r [3n] to the nearest point on the constraints, and v [3n] to the nearest velocity with K'v + xi_t = 0 (K at
  /// an admissible r), in the M-norm.
  virtual ProjectionReport project_point_positions(double t, double* r) = 0;
  virtual ProjectionReport project_point_velocities(double t, const double* r, double* v) = 0;
  /// Chooses the variables that serve best around (x, x'), after an accepted step, where its last accelerations were
  /// found. Transforms x'' and what was found with it as well.
  virtual void recentre(double t, double* x, double* x_dot, double* x_ddot, Reactions* found) = 0;
  /// Continues a motion from elsewhere. Its earlier steps are unknown, and the work counters go on from those given.
  virtual void resume(const Counters& counters, const PhaseTimes& times) = 0;

  /// True if other processes take part in the calls of this form, and `prescribe` may throw here alone. All of them
  /// must know of it before the next call.
  virtual bool is_prescribed_together() const { return false; }
  /// Writes eta [3n] of the reactions found with accelerations at this state, where K stands. At supports it is the
  /// force of the constraints.
  virtual void write_reactions(const Kinematics& at, const Reactions& found, double* eta) = 0;
  /// Replaces lambda [d] by the multipliers of least norm with the same reactions, where they are not unique at this
  /// state.
  virtual void minimize_multipliers(const Kinematics& at, double* lambda) = 0;
  /// Writes tau [3n] of the contacts that slide and of those that stick.
  virtual void write_friction(const Reactions& found, double* tau) const = 0;

  /// Adds the form's own findings about the system.
  virtual void describe(PlanSummary* plan) const = 0;
};

}  // namespace tanor::detail
