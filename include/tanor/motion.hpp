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
#include <tanor/ranks.hpp>

namespace tanor {

enum class Method { Auto, Rk4, Dopri5, Dop853, Taylor, Rattle, Rattle4, Rattle6, Radau5, GeneralizedAlpha };

/// What a step of a method costs and keeps, measured in runs of chains, trees, clusters, nets and lattices; of taylor:
/// for each term of its series. Its use is to compare methods before a run (`tanor info`).
struct MethodCost {
  double solves = 0.0;          ///< with the factor of S (in coordinates: of H)
  double factorizations = 0.0;  ///< of S
  double projections = 0.0;     ///< most solves that projections onto the constraints add
  double bytes_a_point = 0.0, bytes_an_equation = 0.0, bytes_a_nonzero = 0.0;  ///< beside the state and the factor
};

/// One row of the table of methods.
struct MethodTraits {
  Method method = Method::Auto;
  std::string_view name;              ///< in scenes, on the command line and in reports
  std::string_view what;              ///< one line for a reader
  int order = 0;                      ///< of the error at the end of a run; 0: as the tolerance asks
  bool has_fixed_steps = false;       ///< it steps by `step`, whatever the error; the others follow a tolerance
  bool is_implicit = false;           ///< it solves the equations of a whole step: for stiff systems
  bool serves_friction = false;       ///< contacts with friction may be there
  bool steps_in_coordinates = false;  ///< the others step in positions and project onto the constraints
  bool is_compared = false;           ///< `tanor error-time` runs it unless others are named
  MethodCost cost{};
};

/// All methods of this version, auto first. Everything that names methods reads this table.
TANOR_API std::span<const MethodTraits> methods();
TANOR_API const MethodTraits& traits_of(Method method);
/// Throws InputError listing the methods of this version.
TANOR_API Method method_from_name(std::string_view name);
/// The word of a method in scenes and reports.
TANOR_API std::string_view name_of(Method method);
TANOR_API bool has_fixed_steps(Method method);

enum class Stabilisation { Projection, None };

struct MotionOptions {
  Method method = Method::Auto;  ///< auto: see choose_method
  double step = 0.0;             ///< s; fixed, or the first one to try where a tolerance rules; 0: none
  double max_step = 0.0;  ///< s; no step is longer, whatever the method; 0: none. For callables of the state that
                          ///< act for a short time only: no bound of them is known
  double rtol = 1e-8;     ///< relative to |r| and |v| of each point
  /// m and m/s; 0: 1e-10 of the length around each point, and of the speed there. Around it lies what constraints and
  /// springs join to it; the speed is the largest of those at the start and of a fall through that length.
  double atol = 0.0;
  Stabilisation stabilisation = Stabilisation::Projection;
  StartMode start = StartMode::Check;
  int order = 0;                 ///< taylor: terms of the series, 4 … 24; 0: as the tolerance asks
  double spectral_radius = 0.8;  ///< generalized_alpha: what a step leaves of the fastest oscillations, 0 … 1
};

/// A method and why `auto` stands for it; empty where it was asked for.
struct ChosenMethod {
  Method method = Method::Auto;
  std::string reason{};
};
/// What `auto` means for a system: generalized_alpha or radau5 where springs are too stiff for explicit steps (and
/// there is neither friction nor a step in coordinates), else rattle (in coordinates rk4) where a step is given, else
/// taylor where everything has a series in time, else dop853. A simulation goes over from these two to radau5 where it
/// finds that stability alone holds their steps short (MotionReport::method and method_reason say so).
TANOR_API ChosenMethod choose_method(const MotionOptions& options, const Dynamics& dynamics);

/// Kinetic and potential energy, J, and the work done since the start.
struct TANOR_API EnergyReport {
  double start = 0.0, now = 0.0;
  double kinetic = 0.0, potential = 0.0;  ///< now
  double potential_at_start = 0.0;
  double work_of_supports = 0.0;    ///< by moving supports and time-dependent constraints
  double work_of_forces = 0.0;      ///< by forces without potential: drag, damping, time-dependent ones
  double work_of_potentials = 0.0;  ///< of energies that depend on time: the integral of their explicit dU/dt
  double work_of_friction = 0.0;    ///< at contacts; on moving guides it may be positive
  /// Largest at any step of the kinetic energy, of the change of the potential energy since the start and of each of
  /// the works; at least 1e8 roundings of the energies themselves, since less cannot be told from them.
  double scale = 0.0;
  /// Largest |now - start - works| so far that is more than the tolerance leaves to velocities and positions, J, and
  /// when, s.
  double largest_drift = 0.0, largest_drift_time = 0.0;
  /// (now - start - works)/scale; 0 where nothing ever moved.
  double drift_relative() const;
};

/// Friction over all instants at which it was found. Laws that read no reaction (viscous) take no iteration.
struct FrictionSummary {
  std::size_t solves = 0;  ///< instants at which friction that depends on reactions was found
  double iterations_mean = 0.0;
  int iterations_max = 0;
  double contraction_max = 0.0;  ///< measured, see FrictionReport
  /// Largest one, N; NaN: not proven everywhere.
  double error_bound = std::numeric_limits<double>::quiet_NaN();
  Uniqueness uniqueness = Uniqueness::NotAsked;       ///< the weakest that was found
  FrictionMethod method_used = FrictionMethod::Auto;  ///< the strongest that was needed
  double residual_max = 0.0;                          ///< |tau(lambda) - tau| over the largest friction
  /// Instants, after steps and where contacts switched, at which several accelerations obeyed the law and the one
  /// nearest to the step before was taken; and the first of them, s (NaN: there was none).
  std::size_t several = 0;
  double first_several = std::numeric_limits<double>::quiet_NaN();
  std::string uniqueness_reason{};  ///< of the weakest that was found, where it is known
};

/// How far a motion left its constraints.
struct Violations {
  double position = 0.0;      ///< relative, as Dynamics::position_violation says it
  double velocity = 0.0;      ///< likewise, over the velocity scale
  double acceleration = 0.0;  ///< scaled residual |K'w + phi|
};

/// The place where a motion came nearest to a singular configuration.
struct NearestToSingular {
  double reciprocal_condition = 1.0;  ///< of the scaled S or H, the smallest after any step
  double time = 0.0;                  ///< s
};

/// How a motion went, from its start.
struct [[nodiscard]] MotionReport {
  Method method = Method::Auto;  ///< the one used
  std::string method_reason{};   ///< why, where `auto` chose it
  double time = 0.0;             ///< reached, s
  std::size_t steps = 0, rejected = 0;
  double last_step = 0.0;
  /// Why the motion may be less exact than asked for though nothing failed, and when first: the absolute tolerance is
  /// coarse, one fixed step turns the motion by more than 0.4 rad, steps pass something over, the energy drifts by more
  /// of its scale than the method should let it (fixed steps: 1e-2; a tolerance: 1e4 rtol, between 1e-4 and 1e-2), or
  /// the tolerance lies below the rounding of the forces. A drift counts beside all that flows: the warning is taken
  /// back where much more flows later. Empty: nothing speaks against it.
  std::string accuracy_warning{};
  std::size_t events = 0;   ///< instants at which the equations changed: a contact began or ceased to slip
  double last_event = 0.0;  ///< s, the last of them
  StartReport start;
  Violations violation;       ///< the largest after any of its steps
  Violations last_violation;  ///< after the last step
  NearestToSingular nearest_to_singular;
  double last_reciprocal_condition = 1.0;  ///< of the scaled S or H, after the last step
  RankChanges rank_changes;                ///< since the start
  SingularPassages singular_passages;      ///< in the order of time
  EnergyReport energy;
  FrictionSummary friction;
  Counters counters;
  PhaseTimes times;
};

/// A function of the motion whose passages through 0 are looked for.
struct Event {
  enum class Direction { Both, Rising, Falling };

