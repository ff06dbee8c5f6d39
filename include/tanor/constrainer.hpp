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
#include <tanor/observables.hpp>
#include <tanor/solver_options.hpp>
#include <tanor/system.hpp>

/// \file
/// Exact constraints for a simulation that owns its arrays, its forces and its time loop.
namespace tanor {

/// Points of a host as it stores them. The three numbers of a point follow one another, and the next point begins
/// `stride` bytes further on. `index` gives the host's number of each point of this system, so that arrays in another
/// order, or with other points in between, are read and written in place. Nothing is owned.
template <class Number>
struct BasicPointArray {
  Number* data = nullptr;
  std::ptrdiff_t stride = 0;     ///< bytes; 0 if there is no gap
  const Index* index = nullptr;  ///< [point] its number among the host's; null if they are the same
  /// Number of elements of `data`, if known; a call then checks that there are enough.
  std::size_t size = std::numeric_limits<std::size_t>::max();

  BasicPointArray() = default;
  BasicPointArray(Number* first, std::ptrdiff_t bytes_apart = 0, const Index* numbers = nullptr)
      : data(first), stride(bytes_apart), index(numbers) {}
  // clang-format off
  /// A packed array, such as a vector or a span.
  template <class Range>
    requires std::ranges::contiguous_range<Range> && std::convertible_to<Range&&, std::span<Number>>
  // NOLINTNEXTLINE(bugprone-forwarding-reference-overload,google-explicit-constructor): every vector is a point array
  BasicPointArray(Range&& packed)
      : data(std::span<Number>(packed).data()), size(std::span<Number>(packed).size()) {}
  // clang-format on

  /// Returns true if there is an array.
  explicit operator bool() const { return data != nullptr; }
  operator BasicPointArray<const Number>() const requires(!std::is_const_v<Number>) {
    BasicPointArray<const Number> result(data, stride, index);
    result.size = size;
    return result;
  }
};
using PointArray = BasicPointArray<double>;
using ConstPointArray = BasicPointArray<const double>;

/// A periodic cell with the edges a, b, c: a point has images at r + a, r + b, r + c.
struct PeriodicCell {
  std::array<Vector3, 3> edges{};  ///< a, b, c; they span space, also where the cell is not periodic
  std::array<bool, 3> repeats{true, true, true};

  friend bool operator==(const PeriodicCell&, const PeriodicCell&) = default;
};

/// The cell of the host's points and the images that its rods join.
struct Periodicity {
  PeriodicCell cell{};
  /// [row] n: the rod joins r_i and r_j + n0 a + n1 b + n2 c, in positions that the host never wraps. If empty, all
  /// rods join nearest images, wherever the host has wrapped its points, and are shorter than half of the cell.
  std::vector<std::array<int, 3>> images{};
};

/// Optional output of a call; an array that is not given costs nothing.
struct ConstraintForces {
  std::span<double> multipliers{};  ///< [num_rows()] lambda; the tension of a rod is -lambda
  PointArray forces{};              ///< K lambda, the forces of the constraints on the points, also on supports
  /// r (x) F of each constraint, in equal parts at its points: nine numbers for each point, row by row of the tensor.
  /// Their sum is the virial. About the centroid of each constraint they are what a heat flux needs.
  PointArray stress{};
};

/// A step of the host from `old_positions`, which satisfy the constraints, to `positions`.
struct PositionStep {
  double step = 0.0;  ///< h, not 0; a negative step runs backwards
  ConstPointArray old_positions{};
  PointArray positions{};  ///< projected onto the constraints by the call
  /// Velocities at half of the step, which receive the same correction over h; may be absent. At supports they are
  /// those at the start of the step, for `work`.
  PointArray velocities{};
  ConstraintForces wanted{};
  /// The cell of `old_positions` if it differs from the present one. If null, it is the cell of the last call if these
  /// are its positions bit by bit, else the present cell.
  const PeriodicCell* old_cell = nullptr;
  double time = 0.0;     ///< at the end of the step, for lengths that depend on time
  bool measures = true;  ///< true if the call finds what comes last in ConstraintReport
  /// Largest |xi|/length at which the iterations may end. With 0 they end at rounding, below 1e-13.
  double tolerance = 0.0;
};

/// Velocities of the host that are projected onto the constraints at `positions`.
struct VelocityStep {
  /// h: the multipliers are 2/h times the impulses that change the velocities. With 0 they are these impulses.
  double step = 0.0;
  ConstPointArray positions{};
  PointArray velocities{};
  ConstraintForces wanted{};
  double time = 0.0;
  bool measures = true;
};

/// A state with the forces that act in it.
struct HostState {
  ConstPointArray positions{}, velocities{}, forces{};
  PointArray accelerations{};  ///< M^-1 (f + K lambda); 0 at supports; may be absent
  ConstraintForces wanted{};
  double time = 0.0;
  bool measures = true;
};

/// Result of a call of a Constrainer. A member that has no meaning in a call stays as it is here.
struct [[nodiscard]] ConstraintReport {
  static constexpr std::size_t no_row = std::numeric_limits<std::size_t>::max();

