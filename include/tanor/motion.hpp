#pragma once

#include <concepts>
#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <tanor/dynamics.hpp>
#include <tanor/observables.hpp>
#include <tanor/ranks.hpp>

namespace tanor {

enum class Method { Auto, Rk4, Dopri5, Dop853, Taylor, Rattle, Rattle4, Rattle6, Radau5, GeneralizedAlpha };

/// Cost and memory of one step of a method, measured in runs of chains, trees, clusters, nets and lattices; for taylor,
/// of each term of its series. It serves to compare methods before a run (`tanor info`).
struct MethodCost {
  double solves = 0.0;          ///< solves with the factor of S (in coordinates, of H)
  double factorizations = 0.0;  ///< factorizations of S
  double projections = 0.0;     ///< largest number of solves that projections onto the constraints add
  double bytes_a_point = 0.0, bytes_an_equation = 0.0, bytes_a_nonzero = 0.0;  ///< beside the state and the factor
};

/// One row of the table of methods.
struct MethodTraits {
  Method method = Method::Auto;
  std::string_view name;              ///< in scenes, on the command line and in reports
  std::string_view what;              ///< description in one line
  int order = 0;                      ///< order of the error at the end of a run; 0 if the tolerance decides
  bool has_fixed_steps = false;       ///< true if it steps by `step`; the others follow a tolerance
  bool is_implicit = false;           ///< true if it solves the equations of a whole step, for stiff systems
  bool serves_friction = false;       ///< true if contacts with friction are allowed
  bool steps_in_coordinates = false;  ///< true if it steps in coordinates; the others step in positions and project
  bool is_compared = false;           ///< true if `tanor error-time` runs it by default
  MethodCost cost{};
};

/// All methods of this version, auto first. Everything that names methods reads this table.
TANOR_API std::span<const MethodTraits> methods();
TANOR_API const MethodTraits& traits_of(Method method);
/// Returns the method with this name. Throws InputError listing the methods of this version.
TANOR_API Method method_from_name(std::string_view name);
/// Returns the name of a method in scenes and reports.
TANOR_API std::string_view name_of(Method method);
TANOR_API bool has_fixed_steps(Method method);

enum class Stabilisation { Projection, None };

struct MotionOptions {
  Method method = Method::Auto;  ///< see choose_method for Auto
  double step = 0.0;             ///< s; the fixed step, or the first trial step under a tolerance; 0 if not given
  /// Upper bound of all steps, s; 0 means none. It serves callables of the state that act for a short time only, of
  /// which no bound is known.
  double max_step = 0.0;
  double rtol = 1e-8;  ///< relative to |r| and |v| of each point
  /// m and m/s; 0 means 1e-10 of the length around each point, and of the speed there. This length is that of the
  /// constraints and springs at the point. The speed is the largest of the start and of a fall through that length.
  double atol = 0.0;
  Stabilisation stabilisation = Stabilisation::Projection;
  StartMode start = StartMode::Check;
  int order = 0;  ///< number of terms of the series of taylor, 4 … 24; 0 if the tolerance decides
  /// Fraction of the fastest oscillations that a step of generalized_alpha leaves, 0 … 1.
  double spectral_radius = 0.8;
};

/// A method and the reason why `auto` stands for it; the reason is empty for a method that was asked for.
struct ChosenMethod {
  Method method = Method::Auto;
  std::string reason{};
};
/// Chooses the method that `auto` means for a system: generalized_alpha or radau5 if springs are too stiff for explicit
/// steps (and there is neither friction nor a step in coordinates), else rattle (in coordinates rk4) if a step is
/// given, else taylor if everything has a series in time, else dop853. A simulation switches from taylor or dop853 to
/// radau5 if stability alone holds their steps short (MotionReport::method and method_reason then say so).
TANOR_API ChosenMethod choose_method(const MotionOptions& options, const Dynamics& dynamics);
/// Returns true if the motion asks for an implicit method, or if `auto` chooses one by the system's description. Such a
/// motion needs whole islands on every rank (see ranks.hpp), since each rank factorizes its own part of Newton's
/// matrix.
TANOR_API bool wants_whole_islands(const MotionOptions& options, const System& system);

/// Kinetic and potential energy, J, and the work done since the start.
struct TANOR_API EnergyReport {
  double start = 0.0, now = 0.0;
  double kinetic = 0.0, potential = 0.0;  ///< present values
  double potential_at_start = 0.0;
  double work_of_supports = 0.0;    ///< done by moving supports and time-dependent constraints
  double work_of_forces = 0.0;      ///< done by forces without potential: drag, damping, time-dependent ones
  double work_of_potentials = 0.0;  ///< for time-dependent energies, the integral of their explicit dU/dt
  double work_of_friction = 0.0;    ///< done at contacts; on moving guides it may be positive
  double work_of_impacts = 0.0;     ///< of one-sided constraints; what they take is negative
  /// The largest value, at any step, of the kinetic energy, of the change of the potential energy since the start and
  /// of each work; at least 1e8 roundings of the energies themselves, since smaller values cannot be told from
  /// rounding.
  double scale = 0.0;
  /// The largest part of |now - start - works| so far that exceeds what the tolerance allows for velocities and
  /// positions, J, and its time, s.
  double largest_drift = 0.0, largest_drift_time = 0.0;
  /// Returns (now - start - works)/scale; 0 if nothing ever moved.
  double drift_relative() const;
};

/// Friction at all instants at which it was found. Laws that read no reaction (viscous) take no iteration.
struct [[nodiscard]] FrictionSummary {
  std::size_t solves = 0;  ///< instants at which friction that depends on reactions was found
  double iterations_mean = 0.0;
  int iterations_max = 0;
  double contraction_max = 0.0;  ///< measured, see FrictionReport
  /// The largest bound, N; NaN if it is not proven everywhere.
  double error_bound = std::numeric_limits<double>::quiet_NaN();
  Uniqueness uniqueness = Uniqueness::NotAsked;       ///< the weakest result
  FrictionMethod method_used = FrictionMethod::Auto;  ///< the strongest method that was needed
  double residual_max = 0.0;                          ///< |tau(lambda) - tau| over the largest friction
  /// Number of instants, after steps and at switches of contacts, at which several accelerations obeyed the law and the
  /// one nearest to the previous step was taken; and the first of them, s (NaN if there was none).
  std::size_t several = 0;
  double first_several = std::numeric_limits<double>::quiet_NaN();
  std::string uniqueness_reason{};  ///< reason for the weakest result, where known
};

/// Violations of the constraints by a motion.
struct Violations {
  double position = 0.0;      ///< relative, as in Dynamics::position_violation
  double velocity = 0.0;      ///< relative to the velocity scale
  double acceleration = 0.0;  ///< scaled residual |K'w + phi|
};

/// The instant at which a motion came nearest to a singular configuration.
struct NearestToSingular {
  double reciprocal_condition = 1.0;  ///< smallest one of the scaled S or H after any step
  double time = 0.0;                  ///< s
};

/// Reports what happened between the steps of a motion.
struct EventReport {
  std::size_t events = 0;     ///< instants at which the equations changed because a contact began or ceased to slip
  double last_event = 0.0;    ///< time of the last of them, s
  std::string last_change{};  ///< what it was, such as "rough at hoop[0], point 0 slips"; empty where that is not known
  /// Which event of `Simulation::add_event` may have a passage that was not seen, and when first: it touches 0 to
  /// rounding there, has more turns in one step than can be followed, or a bump that few places have seen. Empty if
  /// there is none.
  std::string events_may_be_missed{};
  std::vector<ContactEvent> contact_events{};  ///< of one-sided constraints, in the order of time
};

/// Report of a motion since its start.
struct [[nodiscard]] MotionReport : EventReport {
  Method method = Method::Auto;  ///< method that was used
  std::string method_reason{};   ///< reason, if `auto` chose the method
  double time = 0.0;             ///< time reached, s
  std::size_t steps = 0, rejected = 0;
  double last_step = 0.0;
  /// Why the motion may be less accurate than asked for although nothing failed, and when that was first seen: the
  /// absolute tolerance is coarse, one fixed step turns the motion by more than 0.4 rad, steps may miss a short event,
  /// the energy drifts by more of its scale than the method should allow (1e-2 for fixed steps; 1e4 rtol, between 1e-4
  /// and 1e-2, for a tolerance), or the tolerance is below the rounding of the forces. The drift is measured relative
  /// to all energy flows, so the warning is withdrawn if much more flows later. Empty if there is no warning.
  std::string accuracy_warning{};
  StartReport start;
  Violations violation;       ///< largest value after any step
  Violations last_violation;  ///< value after the last step
  NearestToSingular nearest_to_singular;
  double last_reciprocal_condition = 1.0;  ///< value for the scaled S or H after the last step
  RankChanges rank_changes;                ///< since the start
  SingularPassages singular_passages;      ///< in the order of time
  EnergyReport energy;
  FrictionSummary friction;
  Counters counters;
  PhaseTimes times;
};

/// Actions where a condition on observables becomes true.
enum class EventAction {
  Report,   ///< the passage is noted
  Stop,     ///< the advance ends there
  Break,    ///< a rod, rope, pulley, spring or bond is taken out
  Release,  ///< a support is let go with its own mass, or a guide lets go of its point
};

/// A function of the motion whose zero crossings are searched, or a condition on observables.
struct Event {
  enum class Direction { Both, Rising, Falling };

