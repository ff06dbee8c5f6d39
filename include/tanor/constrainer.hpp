#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <ranges>
#include <span>
#include <string>
#include <vector>

#include <tanor/dynamics.hpp>
#include <tanor/error.hpp>
#include <tanor/export.hpp>
#include <tanor/solver_options.hpp>
#include <tanor/system.hpp>

/// \file
/// Exact constraints for a simulation that owns its arrays, its forces and its time loop.
namespace tanor {

/// Points of a host as it stores them: the three numbers of a point follow one another, the next point begins `stride`
/// bytes further on. `index` says which of the host's points is which of ours, so that arrays in another order, or with
/// strangers in between, are read and written in place. Nothing is owned.
template <class Number>
struct BasicPointArray {
  Number* data = nullptr;
  std::ptrdiff_t stride = 0;     ///< bytes; 0: no gap
  const Index* index = nullptr;  ///< [point]: its number among the host's; null: the same
  /// Numbers behind `data`, where that is known: a call then checks that they are enough.
  std::size_t size = std::numeric_limits<std::size_t>::max();

  BasicPointArray() = default;
  BasicPointArray(Number* first, std::ptrdiff_t bytes_apart = 0, const Index* numbers = nullptr)
      : data(first), stride(bytes_apart), index(numbers) {}
  /// A packed array: a vector, a span.
  template <class Range>
  // NOLINTNEXTLINE(bugprone-forwarding-reference-overload): a point array is no range
  requires std::ranges::contiguous_range<Range> && std::convertible_to<Range&&, std::span<Number>> BasicPointArray(
      Range&& packed)  // NOLINT(google-explicit-constructor): every vector is one
      : data(std::span<Number>(packed).data()), size(std::span<Number>(packed).size()) {}

  /// There is an array.
  explicit operator bool() const { return data != nullptr; }
  operator BasicPointArray<const Number>() const requires(!std::is_const_v<Number>) {
    BasicPointArray<const Number> result(data, stride, index);
    result.size = size;
    return result;
  }
};
using PointArray = BasicPointArray<double>;
using ConstPointArray = BasicPointArray<const double>;

/// A cell that repeats itself: a point has images at r + a, r + b, r + c, which are the edges.
struct PeriodicCell {
  std::array<Vector3, 3> edges{};  ///< a, b, c: they span space, also where the cell does not repeat itself
  std::array<bool, 3> repeats{true, true, true};

  friend bool operator==(const PeriodicCell&, const PeriodicCell&) = default;
};

/// In which cell the points of a host are, and which images its rods join.
struct Periodicity {
  PeriodicCell cell{};
  /// [row] n: the rod from r_i to r_j + n0 a + n1 b + n2 c, with positions that the host never wraps. Empty: all rods
  /// join nearest images, wherever the host has wrapped its points, and are shorter than half of the cell.
  std::vector<std::array<int, 3>> images{};
};

/// What a call may write besides; an array that is not given costs nothing.
struct ConstraintForces {
  std::span<double> multipliers{};  ///< [num_rows()]: lambda; the tension of a rod is -lambda
  PointArray forces{};              ///< what the constraints do to each point, supports too: K lambda
  /// r (x) F of each constraint, in equal parts at its points: nine numbers a point, row by row of the tensor. Their
  /// sum is the virial, and about the centroid of each constraint they are what a heat flux needs.
  PointArray stress{};
};

/// The host went from `old_positions`, which satisfy the constraints, to `positions`.
struct PositionStep {
  double step = 0.0;  ///< h, not 0; negative: backwards
  ConstPointArray old_positions{};
  PointArray positions{};  ///< come back on the constraints
  /// At half of the step; come back with the same correction over h; may be absent. At supports: theirs where the step
  /// begins, for `work`.
  PointArray velocities{};
  ConstraintForces wanted{};
  /// The cell of `old_positions` where it is another one. Null: that of the last call, if these are its positions bit
  /// by bit; else the present one.
  const PeriodicCell* old_cell = nullptr;
  double time = 0.0;     ///< at the end of the step: where lengths depend on it
  bool measures = true;  ///< finds the virial, the largest turn, the work and the worst row; false saves that
  /// A largest |xi|/length that is small enough: iterations end there. 0: they end at rounding, below 1e-13.
  double tolerance = 0.0;
};

/// The host's velocities are to obey the constraints at `positions`.
struct VelocityStep {
  /// h: multipliers are 2/h times the impulses that change the velocities; 0: they are these impulses.
  double step = 0.0;
  ConstPointArray positions{};
  PointArray velocities{};
  ConstraintForces wanted{};
  double time = 0.0;
  bool measures = true;
};

/// A state with the forces that act there.
struct HostState {
  ConstPointArray positions{}, velocities{}, forces{};
  PointArray accelerations{};  ///< M^-1 (f + K lambda); 0 at supports; may be absent
  ConstraintForces wanted{};
  double time = 0.0;
  bool measures = true;
};

/// How a call of a Constrainer ended.
struct [[nodiscard]] ConstraintReport {
  static constexpr std::size_t no_row = std::numeric_limits<std::size_t>::max();

