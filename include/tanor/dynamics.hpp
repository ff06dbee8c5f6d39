#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <tanor/certificate.hpp>
#include <tanor/solver_options.hpp>
#include <tanor/system.hpp>

namespace tanor {

/// Seconds spent, by phase.
struct PhaseTimes {
  double evaluate = 0.0, assemble = 0.0, factor = 0.0, solve = 0.0, friction = 0.0;
};

/// Work done so far by a Dynamics or a Simulation.
struct Counters {
  std::size_t evaluations = 0, factorizations = 0, solves = 0;
  std::size_t iterations = 0;            ///< conjugate gradient iterations in solves without a factor of their own
  std::size_t split_factorizations = 0;  ///< factorizations of Gamma and G, which only the split needs
  std::size_t rank_decisions = 0;        ///< rank decisions by QR, made where S raised a suspicion
  std::size_t friction_solves = 0;       ///< instants at which friction was found
  std::size_t friction_iterations = 0;   ///< solves with the factor of S for friction
};

/// Results of the planning, made before any number is computed.
struct TANOR_API PlanSummary {
  Form form = Form::Normal;  ///< form that steps and answers, Normal or Tangent
  std::size_t points = 0, supports = 0, equations = 0, coordinates = 0, islands = 0;
  std::size_t parts = 0;             ///< groups of islands with a factor of their own
  std::size_t pattern_nonzeros = 0;  ///< in the lower triangle of S or H
  std::size_t factor_nonzeros = 0;   ///< in the factor L
  double factor_flops = 0.0;         ///< for one numeric factorization
  double normal_flops = 0.0;         ///< predicted for one evaluation and solve in normal form; 0 if not made
  double tangent_flops = 0.0;        ///< the same in tangent form
  /// Solvers of S lambda = -b (of H q_ddot = … in tangent form), each for some islands.
  std::vector<LinearSolver> linear_solvers{LinearSolver::General};
  std::string linear_solver_reason;           ///< reason for this choice
  std::vector<Ordering> orderings;            ///< orderings of the sparse factors
  std::vector<Factorization> factorizations;  ///< methods of the sparse factors; empty if there are none
  std::vector<std::string> left_out;          ///< parts of the method that this system does not need
  /// Points that a Simulation turned into supports, see RankReport::prestress_rigid_points.
  std::vector<Index> prestress_rigid_points;
  std::vector<std::size_t> prestress_rigid_equations;  ///< the rods between them and supports
  /// Rows (user's order) that join supports alone. They are no part of S, and their multiplier is 0.
  std::vector<std::size_t> idle_equations;