  std::string name{};
  /// The function of t, r [3n] and v [3n] in the user's order. It must be smooth where it vanishes.
  std::function<double(double t, std::span<const double> r, std::span<const double> v)> value{};
  Direction direction = Direction::Both;
  bool stops = false;  ///< ends the advance at the crossing
  /// In place of a function: a condition such as "any tension(links) > 20" or "t > 2" (docs/observables.md). It passes
  /// where it becomes true, also at the start.
  std::string when{};
  EventAction action = EventAction::Report;  ///< of a condition
  /// Names what is taken out, such as "links[3]" or "hook"; if empty, the member of which the condition speaks.
  std::string of{};
  Constants parameters{};  ///< names of numbers that the condition may use
};

/// A zero crossing of an event, located to the accuracy of the method inside its steps.
struct Passage {
  std::size_t event = 0;  ///< number that `add_event` returned, behind the events of `breaks_at`
  double time = 0.0;      ///< s
  bool rises = false;
  std::string name{};                        ///< of the event, or its condition
  std::string member{};                      ///< of which the condition speaks, or what was taken out
  double energy_lost = 0.0;                  ///< J, held by what was taken out: energy before less energy after
  std::string rest{};                        ///< what is left without any constraint; empty if nothing is
  EventAction action = EventAction::Report;  ///< what was done
  std::string taken{};                       ///< place of what went in the system, "constraints/0/3"; empty if nothing
};

/// Throws InputError if a condition, or what it takes out, cannot be read for a system.
TANOR_API void check_event(const System& system, const Event& event);

/// A motion of a system in time.
class TANOR_API Simulation {
 public:
  /// Makes the start consistent (StartMode); throws InputError for bad input. `outcome()` reports a numerical failure.
  explicit Simulation(System system, MotionOptions motion = {}, SolverOptions solver = {}, double t_start = 0.0);
  /// Simulates one rank's part of a system that is spread over several (see ranks.hpp). Every rank has the same options
  /// and makes every call, in the same order. All ranks then make the same steps, and the report's steps, violations
  /// and energies are those of the whole system. Arrays are those of the part; guests follow their owners. The value of
  /// an event is the sum of the functions' values of all ranks. Certificates and ranks of K refer to the part alone;
  /// there are none if islands lie on several ranks.
  template <std::same_as<Part> OwnPart>  // a template, so that {} in its place means options
  Simulation(System system, const OwnPart& part, MotionOptions motion = {}, SolverOptions solver = {},
             double t_start = 0.0)
      : Simulation(Spread{}, std::move(system), part, motion, solver, t_start) {}
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;
  ~Simulation();

