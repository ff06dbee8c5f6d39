#pragma once

#include <algorithm>
#include <complex>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <tanor/dynamics.hpp>

#include "base/memory.hpp"
#include "base/parallel.hpp"
#include "base/point_path.hpp"

namespace tanor {

/// Whether a computation evaluates K (and factorizes S) at its own configuration or keeps those of the last one.
enum class Gradients { Evaluate, Keep };

/// Power that enters a system, W.
struct Power {
  double supports = 0.0;  ///< through moving supports and time-dependent constraints
  double forces = 0.0;    ///< through forces without potential
  double friction = 0.0;  ///< through friction at contacts
};

struct Energy {
  double kinetic = 0.0, potential = 0.0;  ///< J
};

/// Estimated errors of a step, and where it began and ended; `size()` numbers each.
struct StepErrors {
  const double *x, *v;
  const double *x_from, *v_from, *x_to, *v_to;
  bool are_of_projections = false;  ///< moves along the constraints' gradients, which are errors as a whole
};

/// A step of length h from x and v that may miss v and x at its end by atol + rtol |.|.
struct StepTarget {
  double h, atol, rtol;
  const double *x, *v;
};

/// How well accelerations are known, m/s^2, for each group of points that forces join.
struct RoundingLevels {
  std::span<const double> whole;  ///< of all their parts
  std::span<const double> along;  ///< of the part that constraints leave, which stays where a step ends
};

/// By rounding of accelerations a scheme errs in the velocity at the end of a step of length h, and in its estimate of
/// that error, by up to `factor` h times as much.
struct RoundingGain {
  double factor = 1.0;
  bool is_damped = false;  ///< what swings or decays faster than the step does not add it up over the step
};

/// Largest over the points of |error|/(atol + rtol |.|).
struct ErrorRatios {
  double x, v;  // of positions, of velocities

  /// A NaN wins.
  double largest() const { return larger(x, v); }
};

/// A step of length h from (t, x, v) that follows functions of time as a polynomial of some degree does; between the
/// places where that polynomial is taken they are looked at every `spacing`, s.
struct DrivenStep {
  double t, h, spacing;
  int degree;
  double atol, rtol;
  const double *x, *v;
};

/// What such a step would not see of the functions of time.
struct DriveReport {
  double error = 0.0;     ///< that this makes in x and v, over atol + rtol |.|
  double velocity = 0.0;  ///< m/s: what the step does not follow at all, not even roughly
  int pieces = 1;         ///< of the step, in each of which the functions are nearly linear; at most `most_pieces`
  std::size_t drive = 0;  ///< number of the function that is seen least
  bool is_of_time_alone = true;  ///< else another look is due where the state is another one

  static constexpr int most_pieces = 64;
};

/// What multiplies M, -df/dv and -df/dx in Newton's matrix of an implicit step.
template <class T>
struct NewtonWeights {
  T mass, velocity, position;
};

/// What implicit schemes see: residuals at any (t, x, v, lambda) of
///
///   M x'' = f + K lambda,   K'x' + xi_t = 0
///
/// Springs with a rest length are no part of f but have rows among those of lambda, after the constraints', with
/// lambda + k xi + c dxi/dt = 0 instead: however stiff they are, Newton's iteration sees rods that give way. Its
/// matrix,
///
///   [ N  -K ]     N = a M - b df/dv - c (df/dx + d(K lambda)/dx)
///   [ K'  E ]     E = 1/(b damping + c stiffness) for springs, else 0
///
/// has the derivatives of springs, dampers, drag, formulas and rods; what else there is counts as not stiff.
class ImplicitEquations {
 public:
  virtual ~ImplicitEquations() = default;

  /// Of constraints, and all of them.
  virtual std::size_t num_constraints() const = 0;
  virtual std::size_t num_rows() const = 0;
  /// lambda [num_rows()] to begin with: of the mechanics' last accelerations, and of springs at (x, v).
  virtual void write_multipliers(const double* x, const double* v, double* lambda) = 0;

  /// M^-1 (f + K lambda) into a; K'v + xi_t, or lambda + k xi + c dxi/dt, into rows.
  virtual Outcome evaluate(double t, const double* x, const double* v, const double* lambda, double* a,
                           double* rows) = 0;
  /// xi, or K'v + xi_t with K at x, of constraints [num_constraints()]; returns the largest relative violation.
  virtual double evaluate_positions(double t, const double* x, double* xi) = 0;
  virtual double evaluate_rates(double t, const double* x, const double* v, double* rates) = 0;
  /// At the last `evaluate`.
  virtual Power power(const double* x, const double* v) const = 0;