  // These functions return the names of the lists above, joined by '+'.
  std::string linear_solver() const;  ///< "batches+general"
  std::string ordering() const;       ///< "amd+natural"; "none" if nothing is factorized
  std::string factorization() const;  ///< "simplicial", "none", or the linear solver
};

/// Knowledge about the uniqueness of the friction (41) of a state.
enum class Uniqueness {
  NotAsked,
  Proven,    ///< the motion is unique: rho(|S^-1 C|) < 1, or all modes of stick and slip were tried
  Unproven,  ///< one solution was found; others may exist
  Several,   ///< refused at a start; during a run the solution nearest to the previous step is taken
  None
};

/// Friction at one instant.
struct [[nodiscard]] FrictionReport {
  std::size_t contacts = 0, sticking = 0;
  /// Evaluations of the law, each with one solve by the factor of S; steps for Newton's method.
  int iterations = 0;
  double contraction = 0.0;  ///< measured factor by which an iteration of (43) shortens the distance
  double residual = 0.0;     ///< |tau(lambda) - tau| over the largest friction
  /// Error bound of the friction, N: |F(x) - x|/(1 - L) if a contraction constant L < 1 is proven, else NaN.
  double error_bound = std::numeric_limits<double>::quiet_NaN();
  Uniqueness uniqueness = Uniqueness::NotAsked;
  std::string uniqueness_reason{};  ///< reason if uniqueness is unproven, where known
  /// True if the sticking contacts are redundant, so that the load could be shared otherwise. A share that obeys the
  /// law is taken (docs/friction.md). The accelerations are unique nevertheless.
  bool sticking_is_indeterminate = false;
  FrictionMethod method_used = FrictionMethod::Auto;  ///< Auto if no friction depends on reactions
};

/// Quality of the last solve.
struct [[nodiscard]] SolveReport {
  Outcome outcome;
  /// Largest |K'w + phi| over its largest term; in tangent form the last relative correction of w.
  double residual = 0.0;
  double reciprocal_condition = 1.0;  ///< CHOLMOD's cheap estimate for the scaled S or H; smallest of all parts
  int refinements = 0;
  /// For Form::Both, the largest relative difference of w and of eta between the two forms; else NaN.
  double forms_disagreement = std::numeric_limits<double>::quiet_NaN();
  FrictionReport friction;
};

/// An equation whose gradient is a combination of others. It is redundant if it agrees with them.
struct RowDependence {
  struct Term {
    std::size_t row;
    double coefficient;  ///< for gradients scaled to unit length in the norm of M^-1
  };
  std::size_t row = 0;      ///< user's order
  std::vector<Term> terms;  ///< largest first; empty for a row that joins supports alone
  std::string what;         ///< "rods[17] depends on rods[3], rods[9]"
};

/// The rank of K at one configuration.
struct [[nodiscard]] RankReport {
  bool is_known = true;  ///< false if the system has coordinates alone and no equation
  std::size_t rank = 0;
  std::size_t degrees_of_freedom = 0;  ///< 3(n - supports) - rank, or the number of coordinates if these stand alone
  std::vector<RowDependence> dependences;  ///< one for each equation that the rank lacks
  /// [d] False if other multipliers give the same reactions; the minimum-norm ones are then reported.
  std::vector<bool> multipliers_unique;
  /// Points held rigid by prestress: tensioned rods join them to fixed supports, so that they can never move, although
  /// K'w = -phi alone would let them. Dynamics answers by K alone. A Simulation that starts in such a state turns these
  /// points into supports (PlanSummary::prestress_rigid_points).
  std::vector<Index> prestress_rigid_points;
  /// The value for the independent unit gradients; 0 if nothing was suspected, so that it was not computed.
  double smallest_singular_value = 0.0;
};

/// A step of a motion after which the rank of K differs from the one before.
struct RankChange {
  double time = 0.0;     ///< s
  std::size_t rank = 0;  ///< rank from then on
};
struct RankChanges {
  static constexpr std::size_t most_kept = 100;
  std::size_t start = 0, now = 0;  ///< rank at the start and after the last step
  std::vector<RankChange> first;   ///< the first `most_kept`
  std::size_t count = 0;
};

/// A passage of the motion through, or very near to, a configuration where K loses rank.
struct SingularPassage {
  double time = 0.0;                  ///< s
  double reciprocal_condition = 0.0;  ///< smallest one of S after a step of the passage
};
struct SingularPassages {
  static constexpr std::size_t most_kept = 100;
  std::vector<SingularPassage> first;  ///< the first `most_kept`
  std::size_t count = 0;
};

/// Changes of a constraint that acts to one side.
enum class ContactChange {
  Snap,     ///< a rope, or another one that joins points, becomes taut with an impact
  Slack,    ///< it carries nothing from now on
  Touch,    ///< a point meets a guide with an impact
  LiftOff,  ///< it leaves the guide
  Zeno,     ///< bounces that follow ever faster are taken to have ended: the row closes without another one
  Stick,    ///< a contact with friction ceases to slide
  Slip,     ///< it begins to slide, or slides back
  Jam,      ///< its friction allows no accelerations while it slides: an impulse without a collision ends the slide
};

/// A change of some constraints to one side at one instant.
struct ContactEvent {
  double time = 0.0;  ///< s
  ContactChange change = ContactChange::Touch;
  bool restitution_capped = false;  ///< with friction the given restitution would feed energy; a part of it was taken
  std::vector<std::size_t>
      equations{};                     ///< in the user's numbers, those of the change first, then others that take part
  std::vector<double> impulses{};      ///< N s, >= 0, of each of them; empty if they have none
  std::vector<double> rates_before{};  ///< m/s: the speed at which each gap closed
  double energy_lost = 0.0;            ///< J, by the impact; negative where what moves by itself puts in more
};

struct [[nodiscard]] ProjectionReport {
  Outcome outcome;
  double correction = 0.0;  ///< largest move of a point (m or m/s)
  double violation = 0.0;   ///< relative violation after the projection
  int iterations = 0;
};

enum class StartMode {
  Check,  ///< accepts errors up to 1e-3 of the length and velocity scale; larger ones are an InputError
  /// Projects onto the nearest admissible start in the M-norm, however far; where rows contradict each other to first
  /// order alone, as in a straight chain that is longer than its gap, onto one where it hangs nearly as at rest.
  Project
};

struct [[nodiscard]] StartReport {
  Outcome outcome;
  double position_correction = 0.0, velocity_correction = 0.0;  ///< largest move of a point, m and m/s
  /// The larger of both corrections, relative to the scene's size and velocity scale.
  double relative = 0.0;
};

/// Positions and velocities of a system in a host's own arrays, which a call reads.
struct StateView {
  double time = 0.0;                     ///< s
  std::span<const double> positions{};   ///< 3n, m
  std::span<const double> velocities{};  ///< 3n, m/s; empty at rest
};

/// The same for a call that also writes.
struct MutableState {
  double time = 0.0;               ///< s
  std::span<double> positions{};   ///< 3n, m
  std::span<double> velocities{};  ///< 3n, m/s
};

/// Velocities that a call writes, and the positions that they belong to.
struct MutableVelocities {
  double time = 0.0;                    ///< s
  std::span<const double> positions{};  ///< 3n, m
  std::span<double> velocities{};       ///< 3n, m/s
};

/// A host's own arrays for what `Dynamics::solve` finds. An empty one is not computed. After a failure the
/// accelerations have no meaning; the others are as they were.
struct SolveArrays {
  std::span<double> accelerations{};    ///< 3n, m/s^2: w (25); the prescribed ones at supports
  std::span<double> multipliers{};      ///< [equations]: Lagrange multipliers lambda = eta^(xi) (31)
  std::span<double> reactions{};        ///< 3n, N: eta = K lambda (23), also at supports
  std::span<double> support_forces{};   ///< 3n, N: the load that each support carries (K lambda + f there), else 0
  std::span<double> active_forces{};    ///< 3n, N: f
  std::span<double> friction_forces{};  ///< 3n, N: tau of sliding contacts, and the holding forces of sticking ones
  // q, q_dot and q_ddot, `plan().coordinates` numbers each if the tangent form answers, else none. They stand entry by
  // entry, member by member, as `System::coordinates` lists them. Charts are centred at the present configuration:
  // spheres, directions and rotations have q = 0 there.
  std::span<double> coordinates{};
  std::span<double> coordinate_rates{};
  std::span<double> coordinate_accelerations{};
};

/// A state with all results that belong to it, as a value that stays the same when the motion goes on. Arrays are in
/// the user's order.
struct [[nodiscard]] Solution {
  Outcome outcome;                                 ///< if not ok, accelerations, multipliers and forces are 0
  double time = 0.0;                               ///< s
  std::vector<double> positions, velocities;       ///< 3n, m and m/s
  std::vector<double> accelerations;               ///< 3n, m/s^2
  std::vector<double> multipliers;                 ///< [equations], N for constraints that are lengths
  std::vector<double> reactions, support_forces;   ///< 3n, N: K lambda; the load that each support carries
  std::vector<double> coordinates;                 ///< q as in SolveArrays; empty in normal form
  std::vector<double> coordinate_rates;            ///< q_dot
  double position_violation = 0.0;                 ///< largest |xi|/|gradient|/length
  std::size_t degrees_of_freedom = 0;              ///< 3(n - supports) - rank K of the rows that act
  std::vector<std::size_t> first_row, row_counts;  ///< [group of constraints] first equation; equations per member
  /// [equations] A state of self-stress: multipliers that act on no point that moves, with a part in each one that is
  /// not unique; any multiple may be added. Empty if all are unique.
  std::vector<double> self_stress;
  bool has_prestress = false;  ///< multipliers that are NaN, and forces with them, are left to a prestress