  Outcome outcome;          ///< not ok: no array of the host was touched
  int iterations = 0;       ///< most of any island
  double violation = 0.0;   ///< what is left over: |xi|/length, rates over the largest velocity, K'w + phi likewise
  double correction = 0.0;  ///< largest move of a point, change of its velocity or of its force
  // Where the call `measures`.
  std::size_t worst_row = no_row;  ///< the row with that violation, see Constrainer::row_name; also after a failure
  double largest_turn = 0.0;       ///< rad, of a rod in the step; beyond 0.4 the step is too long
  double work = 0.0;  ///< that lengths depending on time, and supports that move, did in this half of the step
  /// Sum of r (x) K lambda over all points: xx, yy, zz, xy, xz, yz. A rod adds lambda L u (x) u: no large numbers
  /// cancel.
  std::array<double, 6> virial{};
};

/// A constraint by itself: a rod, a point on a plane. Ids ascend in the order in which constraints came; none is given
/// twice.
using ConstraintId = std::int64_t;

/// Rows [first, first + count).
struct RowRange {
  std::size_t first = 0, count = 0;
};

/// ln det S, S = K'M^-1K being the Schur complement of the mass matrix.
struct [[nodiscard]] LogDeterminant {
  Outcome outcome;  ///< Status::Singular, with the row's name, where rows depend on each other
  double value = 0.0;
};

/// Exact constraints inside somebody else's time loop: SHAKE and RATTLE for any graph of any constraints, to rounding,
/// at the cost of a few passes over the memory. Velocity Verlet with it is
///
///   v += h/2 M^-1 f,   old = r,   r += h v,   constrain_positions   (r, v along M^-1 K(old))
///   f = forces(r),     v += h/2 M^-1 f,       constrain_velocities  (v along M^-1 K(r))
///
/// which conserves energy, and goes back the way it came, as the method without constraints does.
///
/// A handle owns the plan, the factors and its scratch; the host's arrays are borrowed for the call. The factor at the
/// positions of the last call is used again where the same positions, bit by bit, are given next: so a step of the loop
/// factorizes once. One handle belongs to one thread at a time, handles are independent, and a step allocates nothing.
/// Units are the host's own. What is wrongly called is an InputError, what the numbers refuse is an Outcome.
class TANOR_API Constrainer {
 public:
  /// Points of infinite mass are supports: constraints move them never, and read where the host has put them.
  /// `at`: positions [masses.size()], which give lengths that are "initial". Throws InputError.
  Constrainer(std::span<const double> masses, std::vector<Constraint> constraints, ConstPointArray at,
              const SolverOptions& options = {});
  /// The same in a periodic cell. Constraints that hold points in space see positions as the host wraps them.
  Constrainer(std::span<const double> masses, std::vector<Constraint> constraints, ConstPointArray at,
              const Periodicity& periodicity, const SolverOptions& options = {});
  Constrainer(Constrainer&&) noexcept;
  Constrainer& operator=(Constrainer&&) noexcept;
  ~Constrainer();

  /// From the next call on; it may change in every step. Where rods close a way round the cell all is planned anew, and
  /// the cell of old positions is the present one. Throws InputError, naming a rod that is longer than half of the
  /// cell.
  void set_cell(const PeriodicCell& cell);

  // ---- what is constrained: may change between calls ----
  // Wrong input is an InputError, after which nothing has changed. Until `expect_edits`, or the first edit, all islands
  // are planned together, which is fastest for those who never edit. From then on they are planned in parts: the next
  // call plans the islands that an edit has touched, with a few of their neighbours, and no others; all others keep
  // plan, factor and guess. Then all is as in a new Constrainer that expects edits, with the same points and
  // constraints at the same positions: to the last bit, but for what comes from calls before (guesses of
  // constrain_positions, a factor at the same positions), for which that one has to restore what this one saved. An
  // edit begins with the positions that the last call began with.

  /// Plans in parts from now on. A host that is going to edit says so at once, else its first edit plans all anew.
  void expect_edits();