  Outcome outcome;         ///< if not ok, no array of the host was changed
  int iterations = 0;      ///< largest number over all islands
  double violation = 0.0;  ///< remaining |xi|/length, rates over the largest velocity, or K'w + phi likewise
  // The following members are found if the call `measures`, and by calls without that choice.
  double correction = 0.0;  ///< largest change of a point's position, velocity or force, where a call changes one
  std::size_t worst_row = no_row;  ///< row with that violation, see Constrainer::row_name; also after a failure
  /// Largest rotation of a rod, rad, in constrain_positions, where beyond 0.4 the step is too long, and in
  /// project_positions. In other calls rods do not move.
  double largest_turn = 0.0;
  /// Work of time-dependent lengths and of moving supports in this half of the step: in constrain_positions and
  /// constrain_velocities.
  double work = 0.0;
  /// Sum of r (x) K lambda over all points: xx, yy, zz, xy, xz, yz. A rod adds lambda L u (x) u, so that no large
  /// numbers cancel. Calls without multipliers, project_positions and violation, have none.
  std::array<double, 6> virial{};
};

/// Number of a single constraint, such as a rod or a point on a plane. Ids ascend in the order in which constraints
/// came, and none is used twice.
using ConstraintId = std::int64_t;

/// Rows [first, first + count).
struct RowRange {
  std::size_t first = 0, count = 0;
};

/// ln det S, where S = K'M^-1K is the Schur complement of the mass matrix.
struct [[nodiscard]] LogDeterminant {
  Outcome outcome;  ///< Status::Singular, with the row's name, if rows depend on each other
  double value = 0.0;
};

/// Exact constraints inside the time loop of a host: SHAKE and RATTLE for any graph of any constraints, to rounding, at
/// the cost of a few passes over the memory. Velocity Verlet with it is
///
/// v += h/2 M^-1 f,   old = r,   r += h v,   constrain_positions   (r, v along M^-1 K(old)) f = forces(r),     v += h/2
/// M^-1 f,       constrain_velocities  (v along M^-1 K(r))
///
/// It conserves energy and is reversible in time, as the method without constraints is.
///
/// A handle owns the plan, the factors and its scratch; the host's arrays are borrowed for the call. If the positions
/// of a call are, bit by bit, those of the last call, its factor is used again, so that a step of the loop factorizes
/// once. One handle belongs to one thread at a time, handles are independent, and a step allocates nothing. Units are
/// the host's own. A wrong call throws InputError; a numerical failure is an Outcome.
class TANOR_API Constrainer {
 public:
  /// Plans the constraints of the points. Points of infinite mass are supports, which stay where the host puts them.
  /// `at` are the positions [masses.size()], which define lengths that are "initial". Throws InputError.
  Constrainer(std::span<const double> masses, std::vector<Constraint> constraints, ConstPointArray at,
              const SolverOptions& options = {});
  /// The same in a periodic cell. Constraints that hold points in space use the positions as the host wraps them.
  Constrainer(std::span<const double> masses, std::vector<Constraint> constraints, ConstPointArray at,
              const Periodicity& periodicity, const SolverOptions& options = {});
  Constrainer(Constrainer&&) noexcept;
  Constrainer& operator=(Constrainer&&) noexcept;
  ~Constrainer();

  /// Sets the cell from the next call on; it may change in every step, and nothing is planned again for it. Throws
  /// InputError, naming a rod that is longer than half of the cell.
  void set_cell(const PeriodicCell& cell);

  // ---- constraints, which may change between calls ----
  //
  // Wrong input is an InputError, after which nothing has changed. Until `expect_edits`, or the first edit, all islands
  // are planned together, which is fastest for hosts that never edit. From then on they are planned in parts: the next
  // call plans only the islands that an edit has touched, with a few of their neighbours; all others keep plan, factor
  // and initial guess. The results are then, to the last bit, those of a new Constrainer that expects edits, with the
  // same points and constraints at the same positions. What comes from earlier calls (guesses of constrain_positions, a
  // factor at the same positions) is excepted; for that the new one must restore what this one saved. An edit starts
  // from the positions that the last call began with.

  /// Plans islands in parts from now on. A host that will edit calls this first; else its first edit plans everything
  /// again.
  void expect_edits();

  /// Adds a group like those of the constructor, whose ids begin at 0. Returns the id of its first member; the others
  /// follow. `at` are the host's present positions, which define lengths that are "initial"; if absent, they are those
  /// that the last call began with. `images` [row] are given if Periodicity had them. Constraints that are added before
  /// anything was planned do not count as an edit.
  ConstraintId add(Constraint group, ConstPointArray at = {}, std::vector<std::array<int, 3>> images = {});
  void remove(std::span<const ConstraintId> ids);
  /// Sets the lengths of rods (radii, offsets, cosines, values) and their rates of change; empty `rates` are zero. A
  /// constraint that was given a nonzero rate once needs no planning for later lengths.
  void set_lengths(std::span<const ConstraintId> ids, std::span<const double> lengths,
                   std::span<const double> rates = {});
  /// Sets the masses of points. A finite mass must remain finite, an infinite one infinite.
  void set_masses(std::span<const Index> points, std::span<const double> masses);
  /// Renumbers the points when some come or go, for instance between ranks. Point i had the number from[i], or is new
  /// if that is -1. Points that are missing in `from` have left, and no constraint may hold them any more. `masses`
  /// [from.size()] are those of all points, `at` their present positions. A point that only changes its number keeps
  /// its plan.
  void renumber(std::span<const std::int64_t> from, std::span<const double> masses, ConstPointArray at = {});
  /// Plans now what the next call would plan; returns how many islands were planned.
  std::size_t update_plan();

