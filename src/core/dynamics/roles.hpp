#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <tanor/dynamics.hpp>

#include "base/memory.hpp"
#include "base/point_path.hpp"
#include "base/power_series.hpp"
#include "dynamics/instant.hpp"

/// \file Roles that a mechanics may have beside its core. In all roles x and v have `Mechanics::size()` numbers.
namespace tanor::detail {

/// A step of length h from x and v whose errors of v and x at its end may be atol + rtol |.|.
struct StepTarget {
  double h, atol, rtol;
  const double *x, *v;
};

/// The projections of both halves of a step of RATTLE.
class StepProjector {
 public:
  /// Returns true if some force depends on v.
  virtual bool depends_on_velocity() const = 0;
  /// Returns true if `free_accelerations` gives the same numbers everywhere and always.
  virtual bool is_constant() const = 0;
  /// Returns the acceleration without the constraints that all moving points always have. Returns null if there is
  /// none, or if points beyond `num_moving` (guests of other ranks) need it as well.
  virtual const Vec3* uniform_acceleration() const = 0;
  /// Returns how many points move and are brought (see `project_step`). What follows them in x is there already.
  virtual std::size_t num_moving() const = 0;
  /// Computes the accelerations without the constraints, M^-1 f, and the prescribed ones at supports. The configuration
  /// must be linearised. Writes the largest one where no contact changes them.
  virtual Outcome free_accelerations(const Kinematics& at, const Request& request, double* a, double* largest) = 0;
  /// Projects x onto xi(x, t) = 0 at the end of a step of length h and changes `step_velocity` by (move of x)/h. Keeps
  /// the K of the step's beginning, so a step that turns constraints by much more than 0.1 rad does not converge.
  /// Brings points of both arrays from `source` before it reads them.
  virtual ProjectionReport project_step(double t, double h, const PointSource& source, double* x,
                                        double* step_velocity) = 0;
  /// Projects v at the end of the step, whose second half this is. Forces that depend on reactions are taken from this
  /// projection's own multipliers.
  virtual ProjectionReport project_step_velocities(double t, double h, const double* x, double* v) = 0;

 protected:
  ~StepProjector() = default;
};

/// Accelerations inside a step that need not be exact, so that the factor of an earlier configuration may serve.
class InexactSolves {
 public:
  /// Returns the largest error of accelerations, in the M-norm, that keeps the step within its target.
  virtual double allowed_error(const StepTarget& target) = 0;

 protected:
  ~InexactSolves() = default;
};

/// Watches for configurations where K has less rank than where the motion began. The numbers are those of this process;
/// one that is not derived knows nothing, and hides nothing that others find.
class RankMonitor {
 public:
  /// Returns the largest over the smallest mass under constraints. S may be worse conditioned than K by this factor.
  virtual double mass_ratio() const { return 1.0; }
  /// Remembers the K of the last linearisation, to compare later ones with it.
  virtual void remember_gradients() {}
  /// Returns the value at the last linearisation, over the remembered one, of the singular value of K that changed most
  /// since then. A negative value means that it went through 0, 0 that rows depend, and 1 that nothing is known. The
  /// result is reliable while K has turned by less than 90 degrees.
  virtual double compare_gradients() { return 1.0; }

  virtual ~RankMonitor() = default;
};

/// The rounding of accelerations, m/s^2, for each group of points that forces join.
struct RoundingLevels {
  std::span<const double> whole;  ///< of all their parts
  std::span<const double> along;  ///< of the part that constraints leave, which remains at the end of a step
};

/// The effect of this rounding on a scheme: errors up to `factor` h times the rounding in the velocity at the end of a
/// step of length h, and in the estimate of its error.
struct RoundingGain {
  double factor = 1.0;
  bool is_damped = false;  ///< motions faster than the step do not accumulate it over the step
};

/// Groups of points that forces join, each with its own rounding; see motion/rounding.hpp.
class RoundingGroups {
 public:
  virtual std::size_t num_groups() const = 0;
  /// Computes the largest |a - b| over the points of each group [num_groups()]; a and b have as many numbers as x.
  virtual void largest_differences(const double* a, const double* b, std::span<double> largest) const = 0;
  /// Makes `error_ratios` allow for rounding from here on, if gain h whole is no small part of some tolerance. It then
  /// looks at the parts of errors that constraints leave, and adds gain h along to the tolerances of velocities in each
  /// group, and gain h^2 along to those of positions. For a damped scheme h is no longer than the response time of the
  /// fastest motion in the group. Returns the largest addition to velocities over the tolerance of its group, of this
  /// process.
  virtual double allow_rounding(const RoundingLevels& levels, const RoundingGain& gain, const StepTarget& target) = 0;
  /// Exchanges what the last call of it allowed.
  virtual void exchange_allowance(Memory& memory) = 0;

