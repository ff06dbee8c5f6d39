#include "motion/scheme.hpp"

namespace tanor {

StepResult settle(Mechanics& mechanics, Stabilisation stabilisation, State* state, Turn turn) {
  StepResult result;
  const double t = state->t;
  double* const x = state->x.data();
  double* const v = state->v.data();
  mechanics.prescribe(t, x, v);
  if (stabilisation == Stabilisation::Projection) {
    const ProjectionReport positions =
        turn == Turn::Large ? mechanics.project_far_positions(t, x) : mechanics.project_positions(t, x);
    result.position_violation = positions.violation;
    if (result.outcome = positions.outcome; !result.outcome.ok()) return result;
  }
  if (result.outcome = mechanics.linearise(t, x); !result.outcome.ok()) return result;
  if (stabilisation == Stabilisation::Projection) {
    const ProjectionReport velocities = mechanics.project_velocities(t, x, v);
    result.velocity_violation = velocities.violation;
    if (result.outcome = velocities.outcome; !result.outcome.ok()) return result;
  }
  result.outcome = mechanics.accelerations(t, x, v, Gradients::Keep, state->a.data());
  if (result.outcome.ok() && mechanics.has_work()) state->power = mechanics.power(x, v);
  return result;
}

}  // namespace tanor
