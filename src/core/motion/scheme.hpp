#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <tanor/motion.hpp>

#include "dynamics/mechanics.hpp"
#include "motion/integration_options.hpp"

namespace tanor::detail {

/// A state of a system: x and v on the constraints, the acceleration there, and the works done so far. Between steps
/// the mechanics is linearised at (t, x).
struct State {
  double t = 0.0;
  std::vector<double> x, v, a;
  Power power;          ///< W, at this state
  Power work;           ///< J, time integrals of the powers
  SolveReport report;   ///< report on the accelerations found here last, …
  Reactions reactions;  ///< … and what was found with them

  Kinematics at() const { return {t, x.data(), v.data()}; }
  /// Returns where to write accelerations and all that belongs to them.
  AccelerationOutput output() { return {a.data(), &power, &report, &reactions}; }
  /// Returns the same for a known power.
  AccelerationOutput output_without_power() { return {a.data(), nullptr, &report, &reactions}; }

  /// Exchanges all members of two states, array by array, since moving them in a circle would cost a short step some
  /// percent.
  friend void swap(State& one, State& other) noexcept {
    using std::swap;
    swap(one.t, other.t);
    for (auto array : {&State::x, &State::v, &State::a}) (one.*array).swap(other.*array);
    swap(one.power, other.power);
    swap(one.work, other.work);
    swap(one.report, other.report);
    swap(one.reactions, other.reactions);
  }
};

/// Returns the time below which two instants near t count as one, in an interval of length h.
inline double time_resolution(double t, double h) {
  return 16.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(t), h);
}

/// The result of one attempted step.
struct StepResult {
  Outcome outcome;
  double error = 0.0;               ///< estimated error over the tolerance (adaptive schemes; accept below 1)
  double position_violation = 0.0;  ///< after the step, relative
  double velocity_violation = 0.0;
  bool is_stabilized = true;    ///< false if K is unreliable at the new configuration, see Extrapolation
  bool is_interpolated = true;  ///< true if the scheme interpolates the step; false if another step was made
};

/// One-step method of time integration. It keeps its workspaces, so that a step allocates nothing.
class Scheme {
 public:
  virtual ~Scheme() = default;

  /// Returns the order of the error per unit of time.
  virtual int order() const = 0;
  virtual bool is_adaptive() const = 0;
  /// Returns false if no short step can be made beside a jump of a force, as where Newton's iteration tries both sides.
  virtual bool ends_at_jumps() const { return true; }
  /// Returns the power of h with which the error estimate falls (adaptive schemes).
  virtual int estimate_order() const { return order(); }
  /// Returns the next step after one of length `last` was accepted and the error estimate allows `wanted`.
  virtual double choose_step(double /*last*/, double wanted) const { return wanted; }
  /// Returns true if a step leaves State::a at the new state. Otherwise it is computed on demand.
  virtual bool knows_acceleration() const = 0;

  /// M^-1 f [size()] with the accelerations of supports, and the largest |M^-1 f|, m/s^2.
  struct KnownFree {
    const double* each;
    double largest;
  };
  /// Returns those at the end of the last step. `each` is null if that step did not end at t, or left none.
  virtual KnownFree known_free(double /*t*/) const { return {}; }

  /// Tells how rounding of accelerations enters the velocities of an adaptive scheme.
  virtual RoundingGain rounding_gain() const { return {}; }

  /// Returns the step that the scheme's own estimate allows from this state, s; 0 if it has none. What ends within the
  /// resolution of time, s, has ended.
  virtual double propose_step(const State& /*from*/, double /*resolution*/ = 0.0) { return 0.0; }

  /// Returns true if a step from this state evaluates nothing inside itself, and so may pass a singular configuration.
  virtual bool sees_through(const State& from) = 0;

  /// Makes a step of length h from `from` to `to`, a different object whose time is given: from.t + h, rounded as the
  /// caller wants it. On a failed outcome or an error above 1 the rest of `to` is meaningless, and `from` stays valid.
  virtual StepResult step(const State& from, double h, State* to) = 0;

  /// Prepares `interpolate` inside the last step, with `to` as the step left it. Call this once a step. It may evaluate
  /// the mechanics, which is then linearised elsewhere.
  virtual Outcome prepare_inside(const State& /*from*/, const State& /*to*/) { return {}; }
  /// Writes x and v at from.t + fraction h, `size()` numbers each. The default, for any scheme, is quintic Hermite
  /// interpolation of x from (x, v, a) at both ends, with its derivative as v and errors O(h^6) and O(h^5). For a
  /// scheme that leaves no a, it is cubic, with errors O(h^4) and O(h^3).
  virtual void interpolate(const Parallel& parallel, const State& from, const State& to, double fraction, double* x,
                           double* v) const;

  /// Returns the fractions of a step at which forces enter the step and its error estimate, in rising order, including
  /// 0 and 1.
  virtual std::span<const double> looks() const;
  /// Returns true if `interpolate` needs no `prepare_inside`.
  virtual bool interpolates_at_once() const { return true; }

  /// Forgets the last step, since the equations have changed.
  virtual void forget() = 0;

  /// Exchanges everything besides the state on which the next step depends, to the last bit.
  virtual void exchange_memory(Memory& memory) = 0;
};

/// Makes the scheme of a method (not Auto); rtol and atol of `options` enter the error estimate.
std::unique_ptr<Scheme> make_scheme(Method method, const IntegrationOptions& options, Mechanics& mechanics);

/// Tells whether moving the end of a step onto K'v + xi_t = 0 counts as an error of the step.
enum class MovedVelocity { IsNoError, IsError };

/// Ends any step: projects positions, then velocities onto the constraints, then finds the acceleration at the new
/// state. The factor there serves the velocities, this acceleration and the next step.
///
/// The result's error is how far the projection moves the velocity, over the tolerance of `options`, and the position,
/// over a thousand of these, if that is asked for and K may lose rank. A step that follows the motion ends near the
/// constraints and nearly tangent to them. A step that ends on another branch of them, or where K is too near to losing
/// rank to determine the tangents, does not.
StepResult stabilize(Mechanics& mechanics, const IntegrationOptions& options, State* state,
                     MovedVelocity moved_velocity, Turn turn = Turn::Small);

}  // namespace tanor::detail