 protected:
  ~RoundingGroups() = default;
};

/// Forces that may act only between the instants at which a scheme evaluates them, on this process; one that is not
/// derived has none.
class UnseenForces {
 public:
  virtual std::size_t num_points() const { return 0; }
  /// Returns the positions and velocities [3 num_points()] of all points, in r_room and v_room, or where they are
  /// already. Changes nothing that later calls depend on.
  virtual Kinematics find_points(const Kinematics& at, double* /*r_room*/, double* /*v_room*/) { return at; }
  /// Returns true if fixed steps must look, too, and warn: for forces that act briefly, but not for angles alone, where
  /// laws end.
  virtual bool act_briefly() const { return false; }
  /// Returns the part of the step along `path` to make so that it passes no forces unseen, or 1 if it passes none.
  /// Notes in `path` where a force jumps first.
  virtual double find_unseen(PointPath* /*path*/) { return 1.0; }
  /// Names two points that collide within so many seconds, pulled without bound, or returns an empty string.
  virtual std::string find_collision(const Kinematics& /*points*/, double /*within*/) { return {}; }
  /// Returns true if a force may jump where points reach a certain place.
  virtual bool may_jump() const { return false; }

  virtual ~UnseenForces() = default;
};

/// How far a series holds.
struct SeriesExtent {
  double smooth_until = 0.0;            ///< time up to which the functions of time are as smooth as at the beginning, s
  double longest = any_length;          ///< step for which it is exact enough where terms are left out, s
  std::vector<std::uint8_t> last_term;  ///< [n/3] order of the last term that is not 0; empty if all have all terms
};

/// The motion as a power series in time.
class SeriesExpansion {
 public:
  /// Computes coefficients[k] of x(t + s) = sum over k of coefficients[k] s^k, for k = 0 (x) … the last one. The
  /// configuration must be linearised. Its accelerations are `a`, which may be coefficients[2], with their reactions
  /// `found`. Terms that no step of the wanted length needs may be left out; they are 0. `extent` is a new one, or that
  /// of the last series in these coefficients.
  virtual Outcome expand(const Kinematics& at, const double* a, const Reactions& found, const SeriesDemand& wanted,
                         std::span<double* const> coefficients, SeriesExtent* extent) = 0;
  /// Returns true if a coefficient costs less than one evaluation of the equations, since the lower ones stay in the
  /// caches.
  virtual bool has_cheap_terms() const = 0;
  /// Returns true if many islands each leave out the terms that they do not need.
  virtual bool leaves_out_terms() const = 0;
  /// Returns the power at the state given by the first `terms` of the last series after x_0, without any solve.
  virtual Power power_along(const Kinematics& at, int terms) = 0;
  /// The neighbourhood of each three numbers, beside which they are small. Empty if all belong to one.
  virtual std::span<const Index> neighbourhoods() const = 0;
  /// Replaces the largest number of each neighbourhood by that of all processes, which must all call this.
  virtual void find_largest(std::span<double> of_neighbourhoods) = 0;

