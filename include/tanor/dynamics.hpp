#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
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
struct PlanSummary {
  Form form = Form::Normal;  ///< that steps and answers: Normal or Tangent
  std::size_t points = 0, supports = 0, equations = 0, coordinates = 0, islands = 0;
  std::size_t parts = 0;                    ///< groups of islands with a factor of their own
  std::size_t pattern_nonzeros = 0;         ///< of the lower triangle of S, or H
  std::size_t factor_nonzeros = 0;          ///< of L
  double factor_flops = 0.0;                ///< of one numeric factorization
  double normal_flops = 0.0;                ///< predicted, of one evaluation and solve in normal form; 0: not made
  double tangent_flops = 0.0;               ///< likewise in tangent form
  std::string way = "general";              ///< to S lambda = b: "general", "paths", "bundles", "closed form" …
  std::string way_reason;                   ///< … and why
  std::string ordering;                     ///< used: "natural", "amd", …; several joined by '+'
  std::string factorization;                ///< "simplicial", "multifrontal", "none", or the way
  std::vector<std::string> left_out;        ///< what this system does not need
  std::vector<Index> taut_points;           ///< that a Simulation made supports of, see RankReport::taut_points …
  std::vector<std::size_t> taut_equations;  ///< … and the rods between them and supports
  std::vector<std::size_t>
      idle_equations;  ///< rows (user's order) that join supports alone: no part of S, multiplier 0
};

/// What is known about the friction (41) that belongs to a state.
enum class Uniqueness {
  NotAsked,
  Proven,    ///< one motion: rho(|S^-1 C|) < 1, or all modes of stick and slip were tried
  Unproven,  ///< one was found; nothing says that there is no other
  Several,   ///< refused at a start; in a run the one nearest to the step before is taken
  None
};

/// "proven" …
TANOR_API std::string_view uniqueness_name(Uniqueness uniqueness);
TANOR_API std::string_view friction_method_name(FrictionMethod method);

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
struct SolveReport {
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

/// The rank of K at one place.
struct RankReport {
  bool is_known = true;  ///< false: coordinates alone say what can move, no equation is written down
  std::size_t rank = 0;
  std::size_t degrees_of_freedom = 0;      ///< 3(n - supports) - rank; as many as coordinates where these stand alone
  std::vector<RowDependence> dependences;  ///< one for each equation that the rank lacks
  std::vector<bool> multipliers_unique;    ///< [d] false: others give the same reactions; the smallest are reported
  /// Held by taut rods between fixed supports: they cannot move, now or later, though K'w = -phi alone would let them.
  /// Dynamics answers by K alone; a Simulation that starts so makes supports of them (PlanSummary::taut_points).
  std::vector<Index> taut_points;
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

/// The motion went through, or came very near to, a place where K loses rank.
struct SingularPassage {
  double time = 0.0;                  ///< s
  double reciprocal_condition = 0.0;  ///< of S: smallest met after a step on the way there
};
struct SingularPassages {
  static constexpr std::size_t most_kept = 100;
  std::vector<SingularPassage> first;  ///< the first `most_kept`
  std::size_t count = 0;
};

struct ProjectionReport {
  Outcome outcome;
  double correction = 0.0;  ///< largest move of a point (m or m/s)
  double violation = 0.0;   ///< after the projection, relative
  int iterations = 0;
};

enum class StartMode {
  Check,   ///< correct up to 1e-3 of the length and velocity scale; more is an InputError
  Project  ///< nearest admissible start in the M-norm, however far
};

struct StartReport {
  Outcome outcome;
  double position_correction = 0.0, velocity_correction = 0.0;  ///< largest move of a point, m and m/s
  double relative = 0.0;  ///< the larger of both over the scene's size and velocity scale
};

/// A state with all that belongs to it, as a value: it stays what it is when the motion goes on. Arrays are in the
/// user's order.
struct TANOR_API Solution {
  Outcome outcome;                                 ///< not ok: accelerations, multipliers and forces are 0
  double time = 0.0;                               ///< s
  std::vector<double> positions, velocities;       ///< 3n, m and m/s
  std::vector<double> accelerations;               ///< 3n, m/s^2
  std::vector<double> multipliers;                 ///< [equations], N for constraints that are lengths
  std::vector<double> reactions, support_forces;   ///< 3n, N: K lambda; the load that each support carries
  double position_violation = 0.0;                 ///< largest |xi|/|gradient|/length
  std::vector<std::size_t> first_row, row_counts;  ///< [group of constraints] first equation; equations a member

  Vector3 position(Point point) const { return vector_of(positions, point); }
  Vector3 velocity(Point point) const { return vector_of(velocities, point); }
  Vector3 acceleration(Point point) const { return vector_of(accelerations, point); }
  /// N: what the constraints do to the point.
  Vector3 reaction(Point point) const { return vector_of(reactions, point); }
  /// N: what a support carries.
  Vector3 load(Point support) const { return vector_of(support_forces, support); }
  /// lambda of a member, of its k-th equation. Throws InputError where there is none.
  double multiplier(const Member& member, std::size_t k = 0) const;
  /// N: what a rod pulls with, -lambda; negative where it pushes.
  double tension(const Member& rod) const { return -multiplier(rod); }