  /// K and the derivatives of forces, from here to the next call.
  virtual void linearise(double t, const double* x, const double* v, const double* lambda) = 0;
  /// How forces answer to a move dx: M^-1 (df/dx + d(K lambda)/dx) dx is added to a, k K'dx to the rows of springs.
  virtual void add_stiffness(const double* dx, double* a, double* rows) = 0;
  /// Newton's matrix at the last linearisation; one real and one complex factor stay until the next ones.
  virtual Outcome factorize(const NewtonWeights<double>& weights) = 0;
  virtual Outcome factorize(const NewtonWeights<std::complex<double>>& weights) = 0;
  /// The increments dx [size()] (0 at supports) and dlambda that answer to residuals of `evaluate`: in their places
  ///
  ///   N dx - K dlambda = M a,   K'dx + E dlambda = -rows (of springs -E rows)
  virtual void solve(double* a, double* rows) = 0;
  virtual void solve(std::complex<double>* a, std::complex<double>* rows) = 0;

  /// The linearisation and the factors that stand.
  virtual void exchange_memory(Memory& memory) = 0;
};

/// What motion sees of a mechanical system: x'' = a(t, x, v) on a constraint manifold. x and v have `size()` numbers.
///
/// A configuration is *linearised* when K stands at it and S has its factor; projections reuse the last one.
class Mechanics {
 public:
  virtual ~Mechanics() = default;

  virtual std::size_t size() const = 0;
  virtual bool depends_on_velocity() const = 0;  ///< some force does
  virtual bool has_work() const = 0;             ///< `power` is not identically 0

  /// Writes the prescribed motion at t into x and v; to be called before anything else is computed at a new t.
  virtual void prescribe(double t, double* x, double* v) = 0;

  virtual Outcome linearise(double t, const double* x) = 0;
  virtual Outcome accelerations(double t, const double* x, const double* v, Gradients gradients, double* a) = 0;
  /// Without the constraints: M^-1 f; the prescribed ones at supports.
  virtual Outcome free_accelerations(double t, const double* x, const double* v, double* a) = 0;

  /// Onto xi(x, t) = 0 along M^-1 K of the last linearisation, chord iterations; linearises anew only where they stall.
  virtual ProjectionReport project_positions(double t, double* x) = 0;
  /// The same after a step that may have turned constraints far: linearises at x first, where that costs no more than
  /// the iterations which it saves.
  virtual ProjectionReport project_far_positions(double t, double* x) { return project_positions(t, x); }
  /// The same at the end of a step of length h, which moves `step_velocity` by (move of x)/h; keeps to the K of the
  /// step's beginning whatever happens, so a step that turns constraints by much more than 0.1 rad does not converge.
  virtual ProjectionReport project_step(double t, double h, double* x, double* step_velocity) = 0;
  /// Onto K'v + xi_t = 0 in the M-norm, with the linearisation at (t, x).
  virtual ProjectionReport project_velocities(double t, const double* x, double* v) = 0;
  /// The same at the end of a step of length h, whose second half it is: forces that depend on reactions become those
  /// of its own multipliers.
  virtual ProjectionReport project_step_velocities(double t, double /*h*/, const double* x, double* v) {
    return project_velocities(t, x, v);
  }

  /// How large an error of all its accelerations may be, in a norm of its own: h |dv'| and h^2 |dv'| do not miss the
  /// target.
  virtual double allowed_error(const StepTarget& /*target*/) const { return 0.0; }
  /// From here on accelerations with `Gradients::Evaluate` may have that error, and then leave K but no factor there.
  /// 0: rounding alone.
  virtual void allow_error(double /*error*/) {}
  /// Everything beside the state and the discrete state on which later answers depend, to the last bit: what iterative
  /// solves start from, charts, the last multipliers.
  virtual void exchange_memory(Memory& memory) = 0;

  /// `atol` 0: 1e-10 of the length and of the speed of each point's neighbourhood, see Scales.
  /// t: at the step's beginning. The last accelerations were those at its end.
  virtual ErrorRatios error_ratios(double t, const StepErrors& errors, double atol, double rtol) = 0;

  /// Which neighbourhood each three numbers belong to: what is small is small beside its own. Empty: all to one.
  virtual std::span<const Index> neighbourhoods() const { return {}; }

  // ---- rounding, see motion/rounding.hpp ----

  /// Groups of points that forces join, whose rounding is their own; 0: rounding is not asked for.
  virtual std::size_t num_groups() const { return 0; }
  /// Largest |a - b| over the points of each group; a and b have `size()` numbers, `largest` num_groups().
  virtual void largest_differences(const double* /*a*/, const double* /*b*/, std::span<double> /*largest*/) const {}
  /// From here on, where gain h whole is no small part of some tolerance, `error_ratios` looks at the parts of errors
  /// that constraints leave, adds gain h along to the tolerances of velocities in each group, and gain h^2 along to
  /// those of positions; with the time in which what is fastest in the group answers to it instead of a longer h, where
  /// the scheme does. Returns the largest of these over the tolerance of its group.
  virtual double allow_rounding(const RoundingLevels& /*levels*/, const RoundingGain& /*gain*/,
                                const StepTarget& /*target*/) {
    return 0.0;
  }

  /// How many accelerations were found so far.
  virtual std::size_t num_accelerations() const { return 0; }