  /// Returns the same state for another call.
  StateView state() const { return {.time = time, .positions = positions, .velocities = velocities}; }
  /// Returns the largest relative violation of a constraint, |xi|/|gradient|/length.
  double violation() const { return position_violation; }
  /// Returns a position, m. This and the next five functions throw InputError if there is no such point, member or
  /// equation.
  Vector3 position(Point point) const { return vector_of(positions, point); }
  Vector3 velocity(Point point) const { return vector_of(velocities, point); }
  Vector3 acceleration(Point point) const { return vector_of(accelerations, point); }
  /// Returns the force of the constraints on the point, N.
  Vector3 reaction(Point point) const { return vector_of(reactions, point); }
  /// Returns the load that a support carries, N.
  Vector3 load(Point support) const { return vector_of(support_forces, support); }
  /// Returns lambda of the k-th equation of a member. Throws InputError if there is none.
  TANOR_API double multiplier(const Member& member, std::size_t k = 0) const;
  /// Returns the tension of a rod, -lambda, N; it is negative in a rod that pushes.
  double tension(const Member& rod) const { return -multiplier(rod); }

 private:
  TANOR_API static Vector3 vector_of(const std::vector<double>& array, Point point);
};

/// The Euclidean split u = u_T + u_N by the projectors (15), (16), 3n each, in the user's order; 0 at supports.
struct [[nodiscard]] Split {
  Outcome outcome;
  std::vector<double> tangent_accelerations, normal_accelerations;  ///< w_T (19), w_N (21), (22), m/s^2
  std::vector<double> tangent_forces, normal_forces;                ///< f_T, f_N, N
  std::vector<double> tangent_friction, normal_friction;            ///< tau_T, tau_N, N
  /// Measure of how far M maps N out of itself: the largest |(I - K Gamma^-1 K') M^-1 K x| over |M^-1 K x| for a random
  /// x (with A, the same for T). If it is at rounding, (44) K'M^-1 A = 0 holds here: w_T = M^-1 f_T, and each half of
  /// (18) stands alone.
  double mass_coupling = 0.0;
};

/// The part of the reactions that is due to one cause.
struct ReactionPart {
  std::string cause;                ///< name of a force, "friction", "inertia" or "drive"
  std::vector<double> multipliers;  ///< part of lambda, [equations]
  std::vector<double> reactions;    ///< part of eta, 3n, N; at supports the forces of the constraints there
};

struct [[nodiscard]] ReactionsByCause {
  Outcome outcome;
  std::vector<ReactionPart> parts;
};

/// Friction by the paper's own three blocks (43), which verifies the smallest form (*) that `solve` uses:
///
///   eta^(xi) = S^-1 K'[w_N - M^-1(f + A tau^(q))] - tau^(xi),   A tau^(q) = tau_T,   tau^(xi) = Gamma^-1 K' tau
struct [[nodiscard]] FrictionBlocks {
  Outcome outcome;
  std::vector<double> multipliers;  ///< eta^(xi) [equations]
  std::vector<double> friction;     ///< tau [3n], N
  int iterations = 0;               ///< iterations of the plain fixed point
  /// True if (44) holds here, so that the block of tau^(q) drops out of the first equation.
  bool tangent_block_left_out = false;
};

/// Forward dynamics in normal or tangent form: accelerations and reactions of a system at one instant. (The paper calls
/// this the *inverse problem*. Its *direct problem* is what the field calls inverse dynamics, see InverseDynamics.)
///
/// All arrays are the host's own: point by point, 3n doubles, in the user's order. Rows of multipliers follow the order
/// of `num_equations`. Supports keep their rows, where the prescribed motion replaces positions and velocities. An
/// array of another size is an InputError that names it.
///
/// Each call refers to the state that it is given. A call at the state of the last one reuses the factor and the
/// friction found there and solves nothing again, unless that one was a `solve` for accelerations and multipliers
/// alone. Not thread-safe; use one object per host thread.
class TANOR_API Dynamics {
 public:
  /// Validates the system; throws InputError.
  explicit Dynamics(System system, SolverOptions options = {});
  Dynamics(Dynamics&&) noexcept;
  Dynamics& operator=(Dynamics&&) noexcept;
  ~Dynamics();