 protected:
  ~SeriesExpansion() = default;
};

/// A step of length h from (t, x, v) that follows functions of time as a polynomial of some degree does. Between the
/// nodes of that polynomial the functions are sampled every `spacing`, s.
struct DrivenStep {
  double t, h, spacing;
  int degree;
  double atol, rtol;
  const double *x, *v;
};

/// The variation of the functions of time that such a step would not see.
struct DriveReport {
  double error = 0.0;     ///< of x and v due to it, over atol + rtol |.|
  double velocity = 0.0;  ///< m/s: of the variation that the step does not follow even roughly
  int pieces = 1;         ///< of the step, in each of which the functions are nearly linear; at most `most_pieces`
  std::size_t drive = 0;  ///< number of the function with the largest error

  static constexpr int most_pieces = 64;
};

/// Functions of time in forces, supports, parameters of constraints, coordinates and friction, on this process; one
/// that is not derived has none.
class DriveMonitor {
 public:
  virtual DriveReport look_at_drives(const DrivenStep& /*step*/) { return {}; }
  virtual std::string name_drive(std::size_t /*drive*/) const { return {}; }

  virtual ~DriveMonitor() = default;
};

/// Instants at which the equations of this process change, because a contact begins or ceases to slip; one that is not
/// derived has none.
class EventFunctions {
 public:
  /// The number of functions that stay positive as long as the present equations hold; may change in
  /// `switch_equations`.
  virtual std::size_t num_events() const { return 0; }
  /// Evaluates all num_events() values where accelerations were computed, with their reactions `found`. A value 0 that
  /// stays 0, or falls, requires a switch; one that rises does not.
  virtual void evaluate_events(const Kinematics& /*at*/, const Reactions& /*found*/, double* /*values*/) {}
  /// Evaluates functions with the signs of those values that are close to parabolas where the values have kinks (a
  /// limit mu |N| with N through 0). A few of them suffice to locate where the values fall below 0.
  virtual void shape_events(const Reactions& /*found*/, const double* /*values*/, double* /*shapes*/) const {}
  static constexpr double unknown_slope = 0.0;  ///< falls and rises alone are looked at
  /// Evaluates how the shapes change in time, or `unknown_slope`.
  virtual void evaluate_slopes(const Kinematics& /*at*/, std::span<double> slopes) {
    std::ranges::fill(slopes, unknown_slope);
  }
  /// Changes the equations at an instant where the functions in `which` vanish, that of the last `accelerations`. May
  /// set vanished parts of v to 0 (a sliding velocity of rounding size). Computes the accelerations of the new
  /// equations, linearised at (t, x).
  virtual Outcome switch_equations(double /*t*/, const double* /*x*/, double* /*v*/,
                                   std::span<const std::size_t> /*which*/, const Request& /*request*/,
                                   const AccelerationOutput& /*to*/) {
    return {};
  }
  /// Returns the work of moving guides and supports at the last switch, where it changed v, J.
  virtual Power work_of_switch() const { return {}; }
  /// Returns what happened to one-sided constraints at the last switch, or at the beginning of the motion.
  virtual std::span<const ContactEvent> changes_of_switch() const { return {}; }
  /// Returns the discrete state as plain numbers, to be kept in a snapshot.
  virtual std::vector<int> discrete_state() const { return {}; }
  /// Names what is another than in a discrete state before.
  virtual std::string describe_change(std::span<const int> /*before*/) const { return {}; }
  /// Throws InputError if the state does not fit.
  virtual void restore_discrete_state(std::span<const int> /*state*/) {}

  virtual ~EventFunctions() = default;
};

class CornerFunctions;
class ImplicitFormulation;

/// The roles of a mechanics; null for those that it does not have. Among several processes all have a role if some have
/// it, which gives an answer that changes nothing where a process does not have it. They have step projectors, rounding
/// groups and implicit formulations if all have them.
struct Roles {
  StepProjector* step_projector = nullptr;
  InexactSolves* inexact_solves = nullptr;
  RankMonitor* rank_monitor = nullptr;
  RoundingGroups* rounding_groups = nullptr;
  UnseenForces* unseen_forces = nullptr;
  DriveMonitor* drives = nullptr;
  EventFunctions* events = nullptr;
  ImplicitFormulation* implicit_formulation = nullptr;
  CornerFunctions* corners = nullptr;
};

}  // namespace tanor::detail
