#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include <tanor/motion.hpp>

#include "dynamics/mechanics.hpp"
#include "motion/integration_options.hpp"

namespace tanor {

/// Where a system is: x and v on the constraints, the acceleration there, and the works done so far. Between steps the
/// mechanics is linearised at (t, x).
struct State {
  double t = 0.0;
  std::vector<double> x, v, a;
  Power power;          ///< W, at this state
  Power work;           ///< J: their time integrals
  SolveReport report;   ///< of the accelerations that were found here last, …
  Reactions reactions;  ///< … and what was found with them

  Kinematics at() const { return {t, x.data(), v.data()}; }
  /// Accelerations are to be written here, with all that belongs to them.
  AccelerationOutput output() { return {a.data(), &power, &report, &reactions}; }
  /// The same where the power is known.
  AccelerationOutput output_without_power() { return {a.data(), nullptr, &report, &reactions}; }
};

/// Instants near t that are no further apart than this are one, in a stretch of length h.
inline double time_resolution(double t, double h) {
  return 16.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(t), h);
}

/// What one attempted step says.
struct StepResult {
  Outcome outcome;
  double error = 0.0;               ///< estimated error over the tolerance (adaptive schemes; accept below 1)
  double position_violation = 0.0;  ///< after the step, relative
  double velocity_violation = 0.0;
  bool is_stabilized = true;    ///< false: K is unreliable at the new configuration, see Extrapolation
  bool is_interpolated = true;  ///< by the scheme; false: it made another step
};

/// One step of a time integration. Keeps its workspaces: nothing is allocated in a step.
class Scheme {
 public:
  virtual ~Scheme() = default;

  /// Order of the error per unit of time.
  virtual int order() const = 0;
  virtual bool is_adaptive() const = 0;
  /// Power of h with which the error estimate falls (adaptive schemes).
  virtual int estimate_order() const { return order(); }
  /// The next step where one of length `last` was accepted and the error estimate allows `wanted`.
  virtual double choose_step(double /*last*/, double wanted) const { return wanted; }
  /// A step leaves State::a at the new state (else it is computed where somebody asks).
  virtual bool knows_acceleration() const = 0;

  /// How rounding of accelerations enters the velocities of an adaptive scheme.
  virtual RoundingGain rounding_gain() const { return {}; }

  /// The step that its own tolerances allow from this state, s; 0: it has no opinion.
  virtual double propose_step(const State& /*from*/) { return 0.0; }

  /// A step from this state looks at nothing inside itself, and so may pass a singular configuration.
  virtual bool sees_through(const State& from) = 0;

  /// Makes a step of length h from `from` to `to` (a different object), whose time is given: from.t + h, rounded as the
  /// caller wants it. On a failed outcome or an error above 1 the rest of `to` is meaningless, and `from` stays good.
  virtual StepResult step(const State& from, double h, State* to) = 0;

  /// Prepares `interpolate` inside the last step that was made, `to` being as it left it. Call it once a step. It may
  /// compute, so that the mechanics is then linearised elsewhere.
  virtual Outcome prepare_inside(const State& /*from*/, const State& /*to*/) { return {}; }
  /// Writes x and v at from.t + fraction h, `size()` numbers each. The default is quintic Hermite interpolation of x
  /// from (x, v, a) at both ends, and its derivative as v, with errors O(h^6) and O(h^5), whatever the scheme was. A
  /// scheme that leaves no a has the cubic, with O(h^4) and O(h^3).
  virtual void interpolate(const Parallel& parallel, const State& from, const State& to, double fraction, double* x,
                           double* v) const;

  /// Fractions of a step at which forces count in it and in the estimate of its error, in rising order, 0 and 1 among
  /// them.
  virtual std::span<const double> looks() const;
  /// `interpolate` needs no `prepare_inside`.
  virtual bool interpolates_at_once() const { return true; }

  /// The equations have changed. Nothing of the last step holds for the next one.
  virtual void forget() = 0;

  /// Everything beside the state on which the next step depends, to the last bit.
  virtual void exchange_memory(Memory& memory) = 0;
};

/// The scheme of a method (not Auto); rtol and atol of `options` enter the error estimate.
std::unique_ptr<Scheme> make_scheme(Method method, const IntegrationOptions& options, Mechanics& mechanics);

/// Whether it is an error of the step that its end is moved onto K'v + xi_t = 0.
enum class MovedVelocity { IsNoError, IsError };

/// Ends any step: puts positions, then velocities onto the constraints, then finds the acceleration at the new state.
/// The factor there serves the velocities, this acceleration and the next step.
///
/// The result's error is how far the projection moves the velocity, over the tolerance of `options`, where that is
/// asked for and K may lose rank. A step that follows the motion comes nearly tangent to the constraints. A step does
/// not that ends on another branch of them, or where K is too near to losing rank to tell the tangents.
StepResult stabilize(Mechanics& mechanics, const IntegrationOptions& options, State* state,
                     MovedVelocity moved_velocity, Turn turn = Turn::Small);

}  // namespace tanor