 private:
  static Vector3 vector_of(const std::vector<double>& array, Point point);
};

/// The Euclidean split u = u_T + u_N by the projectors (15), (16), 3n each, in the user's order; supports: 0.
struct Split {
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

struct ReactionsByCause {
  Outcome outcome;
  std::vector<ReactionPart> parts;
};

/// Friction by the paper's own three blocks (43), to verify the smallest form (*) that `solve` uses:
///
///   eta^(xi) = S^-1 K'[w_N - M^-1(f + A tau^(q))] - tau^(xi),   A tau^(q) = tau_T,   tau^(xi) = Gamma^-1 K' tau
struct FrictionBlocks {
  Outcome outcome;
  std::vector<double> multipliers;      ///< eta^(xi) [equations]
  std::vector<double> friction;         ///< tau [3n], N
  int iterations = 0;                   ///< plain ones
  bool tangent_block_left_out = false;  ///< (44) holds here: the block of tau^(q) drops out of the first equation
};

/// The inverse problem, in normal or tangent form: accelerations and reactions of a system at one instant.
///
/// All arrays are the host's own: point by point, 3n doubles, in the user's order; rows of multipliers in the order of
/// `num_equations`. Supports keep their rows: positions and velocities there are replaced by the prescribed motion.
/// Not thread-safe; one object per host thread.
class TANOR_API Dynamics {
 public:
  explicit Dynamics(System system, SolverOptions options = {});
  Dynamics(Dynamics&&) noexcept;
  Dynamics& operator=(Dynamics&&) noexcept;
  ~Dynamics();

  const System& system() const;
  std::size_t num_points() const;
  std::size_t num_equations() const;
  const PlanSummary& plan() const;
  /// Why the motion has no series in time, as method `taylor` needs it; empty: it has.
  std::string series_obstacle() const;

  /// w (25), lambda = eta^(xi) (31), eta = K lambda (23) at (t, r, v). Rows of `reactions` and `accelerations` at
  /// supports: K lambda there, and the prescribed acceleration. An empty span is not computed.
  SolveReport solve(double t, std::span<const double> positions, std::span<const double> velocities,
                    std::span<double> accelerations, std::span<double> multipliers = {},
                    std::span<double> reactions = {});
  /// The same as a value.
  [[nodiscard]] Solution solution(double t, std::span<const double> positions, std::span<const double> velocities);

  /// Forces that the last solve found on the points, 3n, N: active ones, and the load each support carries (K lambda +
  /// f there).
  void active_forces(std::span<double> forces) const;
  void support_forces(std::span<double> forces) const;
  /// tau of the last solve, 3n, N: of contacts that slide, and what holds those that stick.
  void friction_forces(std::span<double> forces) const;

  /// The split of the last solve: w_N = -K Gamma^-1 phi (21), f_N = K Gamma^-1 K'f, or, without constraints,
  /// w_N = (I - A G^-1 A') psi (22), f_T = A G^-1 A'f. Gamma and G are planned where this is first called and
  /// factorized in each call; where all masses are equal, Gamma = m S (36) needs no factor of its own.
  Split split();

  /// The reaction of the last solve by its causes, in the order of the forces, then "friction" (where there is some: of
  /// contacts that slide, those that stick count as held), "inertia" (the part of phi
  /// quadratic in v) and, where something is driven, "drive" (the other part: xi_t and the accelerations of supports).
  /// One factor of S (or H), one solve a cause; the parts add up to lambda and eta. Without constraints only eta is
  /// known.
  ReactionsByCause reactions_by_cause();

  /// Friction at the last solve once more, by (43) as it is printed, from no friction on.
  FrictionBlocks friction_by_blocks();

  /// q, q_dot, q_ddot of the last solve, `plan().coordinates` numbers each where the tangent form answers; entry by
  /// entry, member by member, as `System::coordinates` lists them. Charts are centred at the present place: spheres,
  /// directions and rotations have q = 0 there. An empty span is not wanted.
  void coordinates(std::span<double> q, std::span<double> q_dot, std::span<double> q_ddot) const;

  /// Rank of K at the last solve: decided where S = K'M^-1K raised a suspicion, else d. `thoroughly`: decides now.
  RankReport rank(bool thoroughly = false);

  /// Proves the last solve, which is repeated for it: identities, and second ways to the same numbers. Costs about as
  /// much as ten solves.
  Certificate certify();

  /// Nearest r on xi(r, t) = 0 in the M-norm, by Newton's method from the given one.
  ProjectionReport project_positions(double t, std::span<double> positions);
  /// Nearest v with K'v + xi_t = 0 in the M-norm, K at the given positions (which should be admissible).
  ProjectionReport project_velocities(double t, std::span<const double> positions, std::span<double> velocities);

  /// Consistent start. StartMode::Check throws InputError naming the worst constraint.
  StartReport start(double t, std::span<double> positions, std::span<double> velocities, StartMode mode);

  /// Largest relative violation: |xi|/|gradient|/length, and |K'v + xi_t|/|gradient|/velocity scale.
  double position_violation(double t, std::span<const double> positions);
  double velocity_violation(double t, std::span<const double> positions, std::span<const double> velocities);

  PhaseTimes phase_times() const;
  Counters counters() const;

 private:
  struct TANOR_LOCAL Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace tanor
