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
  std::size_t iterations = 0;            ///< of conjugate gradients, in solves without a factor of their own
  std::size_t split_factorizations = 0;  ///< of Gamma and G: none where nobody asks for the split
  std::size_t rank_decisions = 0;        ///< by QR, where S raised a suspicion
  std::size_t friction_solves = 0;       ///< instants at which friction was found …
  std::size_t friction_iterations = 0;   ///< … and the solves with the factor of S that it took
};

/// What the plan found out about a system before any number was computed.
struct TANOR_API PlanSummary {
  Form form = Form::Normal;  ///< that steps and answers: Normal or Tangent
  std::size_t points = 0, supports = 0, equations = 0, coordinates = 0, islands = 0;
  std::size_t parts = 0;             ///< groups of islands with a factor of their own
  std::size_t pattern_nonzeros = 0;  ///< of the lower triangle of S, or H
  std::size_t factor_nonzeros = 0;   ///< of L
  double factor_flops = 0.0;         ///< of one numeric factorization
  double normal_flops = 0.0;         ///< predicted, of one evaluation and solve in normal form; 0: not made
  double tangent_flops = 0.0;        ///< likewise in tangent form
  /// What solves S lambda = -b (H q_ddot = … in tangent form), each for some islands.
  std::vector<LinearSolver> linear_solvers{LinearSolver::General};
  std::string linear_solver_reason;           ///< why these
  std::vector<Ordering> orderings;            ///< used by sparse factors
  std::vector<Factorization> factorizations;  ///< of sparse factors; empty: there are none
  std::vector<std::string> left_out;          ///< what this system does not need
  /// Points that a Simulation turned into supports, see RankReport::prestress_rigid_points.
  std::vector<Index> prestress_rigid_points;
  std::vector<std::size_t> prestress_rigid_equations;  ///< the rods between them and supports
  std::vector<std::size_t>
      idle_equations;  ///< rows (user's order) that join supports alone: no part of S, multiplier 0

  // The names of the lists above, joined by '+'.
  std::string linear_solver() const;  ///< "batches+general"
  std::string ordering() const;       ///< "amd+natural"; "none" where nothing is factorized
  std::string factorization() const;  ///< "simplicial", "none", or the linear solver
};

/// What is known about the friction (41) that belongs to a state.
enum class Uniqueness {
  NotAsked,
  Proven,    ///< one motion: rho(|S^-1 C|) < 1, or all modes of stick and slip were tried
  Unproven,  ///< one was found; nothing says that there is no other
  Several,   ///< refused at a start; in a run the one nearest to the step before is taken
  None
};

/// Friction at one instant.
struct FrictionReport {
  std::size_t contacts = 0, sticking = 0;
  int iterations = 0;        ///< evaluations of the law, one solve with the factor of S each; of Newton's method, steps
  double contraction = 0.0;  ///< measured: by how much an iteration of (43) shortened the distance
  double residual = 0.0;     ///< |tau(lambda) - tau| over the largest friction
  /// On the friction, N: |F(x) - x|/(1 - L) where a contraction constant L < 1 is proven; else NaN.
  double error_bound = std::numeric_limits<double>::quiet_NaN();
  Uniqueness uniqueness = Uniqueness::NotAsked;
  std::string uniqueness_reason{};  ///< why it is unproven; empty where nothing more is known
  /// Contacts that stick hold more than can move: the load could be shared otherwise. A share that obeys the law is
  /// taken (docs/friction.md); accelerations are unique all the same.
  bool sticking_is_indeterminate = false;
  FrictionMethod method_used = FrictionMethod::Auto;  ///< Auto: no friction depends on reactions
};

/// Quality of the last solve.
struct [[nodiscard]] SolveReport {
  Outcome outcome;
  double residual = 0.0;  ///< max |K'w + phi| over its largest term; tangent form: last correction of w, relative
  double reciprocal_condition = 1.0;  ///< of the scaled S or H, CHOLMOD's cheap estimate; smallest over the parts
  int refinements = 0;
  /// Form::Both: largest relative difference of w, and of eta, between the two forms; else NaN.
  double forms_disagreement = std::numeric_limits<double>::quiet_NaN();
  FrictionReport friction;
};

/// An equation whose gradient is a combination of others': redundant where it agrees with them.
struct RowDependence {
  struct Term {
    std::size_t row;
    double coefficient;  ///< of gradients scaled to unit length in the norm of M^-1
  };
  std::size_t row = 0;      ///< user's order
  std::vector<Term> terms;  ///< largest first; none: it joins supports alone
  std::string what;         ///< "rods[17] depends on rods[3], rods[9]"
};