  /// The observer is called after every step; it returns false to stop there.
  using Observer = std::function<bool(const MotionReport&)>;

  /// Steps to exactly t_end, or to an event that stops. At t_end = time() events act on what is true there, and there
  /// is no step. Throws InputError if t_end is earlier. After a failure the state is that of the last good step.
  Outcome advance_to(double t_end, const Observer& observer = {});
  [[deprecated("its name is advance_to")]] Outcome advance(double t_end, const Observer& observer = {}) {
    return advance_to(t_end, observer);
  }

  /// Searches for the event from now on; returns its number. Each step evaluates the function at twelve places, and at
  /// more of them until it is followed between them, so that all crossings are found, each once. Where that cannot be
  /// known, `MotionReport::events_may_be_missed` says so. A bump that is narrow beside the step and seen at none of the
  /// twelve places is missed; a `max_step` finds it. A jump through 0 is a crossing. A function that begins at 0 does
  /// not cross there; one that vanishes at t_end, to rounding, crosses there. If a step is extrapolated past a singular
  /// configuration, a stopping event ends the advance at the end of that step, and its crossing is reported at its own
  /// time. A value that is not finite ends the advance with an outcome that names the event. Events are no part of a
  /// snapshot, and `restore` forgets crossings later than the restored time. What events have taken out is in the
  /// snapshot: points, members and equations keep their numbers, a multiplier that is gone, and its tension,
  /// are NaN. Conditions on forces solve for accelerations at each place where they are evaluated. Throws
  /// InputError if there is no function, or for a condition that cannot be read or acted upon. Groups with `breaks_at`
  /// have an event each, "breaks_at of links", before all others.
  std::size_t add_event(Event event);
  /// Returns the crossings so far, in the order of time.
  std::span<const Passage> passages() const;