  std::size_t num_points() const;
  double mass(Index point) const;  ///< infinite for a support
  std::size_t num_rows() const;
  /// Returns the rows of a constraint, which are numbered in the order of ids. Throws InputError if there is no such
  /// id.
  RowRange rows(ConstraintId id) const;
  /// Returns the name of a row, such as "rods[17]": its group and its place there when it was added.
  std::string row_name(std::size_t row) const;
  /// Returns the last plan of all islands together.
  const PlanSummary& plan() const;

  /// Saves all that the next call depends on beside the host's arrays, masses and constraints: the initial guesses, the
  /// ranks, and whether the islands are planned in parts. A Constrainer with the same masses and constraints continues
  /// from it to the last bit.
  std::vector<std::byte> save();
  /// Restores saved bytes. Throws InputError if they are damaged or belong to another system.
  void restore(std::span<const std::byte> bytes);

  /// SHAKE: r += M^-1 K(r_old) mu so that xi(r) = 0, v += M^-1 K(r_old) mu/h. The multipliers are 2 mu/h^2. They agree
  /// with those of the accelerations up to O(h); see `solve`.
  ConstraintReport constrain_positions(const PositionStep& step);
  /// Second half of RATTLE: v += M^-1 K(r) nu so that K(r)'v + xi_t = 0. The multipliers are 2 nu/h.
  ConstraintReport constrain_velocities(const VelocityStep& step);
  /// Computes accelerations and multipliers of this instant: S lambda = -(phi + K'M^-1 f). The virial is exact: with
  /// rigid molecules the atomic and the molecular pressure agree to rounding. Supports count as not accelerated.
  ConstraintReport solve(const HostState& at);

  // ---- observables ----
  //
  // Names are those of rows, such as "rod0[17]"; all supports together are "support0", in the order of the points,
  // which have the host's numbers. Only the host knows its forces one by one, so there is no potential(), energy(),
  // pressure(), virial() and friction(). In a periodic cell points stand at the images that their constraints join.
  // After an edit the texts are read again, in a time that grows with the number of constraints.

  /// Adds an observable, see docs/observables.md, and returns its number. `every_step` has no meaning here: each
  /// `observe` counts for the extremes. Throws InputError, after which nothing has changed, if the text cannot be read.
  std::size_t add_observable(const Observable& observable);
  /// Removes an observable; those behind it move up by one. It serves those whose thing was removed.
  void remove_observable(std::size_t number);
  /// Does what `solve` does, and evaluates all observables. If no observable needs forces, `at.forces` may be absent;
  /// then nothing is solved. Throws InputError, naming it, if an edit removed a thing of which an observable speaks.
  ConstraintReport observe(const HostState& at);
  /// Returns the observables by their numbers, with the values of the last `observe`, NaN before it. They stand until
  /// the next of these calls.
  std::span<const Observed> observed() const;

  /// Projects the forces, f += K lambda with S lambda = -K'M^-1 f, so that they do not act on the constraints. It
  /// serves minimisers; those whose variables have no masses give all points the mass 1.
  ConstraintReport project_forces(ConstPointArray positions, PointArray forces, double time = 0.0,
                                  const ConstraintForces& wanted = {});
  /// Finds the nearest positions on the constraints in the M-norm, from any. It serves starts, before the first forces.
  ConstraintReport project_positions(PointArray positions, double time = 0.0);

  /// Computes ln det S at these positions. `gradient` (may be absent) becomes its derivative in all positions, also of
  /// supports. Fixman's metric force is -kT/2 times that. Second derivatives that are not finite are
  /// Status::NotFinite.
  LogDeterminant log_det(ConstPointArray positions, PointArray gradient = {}, double time = 0.0);

  /// Finds the largest |xi|/|gradient|/length at these positions and its row.
  ConstraintReport violation(ConstPointArray positions, double time = 0.0);
  /// Returns the rank of K at these positions, the number of degrees of freedom that the constraints remove. The report
  /// names rows that depend on others.
  RankReport rank(ConstPointArray positions, double time = 0.0);
  /// Returns the degrees of freedom that the constraints remove from the points with a nonzero flag: each independent
  /// row counts by the share of such points among its moving points. If all flags are set, it is
  /// `rank(positions).rank`.
  double removed_degrees_of_freedom(ConstPointArray positions, std::span<const std::uint8_t> flags, double time = 0.0);
  Counters counters() const;

 private:
  struct TANOR_LOCAL Implementation;
  Constrainer(std::span<const double> masses, std::vector<Constraint> constraints, ConstPointArray at,
              const Periodicity* periodicity, const SolverOptions& options);
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace tanor