/// The rank of K at one configuration.
struct [[nodiscard]] RankReport {
  bool is_known = true;  ///< false: coordinates alone say what can move, no equation is written down
  std::size_t rank = 0;
  std::size_t degrees_of_freedom = 0;      ///< 3(n - supports) - rank; as many as coordinates where these stand alone
  std::vector<RowDependence> dependences;  ///< one for each equation that the rank lacks
  std::vector<bool> multipliers_unique;    ///< [d] false: others give the same reactions; the smallest are reported
  /// Points held rigid by prestress: rods under tension join them to fixed supports, so that they cannot move, now or
  /// later, though K'w = -phi alone would let them. Dynamics answers by K alone. A Simulation that starts so turns them
  /// into supports (PlanSummary::prestress_rigid_points).
  std::vector<Index> prestress_rigid_points;
  double smallest_singular_value = 0.0;  ///< of the independent unit gradients; 0: nothing was suspected, not computed
};

/// A step of a motion after which the rank of K was another one.
struct RankChange {
  double time = 0.0;     ///< s
  std::size_t rank = 0;  ///< from then on
};
struct RankChanges {
  static constexpr std::size_t most_kept = 100;
  std::size_t start = 0, now = 0;  ///< rank at the start and after the last step
  std::vector<RankChange> first;   ///< the first `most_kept`
  std::size_t count = 0;
};

/// The motion went through a configuration where K loses rank, or came very near to one.
struct SingularPassage {
  double time = 0.0;                  ///< s
  double reciprocal_condition = 0.0;  ///< of S: smallest met after a step on the way there
};
struct SingularPassages {
  static constexpr std::size_t most_kept = 100;
  std::vector<SingularPassage> first;  ///< the first `most_kept`
  std::size_t count = 0;
};

struct [[nodiscard]] ProjectionReport {
  Outcome outcome;
  double correction = 0.0;  ///< largest move of a point (m or m/s)
  double violation = 0.0;   ///< after the projection, relative
  int iterations = 0;
};

enum class StartMode {
  Check,   ///< correct up to 1e-3 of the length and velocity scale; more is an InputError
  Project  ///< nearest admissible start in the M-norm, however far
};

struct [[nodiscard]] StartReport {
  Outcome outcome;
  double position_correction = 0.0, velocity_correction = 0.0;  ///< largest move of a point, m and m/s
  double relative = 0.0;  ///< the larger of both over the scene's size and velocity scale
};

/// Where a system is and how it moves: a host's own arrays, which a call reads.
struct StateView {
  double time = 0.0;                     ///< s
  std::span<const double> positions{};   ///< 3n, m
  std::span<const double> velocities{};  ///< 3n, m/s; empty: at rest
};

/// The same where a call writes, too.
struct MutableState {
  double time = 0.0;               ///< s
  std::span<double> positions{};   ///< 3n, m
  std::span<double> velocities{};  ///< 3n, m/s
};

/// Velocities that a call writes, and where they are.
struct MutableVelocities {
  double time = 0.0;                    ///< s
  std::span<const double> positions{};  ///< 3n, m
  std::span<double> velocities{};       ///< 3n, m/s
};

/// A host's own arrays for what `Dynamics::solve` finds. An empty one is not computed.
struct SolveArrays {
  std::span<double> accelerations{};    ///< 3n, m/s^2: w (25); at supports the prescribed one
  std::span<double> multipliers{};      ///< [equations]: lambda = eta^(xi) (31)
  std::span<double> reactions{};        ///< 3n, N: eta = K lambda (23), also at supports
  std::span<double> support_forces{};   ///< 3n, N: the load that each support carries (K lambda + f there), else 0
  std::span<double> active_forces{};    ///< 3n, N: f
  std::span<double> friction_forces{};  ///< 3n, N: tau of contacts that slide, and what holds those that stick
  // q, q_dot, q_ddot, `plan().coordinates` numbers each where the tangent form answers, else none. They stand entry by
  // entry, member by member, as `System::coordinates` lists them. Charts are centred at the present configuration:
  // spheres, directions and rotations have q = 0 there.
  std::span<double> coordinates{};
  std::span<double> coordinate_rates{};
  std::span<double> coordinate_accelerations{};
};

