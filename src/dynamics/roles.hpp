#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <tanor/dynamics.hpp>

#include "base/point_path.hpp"
#include "dynamics/instant.hpp"

/// \file What a mechanics may be beside its core. In all roles x and v have `Mechanics::size()` numbers.
namespace tanor {

/// A step of length h from x and v that may miss v and x at its end by atol + rtol |.|.
struct StepTarget {
  double h, atol, rtol;
  const double *x, *v;
};

/// Both halves of a step of RATTLE.
class StepProjector {
 public:
  /// Some force depends on v.
  virtual bool depends_on_velocity() const = 0;
  /// `free_accelerations` finds the same numbers everywhere and always.
  virtual bool is_constant() const = 0;
  /// Accelerations without the constraints, M^-1 f; the prescribed ones at supports. The configuration is linearised.
  virtual Outcome free_accelerations(const Kinematics& at, const Request& request, double* a) = 0;
  /// Projects x onto xi(x, t) = 0 at the end of a step of length h and moves `step_velocity` by (move of x)/h. Keeps to
  /// the K of the step's beginning, so a step that turns constraints by much more than 0.1 rad does not converge.
  virtual ProjectionReport project_step(double t, double h, double* x, double* step_velocity) = 0;
  /// Projects v at the end of the step, whose second half this is. Forces that depend on reactions become those of this
  /// projection's own multipliers.
  virtual ProjectionReport project_step_velocities(double t, double h, const double* x, double* v) = 0;

 protected:
  ~StepProjector() = default;
};

/// Accelerations that need not be exact inside a step: the factor of an earlier configuration may find them.
class InexactSolves {
 public:
  /// Largest error of accelerations, in the M-norm, that keeps the step within its target.
  virtual double allowed_error(const StepTarget& target) = 0;

 protected:
  ~InexactSolves() = default;
};

/// K may have less rank somewhere than where the motion began.
class RankMonitor {
 public:
  /// Largest over smallest mass under constraints: S may be worse conditioned than K by as much.
  virtual double mass_ratio() const = 0;
  /// Remembers the K of the last linearisation, to compare later ones with it.
  virtual void remember_gradients() = 0;
  /// Takes the singular value of K that changed most since then, and returns its value at the last linearisation over
  /// the remembered one. Negative: it went through 0; 0: rows depend; 1: nothing is known. Reliable while K has turned
  /// by less than 90 degrees.
  virtual double compare_gradients() = 0;

 protected:
  ~RankMonitor() = default;
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

/// Groups of points that forces join, whose rounding is their own; see motion/rounding.hpp.
class RoundingGroups {
 public:
  virtual std::size_t num_groups() const = 0;
  /// Largest |a - b| over the points of each group [num_groups()]; a and b have as many numbers as x.
  virtual void largest_differences(const double* a, const double* b, std::span<double> largest) const = 0;
  /// From here on, where gain h whole is no small part of some tolerance, `error_ratios` looks at the parts of errors
  /// that constraints leave, adds gain h along to the tolerances of velocities in each group, and gain h^2 along to
  /// those of positions; with the time in which what is fastest in the group answers to it instead of a longer h, where
  /// the scheme does. Returns the largest of these over the tolerance of its group.
  virtual double allow_rounding(const RoundingLevels& levels, const RoundingGain& gain, const StepTarget& target) = 0;

 protected:
  ~RoundingGroups() = default;
};

/// Forces that may act only between the instants at which a scheme looks at them.
class ForcePassages {
 public:
  virtual std::size_t num_points() const = 0;
  /// Positions and velocities [3 num_points()] of all points: in r_room and v_room, or where they are already. Changes
  /// nothing that later calls depend on.
  virtual Kinematics find_points(const Kinematics& at, double* r_room, double* v_room) = 0;
  /// Whether fixed steps look, too, and warn: of forces that act briefly, not of angles alone, where laws end.
  virtual bool act_briefly() const = 0;
  /// The part of the step along `path` to make instead of one that passes forces unseen; 1: it passes none.
  virtual double find_passage(PointPath* path) = 0;
  /// Names two points that fall onto each other within so many seconds, pulled without bound; empty: none do.
  virtual std::string find_collision(const Kinematics& points, double within) = 0;