  const System& system() const;  ///< the system as it was given
  std::size_t num_points() const;
  std::size_t num_equations() const;
  const PlanSummary& plan() const;
  /// Returns why there is no series in time, which the method taylor needs, and names what has none; empty if there is
  /// one.
  std::string series_obstacle() const;

  /// Computes accelerations, multipliers and reactions at a state and fills the wanted arrays.
  SolveReport solve(const StateView& at, const SolveArrays& wanted = {});
  /// Returns the same as a value.
  Solution solution(const StateView& at);

  /// Computes the split: w_N = -K Gamma^-1 phi (21), f_N = K Gamma^-1 K'f, or, without constraints,
  /// w_N = (I - A G^-1 A') psi (22), f_T = A G^-1 A'f. Gamma and G are planned in the first call and factorized in each
  /// call; if all masses are equal, Gamma = m S (36) needs no factor of its own.
  Split split(const StateView& at);

  /// Decomposes the reactions by cause: the forces in their order, then "friction" if there is some (of sliding
  /// contacts; sticking ones count as held), "inertia" (the part of phi quadratic in v) and, if something is driven,
  /// "drive" (xi_t and the accelerations of supports). It takes one factor of S or H and one solve for each cause. The
  /// parts add up to lambda and eta. Without constraints only eta is known.
  ReactionsByCause reactions_by_cause(const StateView& at);