/// A state with all that belongs to it, as a value: it stays what it is when the motion goes on. Arrays are in the
/// user's order.
struct [[nodiscard]] Solution {
  Outcome outcome;                                 ///< not ok: accelerations, multipliers and forces are 0
  double time = 0.0;                               ///< s
  std::vector<double> positions, velocities;       ///< 3n, m and m/s
  std::vector<double> accelerations;               ///< 3n, m/s^2
  std::vector<double> multipliers;                 ///< [equations], N for constraints that are lengths
  std::vector<double> reactions, support_forces;   ///< 3n, N: K lambda; the load that each support carries
  std::vector<double> coordinates;                 ///< q as in SolveArrays; empty in normal form
  std::vector<double> coordinate_rates;            ///< q_dot
  double position_violation = 0.0;                 ///< largest |xi|/|gradient|/length
  std::vector<std::size_t> first_row, row_counts;  ///< [group of constraints] first equation; equations a member

  /// The same state for another call.
  StateView state() const { return {.time = time, .positions = positions, .velocities = velocities}; }
  /// Largest relative violation of a constraint, |xi|/|gradient|/length.
  double violation() const { return position_violation; }
  /// m. This and the next five throw InputError where there is no such point, member or equation.
  Vector3 position(Point point) const { return vector_of(positions, point); }
  Vector3 velocity(Point point) const { return vector_of(velocities, point); }
  Vector3 acceleration(Point point) const { return vector_of(accelerations, point); }
  /// N: what the constraints do to the point.
  Vector3 reaction(Point point) const { return vector_of(reactions, point); }
  /// N: what a support carries.
  Vector3 load(Point support) const { return vector_of(support_forces, support); }
  /// lambda of a member, of its k-th equation. Throws InputError where there is none.
  TANOR_API double multiplier(const Member& member, std::size_t k = 0) const;
  /// N: what a rod pulls with, -lambda; negative where it pushes.
  double tension(const Member& rod) const { return -multiplier(rod); }

 private:
  TANOR_API static Vector3 vector_of(const std::vector<double>& array, Point point);
};

/// The Euclidean split u = u_T + u_N by the projectors (15), (16), 3n each, in the user's order; supports: 0.
struct [[nodiscard]] Split {
  Outcome outcome;
  std::vector<double> tangent_accelerations, normal_accelerations;  ///< w_T (19), w_N (21), (22), m/s^2
  std::vector<double> tangent_forces, normal_forces;                ///< f_T, f_N, N
  std::vector<double> tangent_friction, normal_friction;            ///< tau_T, tau_N, N
  /// How far M takes N out of itself: the largest |(I - K Gamma^-1 K') M^-1 K x| over |M^-1 K x| for a random x (by A
  /// the same of T). At rounding, (44) K'M^-1 A = 0 holds here: w_T = M^-1 f_T, and each half of (18) stands alone.
  double mass_coupling = 0.0;
};

/// What one cause does to the constraints.
struct ReactionPart {
  std::string cause;                ///< name of a force, "friction", "inertia" or "drive"
  std::vector<double> multipliers;  ///< its part of lambda, [equations]
  std::vector<double> reactions;    ///< its part of eta, 3n, N; at supports: what the constraints do there
};

struct [[nodiscard]] ReactionsByCause {
  Outcome outcome;
  std::vector<ReactionPart> parts;
};

/// Friction by the paper's own three blocks (43), to verify the smallest form (*) that `solve` uses:
///
///   eta^(xi) = S^-1 K'[w_N - M^-1(f + A tau^(q))] - tau^(xi),   A tau^(q) = tau_T,   tau^(xi) = Gamma^-1 K' tau
struct [[nodiscard]] FrictionBlocks {
  Outcome outcome;
  std::vector<double> multipliers;      ///< eta^(xi) [equations]
  std::vector<double> friction;         ///< tau [3n], N
  int iterations = 0;                   ///< plain ones
  bool tangent_block_left_out = false;  ///< (44) holds here: the block of tau^(q) drops out of the first equation
};

/// Forward dynamics in normal or tangent form: accelerations and reactions of a system at one instant. (The paper calls
/// this the *inverse problem*, and *direct problem* what everybody else calls inverse dynamics, see InverseDynamics.)
///
/// All arrays are the host's own: point by point, 3n doubles, in the user's order; rows of multipliers in the order of
/// `num_equations`. Supports keep their rows: positions and velocities there are replaced by the prescribed motion.
/// An array of another size is an InputError that names it.
///
/// Each call is about the state that it is given. A call at the state of the last one goes on with the factor and the
/// friction that were found there, and solves nothing anew. Not thread-safe; one object per host thread.
class TANOR_API Dynamics {
 public:
  /// Validates; throws InputError.
  explicit Dynamics(System system, SolverOptions options = {});
  Dynamics(Dynamics&&) noexcept;
  Dynamics& operator=(Dynamics&&) noexcept;
  ~Dynamics();

