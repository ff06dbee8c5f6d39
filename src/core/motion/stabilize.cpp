#include <algorithm>
#include <cmath>
#include <limits>

#include "base/numbers.hpp"
#include "motion/scheme.hpp"

namespace tanor::detail {

namespace {

/// Returns the tolerance of one number by itself; where points have their own, the least of these.
double least_atol(Mechanics& mechanics, const IntegrationOptions& options, std::span<const double> own) {
  if (options.atol > 0.0) return options.atol;
  constexpr double none = std::numeric_limits<double>::max();
  const double least = own.empty() ? none : *std::min_element(own.begin(), own.end());
  const double of_all = mechanics.smallest(least);
  return of_all < none ? of_all : options.atol;
}

/// Returns how far the projection moved the positions, over more than a step that follows the motion leaves for it: the
/// nearest place on the constraints may lie on another branch, as beyond a corner, where all the rest fits.
double measure_moved_position(Mechanics& mechanics, const IntegrationOptions& options, const State& state,
                              const std::vector<double>& moved) {
  constexpr double many = 1e3, put_to = 1e-13;  // tolerances; of a length
  double farthest = 0.0;
  for (const double each : state.x) farthest = std::max(farthest, std::abs(each));
  farthest = mechanics.largest(farthest);
  const double *const x = state.x.data(), *const v = state.v.data();
  const StepErrors errors{moved.data(), moved.data(), x, v, x, v, true};
  const double atol = least_atol(mechanics, options, mechanics.point_tolerances().positions);
  const double rounding = put_to / mechanics.reciprocal_condition() * farthest;
  return mechanics.error_ratios(state.t, errors, atol + rounding, options.rtol).x / many;
}

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
  const double atol = least_atol(mechanics, options, mechanics.point_tolerances().velocities);
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
  const bool measures = options.stabilisation == Stabilisation::Projection &&
                        moved_velocity == MovedVelocity::IsError && mechanics.rank_monitor() != nullptr;
  std::vector<double>& moved = state->a;  // used until the acceleration is known
  const auto measure = [&](const std::vector<double>& now) {
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i] -= now[i];
  };
  if (measures) moved = state->x;
  if (options.stabilisation == Stabilisation::Projection) {
    const ProjectionReport positions = mechanics.project_positions(t, x, turn);
    result.position_violation = positions.violation;
    if (result.outcome = positions.outcome; !result.outcome.ok()) return result;
  }
  if (result.outcome = mechanics.linearise(t, x); !result.outcome.ok()) return result;
  if (options.stabilisation == Stabilisation::Projection) {
    if (measures) {
      measure(state->x);
      result.error = measure_moved_position(mechanics, options, *state, moved);
      moved = state->v;
    }
    const ProjectionReport velocities = mechanics.project_velocities(t, x, v);
    result.velocity_violation = velocities.violation;
    if (result.outcome = velocities.outcome; !result.outcome.ok()) return result;
    if (measures) {
      measure(state->v);
      result.error = larger(result.error, measure_moved_velocity(mechanics, options, *state, moved));
    }
  }
  result.outcome = mechanics.accelerations({t, x, v}, options.request(Gradients::Keep), state->output());
  return result;
}

}  // namespace tanor::detail