  std::string name{};
  /// Of t, r [3n] and v [3n] in the user's order; smooth where it vanishes.
  std::function<double(double t, std::span<const double> r, std::span<const double> v)> value{};
  Direction direction = Direction::Both;
  bool stops = false;  ///< ends the advance there
};

/// One of them, to the accuracy of the method inside its steps.
struct Passage {
  std::size_t event = 0;  ///< as `add_event` numbered it
  double time = 0.0;      ///< s
  bool rises = false;
};

/// A system on its way through time.
class TANOR_API Simulation {
 public:
  /// Makes the start consistent (StartMode); throws InputError for bad input. A numerical failure is in `outcome()`.
  explicit Simulation(System system, MotionOptions motion = {}, SolverOptions solver = {}, double t_start = 0.0);
  /// One rank's part of a system that is spread over several (see ranks.hpp). Every rank has the same options and makes
  /// every call, in the same order: all make the same steps, and the report's steps, violations and energies are those
  /// of the whole. Arrays are of the part; those of guests follow their owners. An event's value is the sum of what the
  /// functions of all ranks return. Certificates and ranks of K are of the part alone; where islands lie on several
  /// ranks there are none.
  template <std::same_as<Part> OwnPart>  // so that {} in its place means options
  Simulation(System system, const OwnPart& part, MotionOptions motion = {}, SolverOptions solver = {},
             double t_start = 0.0)
      : Simulation(Spread{}, std::move(system), part, motion, solver, t_start) {}
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;
  ~Simulation();