 protected:
  ~ForcePassages() = default;
};

/// The motion as a power series in time.
class SeriesExpansion {
 public:
  /// coefficients[k] of x(t + s) = sum over k of coefficients[k] s^k, for k = 0 (x) … the last one. The configuration
  /// is linearised; accelerations found `a`, which may stand in coefficients[2], and `found` with it. Writes the time
  /// up to which the functions of time are as smooth as at t, s.
  virtual Outcome expand(const Kinematics& at, const double* a, const Reactions& found,
                         std::span<double* const> coefficients, double* smooth_until) = 0;
  /// A coefficient costs less than evaluating the equations once: the lower ones stay in the caches.
  virtual bool has_cheap_terms() const = 0;
  /// Power where the first `terms` of the last series after x_0 place the system: nothing is solved for.
  virtual Power power_along(const Kinematics& at, int terms) = 0;
  /// The neighbourhood that each three numbers belong to: what is small is small beside its own. Empty: all to one.
  virtual std::span<const Index> neighbourhoods() const = 0;
  /// Of the largest number here in each of them makes that of all processes, which all ask where one does.
  virtual void find_largest(std::span<double> of_neighbourhoods) = 0;

 protected:
  ~SeriesExpansion() = default;
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

/// Functions of time that act: forces, supports, parameters of constraints, coordinates and friction.
class DriveMonitor {
 public:
  virtual DriveReport look_at_drives(const DrivenStep& step) = 0;
  virtual std::string name_drive(std::size_t drive) const = 0;

 protected:
  ~DriveMonitor() = default;
};

/// Instants where the equations themselves change: a contact begins or ceases to slip.
class EventFunctions {
 public:
  /// Number of functions that stay positive as long as the present equations hold; may change in `switch_equations`.
  virtual std::size_t num_events() const = 0;
  /// All num_events() values where accelerations were found, with what was `found` with them. A value 0 that stays 0,
  /// or falls, asks for a switch; one that rises does not.
  virtual void evaluate_events(const Kinematics& at, const Reactions& found, double* values) = 0;
  /// Functions of the same signs as those values that go like parabolas where the values have kinks (a limit mu |N|
  /// beside N through 0), so that a few of them tell where the values fall below 0.
  virtual void shape_events(const Reactions& found, const double* values, double* shapes) const = 0;
  /// Changes the equations at an instant where the functions in `which` vanish, that of the last `accelerations`. May
  /// change v by what has vanished (a sliding velocity of rounding size becomes 0). Answers with the accelerations of
  /// the new equations, linearised at (t, x).
  virtual Outcome switch_equations(double t, const double* x, double* v, std::span<const std::size_t> which,
                                   const Request& request, const AccelerationOutput& to) = 0;
  /// What guides and supports that move have done at the last switch where it changed v, J.
  virtual Power work_of_switch() const = 0;
  /// The discrete state as plain numbers, to be kept in a snapshot.
  virtual std::vector<int> discrete_state() const = 0;
  /// Throws InputError where the state does not fit.
  virtual void restore_discrete_state(std::span<const int> state) = 0;

 protected:
  ~EventFunctions() = default;
};

class ImplicitFormulation;

/// The roles that a mechanics has; null: it has nothing of that kind.
struct Roles {
  StepProjector* step_projector = nullptr;
  InexactSolves* inexact_solves = nullptr;
  RankMonitor* rank_monitor = nullptr;
  RoundingGroups* rounding_groups = nullptr;
  ForcePassages* force_passages = nullptr;
  DriveMonitor* drives = nullptr;
  EventFunctions* events = nullptr;
  ImplicitFormulation* implicit_formulation = nullptr;
};

}  // namespace tanor