  /// Of K, as it was decided last.
  virtual std::size_t rank() const { return 0; }
  /// K may have less rank somewhere than where the motion began.
  virtual bool may_lose_rank() const { return true; }
  /// Largest over smallest mass under constraints: S may be worse conditioned than K by as much.
  virtual double mass_ratio() const { return 1.0; }
  /// To compare with later ones: the K of the last linearisation.
  virtual void remember_gradients() {}
  /// Of the singular value of K that changed most since then: what it is at the last linearisation over what it was.
  /// Negative: it went through 0; 0: rows depend; 1: nothing is known. Reliable while K has turned by less than 90
  /// degrees.
  virtual double compare_gradients() { return 1.0; }
  /// x means the same before and after a step that was accepted.
  virtual bool keeps_variables() const { return true; }

  // ---- what a step may pass between the places that its scheme looks at ----

  /// Some force may act there alone.
  virtual bool may_pass_forces() const { return false; }
  /// What a step may miss at each point where no absolute tolerance is given, m and m/s [num_points()].
  struct PointTolerances {
    std::span<const double> positions, velocities;
    std::span<const double> accelerations;  ///< m/s^2, no tolerance: as much as may act there
  };
  virtual PointTolerances point_tolerances() const { return {}; }
  virtual std::size_t num_points() const { return size() / 3; }
  /// Positions and velocities [3n] of all points at (t, x, v): in r_room and v_room, or where they are already.
  /// Changes nothing that later calls depend on.
  struct Points {
    const double *r, *v;
  };
  virtual Points find_points(double /*t*/, const double* x, const double* v, double* /*r_room*/, double* /*v_room*/) {
    return {x, v};
  }
  /// The part of the step along `path` to make instead of one that passes forces unseen; 1: it passes none.
  virtual double find_passage(PointPath* /*path*/) { return 1.0; }

  // ---- the motion as a power series in time ----

  /// Why there is none; empty: `expand` finds it.
  virtual std::string series_obstacle() const { return "the motion in coordinates is not expanded in time"; }
  /// coefficients[k] [size()] of x(t + s) = sum over k of coefficients[k] s^k, for k = 0 (x) … the last one, in the
  /// order that it has; linearised at (t, x). `a` may be null; else the last accelerations were those at (t, x, v), and
  /// found it. Writes the time up to which the functions of time are as smooth as at t, s.
  virtual Outcome expand(double /*t*/, const double* /*x*/, const double* /*v*/, const double* /*a*/,
                         std::span<double* const> /*coefficients*/, double* /*smooth_until*/) {
    return {};
  }
  /// Power at a state that moves with the acceleration a, which is not solved for.
  virtual Power power_along(double /*t*/, const double* /*x*/, const double* /*v*/, const double* /*a*/) { return {}; }

  // ---- functions of time: forces, supports, parameters of constraints, coordinates and friction ----

  /// Some function of time acts.
  virtual bool has_drives() const = 0;
  virtual DriveReport look_at_drives(const DrivenStep& step) = 0;
  virtual std::string name_drive(std::size_t drive) const = 0;

  // ---- events: instants where the equations themselves change (a contact begins or ceases to slip) ----

  /// Number of functions that stay positive as long as the present equations hold; may change in `switch_equations`.
  virtual std::size_t num_events() const { return 0; }
  /// The cheap ones, at (t, x, v), and the others, at the state of the last `accelerations`: all num_events() values.
  /// A value 0 that stays 0, or falls, asks for a switch; one that rises does not.
  virtual void evaluate_events(double /*t*/, const double* /*x*/, const double* /*v*/, double* /*values*/) {}
  /// At the state of the last `evaluate_events`: functions of the same signs that go like parabolas where the values
  /// have kinks (a limit mu |N| beside N through 0), so that a few of them tell where the values fall below 0.
  virtual void shape_events(const double* values, double* shapes) const { std::copy_n(values, num_events(), shapes); }
  /// At an instant where the functions in `which` vanish, that of the last `accelerations`: changes the equations
  /// there. May change v by what has vanished (a sliding velocity of rounding size becomes 0), and leaves in `a` the
  /// accelerations of the new equations, linearised at (t, x).
  virtual Outcome switch_equations(double /*t*/, const double* /*x*/, double* /*v*/,
                                   std::span<const std::size_t> /*which*/, double* /*a*/) {
    return {};
  }
  /// What guides and supports that move have done at the last switch where it changed v, J.
  virtual Power work_of_switch() const { return {}; }
  /// The discrete state, plain numbers, to be kept in a snapshot; and back. Throws InputError where it does not fit.
  virtual std::vector<int> discrete_state() const { return {}; }
  virtual void restore_discrete_state(std::span<const int> /*state*/) {}

  virtual bool has_implicit_equations() const { return false; }
  /// For implicit schemes; null where the mechanics has none.
  virtual std::unique_ptr<ImplicitEquations> make_implicit_equations() { return nullptr; }

  /// At the state of the last `accelerations`.
  virtual Power power(const double* x, const double* v) const = 0;
  virtual Energy energy(double t, const double* x, const double* v) = 0;
  virtual const SolveReport& last_solve() const = 0;
  virtual const Parallel& parallel() const = 0;
};

}  // namespace tanor
