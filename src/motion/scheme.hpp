#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <tanor/motion.hpp>

#include "dynamics/mechanics.hpp"
#include "motion/integration_options.hpp"

namespace tanor {

/// Where a system is: x and v on the constraints, the acceleration there, and the works done so far.
/// Between steps the mechanics is linearised at (t, x).
struct State {
  double t = 0.0;
  std::vector<double> x, v, a;
  Power power;  ///< W, where the mechanics has work
  Power work;   ///< J: their time integrals

  Kinematics at() const { return {t, x.data(), v.data()}; }
};

/// What one attempted step says.
struct StepResult {
  Outcome outcome;
  double error = 0.0;               ///< estimated error over the tolerance (adaptive schemes; accept below 1)
  double position_violation = 0.0;  ///< after the step, relative
  double velocity_violation = 0.0;
  bool is_settled = true;       ///< false: K says nothing at the new place, see Coasting
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
  /// A step leaves State::a at the new place (else it is computed where somebody asks).
  virtual bool knows_acceleration() const { return true; }

  /// Of adaptive schemes.
  virtual RoundingGain rounding_gain() const { return {}; }

  /// The step that its own tolerances allow from this state, s; 0: it has no opinion.
  virtual double propose_step(const State& /*from*/) { return 0.0; }

  /// A step from this state looks at no place inside itself: it may pass one where K loses rank.
  virtual bool sees_through(const State& /*from*/) { return false; }

  /// From `from` by h to `to` (a different object), whose time is given: from.t + h, rounded as the caller wants it. On
  /// a failed outcome or an error above 1 the rest of `to` is meaningless, `from` stays good.
  virtual StepResult step(const State& from, double h, State* to) = 0;

  /// Inside the last step that was made, `to` being as it left it. To be called once before `interpolate`; may compute,
  /// so that the mechanics is then linearised elsewhere.
  virtual Outcome prepare_inside(const State& /*from*/, const State& /*to*/) { return {}; }
  /// x and v at from.t + fraction h, `size()` numbers each. By default: quintic Hermite interpolation of x from
  /// (x, v, a) at both ends, and its derivative as v; errors O(h^6) and O(h^5), whatever the scheme was. Where it
  /// leaves no a: cubic, O(h^4) and O(h^3).
  virtual void interpolate(const Parallel& parallel, const State& from, const State& to, double fraction, double* x,
                           double* v) const;

  /// Fractions of a step at which forces count in it and in the estimate of its error, in rising order, 0 and 1 among
  /// them.
  virtual std::span<const double> looks() const;
  /// `interpolate` needs no `prepare_inside`.
  virtual bool interpolates_at_once() const { return true; }

  /// The equations have changed: nothing of the last step holds for the next one.
  virtual void forget() {}

  /// Everything beside the state on which the next step depends, to the last bit.
  virtual void exchange_memory(Memory& /*memory*/) {}
};

/// The scheme of a method (not Auto); rtol and atol of `options` enter the error estimate.
std::unique_ptr<Scheme> make_scheme(Method method, const IntegrationOptions& options, Mechanics& mechanics);

/// Per point and component: atol + rtol |.|.
struct Tolerance {
  double atol, rtol;
};

/// After any step: positions, then velocities onto the constraints, then the acceleration at the new place; the factor
/// at the new place serves the velocities, this acceleration and the next step.
///
/// With a `tolerance` the result's error is how far the projection moves the velocity, over that tolerance. A step that
/// follows the motion comes nearly tangent to the constraints; one that ends on another branch of them, or where K is
/// too near to losing rank to tell the tangents, does not. It is measured where K may lose rank.
StepResult settle(Mechanics& mechanics, const IntegrationOptions& options, State* state, Turn turn = Turn::Small,
                  std::optional<Tolerance> tolerance = {});

}  // namespace tanor