  const System& system() const;  ///< as it was given
  std::size_t num_points() const;
  std::size_t num_equations() const;
  const PlanSummary& plan() const;
  /// Why there is no series in time (the method taylor needs one), naming what has none; empty: there is.
  std::string series_obstacle() const;

  /// Accelerations, multipliers and reactions at a state; fills the arrays that are wanted.
  SolveReport solve(const StateView& at, const SolveArrays& wanted = {});
  /// The same as a value.
  Solution solution(const StateView& at);

  /// The split: w_N = -K Gamma^-1 phi (21), f_N = K Gamma^-1 K'f, or, without constraints,
  /// w_N = (I - A G^-1 A') psi (22), f_T = A G^-1 A'f. Gamma and G are planned where this is first called and
  /// factorized in each call; where all masses are equal, Gamma = m S (36) needs no factor of its own.
  Split split(const StateView& at);

  /// The reaction by its causes, in the order of the forces, then "friction" (where there is some: of contacts that
  /// slide, those that stick count as held), "inertia" (the part of phi quadratic in v) and, where something is driven,
  /// "drive" (the other part: xi_t and the accelerations of supports). One factor of S (or H), one solve a cause; the
  /// parts add up to lambda and eta. Without constraints only eta is known.
  ReactionsByCause reactions_by_cause(const StateView& at);

  /// Friction once more, by (43) as it is printed, from no friction on. Throws InputError where there is no friction.
  FrictionBlocks friction_by_blocks(const StateView& at);

  /// Rank of K: decided where S = K'M^-1K raised a suspicion, else d. `thoroughly`: decides in any case.
  RankReport rank(const StateView& at, bool thoroughly = false);

  /// Proves accelerations, multipliers and reactions at a state, found for it unless the last solve found all of them
  /// there: identities, and second ways to the same numbers. Costs about as much as ten solves.
  Certificate certify(const StateView& at);

  /// Nearest r on xi(r, t) = 0 in the M-norm, by Newton's method from the given one. Velocities take no part.
  ProjectionReport project_positions(const MutableState& state);
  /// Nearest v with K'v + xi_t = 0 in the M-norm, K at the given positions (which should be admissible and stay).
  ProjectionReport project_velocities(const MutableVelocities& state);

  /// Consistent start: corrects positions and velocities. StartMode::Check throws InputError naming the worst
  /// constraint.
  StartReport start(const MutableState& state, StartMode mode);

  /// Largest relative violation of a constraint by positions, |xi|/|gradient|/length.
  [[nodiscard]] double position_violation(const StateView& at);
  /// Likewise by velocities, |K'v + xi_t|/|gradient|/velocity scale.
  [[nodiscard]] double velocity_violation(const StateView& at);

  // The calls of the version before; those that looked at "the last solve" take its state now (docs/from-0.1.md).
  [[deprecated("takes {.time, .positions, .velocities}, {.accelerations, .multipliers, .reactions}")]] SolveReport
  solve(double t, std::span<const double> r, std::span<const double> v, std::span<double> w,
        std::span<double> lambda = {}, std::span<double> eta = {}) {
    return solve({.time = t, .positions = r, .velocities = v},
                 {.accelerations = w, .multipliers = lambda, .reactions = eta});
  }
  [[deprecated("takes {.time, .positions}")]] ProjectionReport project_positions(double t, std::span<double> r) {
    return project_positions({.time = t, .positions = r});
  }
  [[deprecated("takes {.time, .positions, .velocities}")]] ProjectionReport project_velocities(
      double t, std::span<const double> r, std::span<double> v) {
    return project_velocities({.time = t, .positions = r, .velocities = v});
  }
  [[deprecated("takes {.time, .positions, .velocities}, mode")]] StartReport start(double t, std::span<double> r,
                                                                                   std::span<double> v,
                                                                                   StartMode mode) {
    return start({.time = t, .positions = r, .velocities = v}, mode);
  }
  [[deprecated("takes {.time, .positions, .velocities}")]] Solution solution(double t, std::span<const double> r,
                                                                             std::span<const double> v) {
    return solution({.time = t, .positions = r, .velocities = v});
  }
  [[deprecated("takes {.time, .positions}")]] double position_violation(double t, std::span<const double> r) {
    return position_violation({.time = t, .positions = r});
  }
  [[deprecated("takes {.time, .positions, .velocities}")]] double velocity_violation(double t,
                                                                                     std::span<const double> r,
                                                                                     std::span<const double> v) {
    return velocity_violation({.time = t, .positions = r, .velocities = v});
  }

  PhaseTimes phase_times() const;
  Counters counters() const;

 private:
  struct TANOR_LOCAL Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace tanor