  /// Adds an observable; returns its number. Throws InputError for a text that cannot be read, with its column.
  std::size_t add_observable(const Observable& observable);
  /// Evaluates all observables at the present state, also inside an observer, and returns them with their extremes, for
  /// which this instant counts unless `counts` is false. The span is valid until the next call.
  std::span<const Observed> observe(bool counts = true);
  /// Evaluates others at the present state, without keeping them.
  std::vector<Observed> observe(std::span<const Observable> wanted);

  /// Verifies accelerations, multipliers and reactions at the present state, also inside an observer.
  Certificate certify();

  /// Saves the present state with all that the next step depends on and the counts of the report, also inside an
  /// observer. The bytes begin with the number of their format and end with a checksum; the rest is private.
  [[nodiscard]] std::vector<std::byte> save();
  /// Continues from saved bytes of a simulation of an equal System. Nothing is projected, checked against the
  /// constraints or started again. With equal options every later number is bit by bit that of the saved simulation,
  /// for every method and in either form (to rounding near a singular configuration or with dependent constraints,
  /// since ranks are decided again). Throws InputError for bytes that are damaged, cut off, of another format or of
  /// another system; the state is then unchanged.
  void restore(std::span<const std::byte> saved);
  /// Saves what a motion needs to continue beside positions and velocities, however its points are then spread over
  /// ranks. The bytes are the same on every rank except for counts of work and times. Later numbers agree to the
  /// tolerance, not bit by bit, and contacts with friction decide again whether they stick.
  [[nodiscard]] std::vector<std::byte> save_progress() const;
  /// Continues with `positions` and `velocities` [3n] of this simulation's points. Throws as `restore` does.
  void restore_progress(std::span<const std::byte> saved, std::span<const double> positions,
                        std::span<const double> velocities);
  [[deprecated("its name is save")]] std::vector<std::byte> snapshot() { return save(); }

  const System& system() const;  ///< the system as it was given
  const PlanSummary& plan() const;
  const Outcome& outcome() const;  ///< outcome of the start, the last advance_to or restore
  const MotionReport& report() const;
  double time() const;
  /// Returns the rank of K at the present state; see Dynamics::rank. On several ranks all call it together, and the
  /// rank and the degrees of freedom are those of the whole system.
  RankReport rank();

  /// Returns the present state as a value. Inside an observer accelerations and forces are computed again for it.
  Solution solution();
  /// Returns the friction force on each point at the present state, 3n, N; 0 where there is no friction.
  std::vector<double> friction_forces();

  // These functions return the results of the start, the last advance_to or restore, in the user's order. The spans are
  // valid until the next advance_to or restore.
  std::span<const double> coordinates() const;       ///< q as in SolveArrays; empty in normal form
  std::span<const double> coordinate_rates() const;  ///< q_dot
  std::span<const double> positions() const;         ///< 3n, m
  std::span<const double> velocities() const;        ///< 3n, m/s
  std::span<const double> accelerations() const;     ///< 3n, m/s^2
  std::span<const double> multipliers() const;       ///< d
  std::vector<double> self_stress() const;           ///< as in Solution
  std::span<const double> reactions() const;         ///< 3n, N: K lambda
  std::span<const double> support_forces() const;    ///< 3n, N: load that each support carries, 0 elsewhere

 private:
  struct TANOR_LOCAL Implementation;
  struct Spread {};
  Simulation(Spread, System system, const Part& part, const MotionOptions& motion, const SolverOptions& solver,
             double t_start);

  std::unique_ptr<Implementation> implementation_;
};

}  // namespace tanor
