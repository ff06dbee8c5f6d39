#include <algorithm>
#include <cmath>
#include <limits>

#include "motion/scheme.hpp"

namespace tanor {

namespace {

/// Returns how far the projection moved the velocity, over the tolerance. Positions are projected to 1e-13 of a length.
/// Divided by the smallest singular value sigma of K that is a distance, divided by sigma^2 an angle of the tangents.
/// Such an angle moves the velocity of any point by that part of the fastest one, which counts as no error.
double measure_moved_velocity(Mechanics& mechanics, const IntegrationOptions& options, const State& state,
                              const std::vector<double>& moved) {
  constexpr double put_to = 1e-13;
  const double rounding = put_to / mechanics.reciprocal_condition();
  double fastest = 0.0;
  for (const double each : state.v) fastest = std::max(fastest, std::abs(each));
  fastest = mechanics.largest(fastest);
  const double *const x = state.x.data(), *const v = state.v.data();
  const StepErrors errors{moved.data(), moved.data(), x, v, x, v, true};
  double atol = options.atol;
  if (!(atol > 0.0)) {
    const auto own = mechanics.point_tolerances().velocities;
    constexpr double none = std::numeric_limits<double>::max();
    const double least = own.empty() ? none : *std::min_element(own.begin(), own.end());
    if (const double of_all = -mechanics.largest(-least); of_all < none) atol = of_all;
  }
  return mechanics.error_ratios(state.t, errors, atol + rounding * fastest, options.rtol).v;
}

}  // namespace

StepResult stabilize(Mechanics& mechanics, const IntegrationOptions& options, State* state,
                     MovedVelocity moved_velocity, Turn turn) {
  StepResult result;
  const double t = state->t;
  double* const x = state->x.data();
  double* const v = state->v.data();
  mechanics.prescribe(t, x, v);
  if (options.stabilisation == Stabilisation::Projection) {
    const ProjectionReport positions = mechanics.project_positions(t, x, turn);
    result.position_violation = positions.violation;
    if (result.outcome = positions.outcome; !result.outcome.ok()) return result;
  }
  if (result.outcome = mechanics.linearise(t, x); !result.outcome.ok()) return result;
  if (options.stabilisation == Stabilisation::Projection) {
    const bool measures = moved_velocity == MovedVelocity::IsError && mechanics.rank_monitor() != nullptr;
    std::vector<double>& moved = state->a;  // used until the acceleration is known
    if (measures) moved = state->v;
    const ProjectionReport velocities = mechanics.project_velocities(t, x, v);
    result.velocity_violation = velocities.violation;
    if (result.outcome = velocities.outcome; !result.outcome.ok()) return result;
    if (measures) {
      for (std::size_t i = 0; i < moved.size(); ++i) moved[i] -= v[i];
      result.error = measure_moved_velocity(mechanics, options, *state, moved);
    }
  }
  result.outcome = mechanics.accelerations({t, x, v}, options.request(Gradients::Keep), state->output());
  return result;
}

}  // namespace tanor