  /// A group like those that the constructor takes, which have the ids from 0 on. Returns the id of its first member;
  /// the others follow. `at`: the host's positions now, which give lengths that are "initial"; absent: as said above.
  /// `images` [row], if Periodicity had them: see there. Constraints that are added where none were planned yet are no
  /// edit that parts begin with.
  ConstraintId add(Constraint group, ConstPointArray at = {}, std::vector<std::array<int, 3>> images = {});
  void remove(std::span<const ConstraintId> ids);
  /// Lengths of rods (radii, offsets, cosines, values) from now on, and how fast they change; `rates` empty: they are
  /// at rest. Where a rate was given once nothing is planned any more.
  void set_lengths(std::span<const ConstraintId> ids, std::span<const double> lengths,
                   std::span<const double> rates = {});
  /// From now on; what is infinite remains so, and what is not.
  void set_masses(std::span<const Index> points, std::span<const double> masses);
  /// Points come and go, as those that migrate between ranks: number i was from[i], or is a new point where that is -1.
  /// Those that are missing have left; no constraint holds them any more. `masses` [from.size()] of all. `at`: the
  /// host's positions now. What only changes its number keeps its plan.
  void renumber(std::span<const std::int64_t> from, std::span<const double> masses, ConstPointArray at = {});
  /// Does now what the next call would; returns how many islands were planned.
  std::size_t update_plan();

  std::size_t num_points() const;
  double mass(Index point) const;  ///< infinite: a support
  std::size_t num_rows() const;
  /// Rows are numbered in the order of ids. Throws InputError where there is no such constraint.
  RowRange rows(ConstraintId id) const;
  /// "rods[17]": the name of its group and its place there when it was added.
  std::string row_name(std::size_t row) const;
  /// Of all islands together; as it was planned last.
  const PlanSummary& plan() const;

  /// All that the next call depends on beside the host's arrays, masses and constraints: where guesses begin, ranks,
  /// whether it was cut into parts. For a Constrainer with the same ones, which goes on to the last bit as this one
  /// would have.
  std::vector<std::byte> save();
  /// Throws InputError where the bytes are damaged, or belong to others.
  void restore(std::span<const std::byte> bytes);

  /// SHAKE: r += M^-1 K(r_old) mu so that xi(r) = 0, v += M^-1 K(r_old) mu/h. Multipliers are 2 mu/h^2.
  /// They are those of the accelerations up to O(h); see `solve`.
  ConstraintReport constrain_positions(const PositionStep& step);
  /// RATTLE's second half: v += M^-1 K(r) nu so that K(r)'v + xi_t = 0. Multipliers are 2 nu/h.
  ConstraintReport constrain_velocities(const VelocityStep& step);
  /// Accelerations and multipliers of this instant: S lambda = -(phi + K'M^-1 f). The virial is exact: with rigid
  /// molecules the atomic and the molecular pressure agree to rounding. Supports count as not accelerated.
  ConstraintReport solve(const HostState& at);

  /// f -= K S^-1 K'M^-1 f: what is left moves no constraint. For minimisers; those whose variables have no masses give
  /// all points the mass 1. Its virial, stress and multipliers are those of `solve` with velocities 0.
  ConstraintReport project_forces(ConstPointArray positions, PointArray forces, double time = 0.0);
  /// The nearest positions on the constraints in the M-norm, from anywhere: for starts, before the first forces.
  ConstraintReport project_positions(PointArray positions, double time = 0.0);

  /// ln det S at these positions; `gradient` (may be absent) becomes its derivative in all positions, supports too.
  /// Fixman's metric force is -kT/2 times that. The gradient is known for rods alone: where there are other constraints
  /// it is an InputError to ask for it.
  LogDeterminant log_det(ConstPointArray positions, PointArray gradient = {}, double time = 0.0);

  /// Largest |xi|/|gradient|/length at these positions, as `violation` with its row.
  ConstraintReport violation(ConstPointArray positions, double time = 0.0);
  /// The rank of K at these positions: so many degrees of freedom the constraints take, also where rows depend on
  /// others, which the report names.
  RankReport rank(ConstPointArray positions, double time = 0.0);
  /// The degrees of freedom that the constraints take of the points with a flag: each independent row counts by its
  /// share of such points among those of its points that move. With all flags it is `rank(positions).rank`.
  double removed_degrees_of_freedom(ConstPointArray positions, std::span<const std::uint8_t> flags, double time = 0.0);
  Counters counters() const;

 private:
  struct TANOR_LOCAL Implementation;
  Constrainer(std::span<const double> masses, std::vector<Constraint> constraints, ConstPointArray at,
              const Periodicity* periodicity, const SolverOptions& options);
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace tanor