  /// Called after every step; return false to stop there.
  using Observer = std::function<bool(const MotionReport&)>;

  /// Steps to exactly t_end (> time()), or to an event that stops; on a failure the state stays at the last good step.
  Outcome advance_to(double t_end, const Observer& observer = {});
  [[deprecated("its name is advance_to")]] Outcome advance(double t_end, const Observer& observer = {}) {
    return advance_to(t_end, observer);
  }

  /// From now on looks for the event; returns its number. Each step evaluates the function at both ends and at three
  /// places between: two passages between neighbouring ones are missed. One that begins at 0 does not pass there. Where
  /// a step is extrapolated past a singular configuration, an event that stops ends the advance at the end of that
  /// step, and its passage is reported at its own time. A value that is not finite ends the advance with an outcome
  /// that names the event. Events are no part of a snapshot. Throws InputError where there is no function.
  std::size_t add_event(Event event);
  /// So far, in the order of time.
  std::span<const Passage> passages() const;

  /// Proves accelerations, multipliers and reactions at the present state, also inside an observer.
  Certificate certify();

  /// The present state with all that the next step depends on and the counts of the report, also inside an observer.
  /// The bytes begin with the number of their format and end with a checksum; what else they hold is not for others.
  [[nodiscard]] std::vector<std::byte> save();
  /// Goes on from saved bytes of a simulation of an equal System: nothing is projected, checked against the constraints
  /// or started anew. With equal options every later number is that of the simulation they were taken from, bit by bit,
  /// for every method and in either form (near a singular configuration and where constraints depend on each other: up
  /// to rounding, since ranks are decided anew). Throws InputError for bytes that are damaged, cut off, of another
  /// format or of another system; the state is then what it was.
  void restore(std::span<const std::byte> saved);
  /// What a motion needs to go on beside positions and velocities, however its points are spread over ranks then; the
  /// same on every rank but for counts of work and times. Later numbers agree to the tolerance, not bit by bit, and
  /// contacts with friction choose anew whether they stick.
  [[nodiscard]] std::vector<std::byte> save_progress() const;
  /// `positions`, `velocities` [3n] of this simulation's points. Throws as `restore` does.
  void restore_progress(std::span<const std::byte> saved, std::span<const double> positions,
                        std::span<const double> velocities);
  [[deprecated("its name is save")]] std::vector<std::byte> snapshot() { return save(); }

  const System& system() const;  ///< as it was given
  const PlanSummary& plan() const;
  const Outcome& outcome() const;  ///< of the start, the last advance_to or restore
  const MotionReport& report() const;
  double time() const;
  /// At the present state; see Dynamics::rank.
  RankReport rank();

  /// The present state as a value. Inside an observer accelerations and forces are found anew for it.
  Solution solution();
  /// N, 3n: what friction does to each point at the present state; 0 where there is none.
  std::vector<double> friction_forces();

  // What the start, the last advance_to or restore ended with, in the user's order; valid until the next one.
  std::span<const double> coordinates() const;       ///< q as in SolveArrays; empty in normal form
  std::span<const double> coordinate_rates() const;  ///< q_dot
  std::span<const double> positions() const;         ///< 3n, m
  std::span<const double> velocities() const;        ///< 3n, m/s
  std::span<const double> accelerations() const;     ///< 3n, m/s^2
  std::span<const double> multipliers() const;       ///< d
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