  /// Finds the friction again by (43) as printed, starting from zero friction. Throws InputError if there is no
  /// friction.
  FrictionBlocks friction_by_blocks(const StateView& at);

  /// Returns the rank of K, decided if S = K'M^-1K raised a suspicion, else d. With `thoroughly` it is decided in any
  /// case.
  RankReport rank(const StateView& at, bool thoroughly = false);

  /// Verifies accelerations, multipliers and reactions at a state by identities and by second methods for the same
  /// numbers. It solves for them first unless the last solve found all of them there. The cost is about that of ten
  /// solves.
  Certificate certify(const StateView& at);

  /// Finds the nearest r on xi(r, t) = 0 in the M-norm by Newton's method from the given one. Velocities take no part.
  ProjectionReport project_positions(const MutableState& state);
  /// Finds the nearest v with K'v + xi_t = 0 in the M-norm; K is that of the given positions, which should be
  /// admissible and stay as they are.
  ProjectionReport project_velocities(const MutableVelocities& state);

  /// Makes a start consistent by correcting positions and velocities. StartMode::Check throws InputError naming the
  /// worst constraint.
  StartReport start(const MutableState& state, StartMode mode);

  /// Returns the largest relative violation of a constraint by positions, |xi|/|gradient|/length.
  [[nodiscard]] double position_violation(const StateView& at);
  /// Returns the largest relative violation by velocities, |K'v + xi_t|/|gradient|/velocity scale.
  [[nodiscard]] double velocity_violation(const StateView& at);

  // The following overloads are those of version 0.1. Calls that referred to "the last solve" now take its state
  // (docs/from-0.1.md).
  // clang-format off
  [[deprecated("takes {.time, .positions, .velocities}, {.accelerations, .multipliers, .reactions}")]]
  SolveReport solve(double t, std::span<const double> r, std::span<const double> v, std::span<double> w,
                    std::span<double> lambda = {}, std::span<double> eta = {}) {
    return solve({.time = t, .positions = r, .velocities = v},
                 {.accelerations = w, .multipliers = lambda, .reactions = eta});
  }
  [[deprecated("takes {.time, .positions}")]]
  ProjectionReport project_positions(double t, std::span<double> r) {
    return project_positions({.time = t, .positions = r});
  }
  [[deprecated("takes {.time, .positions, .velocities}")]]
  ProjectionReport project_velocities(double t, std::span<const double> r, std::span<double> v) {
    return project_velocities({.time = t, .positions = r, .velocities = v});
  }
  [[deprecated("takes {.time, .positions, .velocities}, mode")]]
  StartReport start(double t, std::span<double> r, std::span<double> v, StartMode mode) {
    return start({.time = t, .positions = r, .velocities = v}, mode);
  }
  [[deprecated("takes {.time, .positions, .velocities}")]]
  Solution solution(double t, std::span<const double> r, std::span<const double> v) {
    return solution({.time = t, .positions = r, .velocities = v});
  }
  [[deprecated("takes {.time, .positions}")]]
  double position_violation(double t, std::span<const double> r) {
    return position_violation({.time = t, .positions = r});
  }
  [[deprecated("takes {.time, .positions, .velocities}")]]
  double velocity_violation(double t, std::span<const double> r, std::span<const double> v) {
    return velocity_violation({.time = t, .positions = r, .velocities = v});
  }
  // clang-format on

  PhaseTimes phase_times() const;
  Counters counters() const;

 private:
  struct TANOR_LOCAL Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace tanor
