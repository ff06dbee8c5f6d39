#ifndef TANOR_H
#define TANOR_H
/** \file
 * Exact constraints for a host's own time loop, in C: tanor::Constrainer (<tanor/constrainer.hpp>).
 *
 * The host owns every array and the time loop; a handle owns the plan, the factors and its scratch. Nothing throws,
 * prints or aborts; a step allocates nothing once the handle is planned. Handles are independent: different ones may be
 * used by different threads at once, one handle by one thread at a time. Arrays handed to one call must not overlap.
 *
 * Units are the host's: lengths, times and masses as it likes; a force is mass * length / time^2.
 *
 * Rules of the binary interface: a struct that may grow begins with its `size`, which the caller sets to sizeof; what
 * lies beyond it is neither read nor written. A changed meaning changes TN_ABI.
 */
#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__) && !defined(_WIN32)
#define TN_API __attribute__((visibility("default")))
#else
#define TN_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define TN_ABI 1

/** Points with their masses, and what constrains them. */
typedef struct tn_system tn_system;

/** 0: all right. 1 to 99: the caller's mistake. From 100 on: the numbers say no. In all these no array was changed. */
typedef enum tn_result {
  TN_OK = 0,
  TN_EINVAL = 1,     /**< wrong argument, see tn_last_error */
  TN_ENOMEM = 2,     /**< no memory; the handle can only be destroyed */
  TN_EINTERNAL = 3,  /**< a defect of the library; the handle can only be destroyed */
  TN_SINGULAR = 101, /**< a constraint has no gradient here, or rows depend on each other */
  TN_CONTRADICTORY = 102,
  TN_NOT_CONVERGED = 103, /**< tn_last_error names the constraint; a shorter step may do */
  TN_NOT_FINITE = 104     /**< NaN or infinity in the host's arrays */
} tn_result;

/** Points of a host as it stores them: the three numbers of a point follow one another, the next point begins `stride`
 * bytes further on (0: packed). `index` (may be null) says which of the host's points is point i of this system: arrays
 * in another order, or with strangers in between, are read and written in place. Borrowed for the call. */
typedef struct tn_points {
  double* data;
  ptrdiff_t stride;
  const int32_t* index;
} tn_points;
typedef struct tn_const_points {
  const double* data;
  ptrdiff_t stride;
  const int32_t* index;
} tn_const_points;

typedef struct tn_options {
  uint32_t size;    /**< sizeof(tn_options) */
  int32_t threads;  /**< 0: as OpenMP gives, whose threads spin for some milliseconds behind a call unless
                       OMP_WAIT_POLICY=passive is set; 1: none are started */
  double tolerance; /**< of tn_constrain_positions: |xi|/length that is small enough; 0: rounding, below 1e-13 */
} tn_options;

/** What a call may write besides; what is null costs nothing. */
typedef struct tn_wanted {
  uint32_t size;       /**< sizeof(tn_wanted) */
  int32_t measures;    /**< not 0: virial, largest_turn, work and worst_row of the report are found */
  double* multipliers; /**< [tn_num_rows]: lambda; the tension of a rod is -lambda */
  tn_points forces;    /**< K lambda: what the constraints do to each point */
  tn_points stress;    /**< nine numbers a point (packed: stride 0): r (x) F of each constraint, shared by its points */
} tn_wanted;

/** What a call found out; filled as far as `size` says. */
typedef struct tn_report {
  uint32_t size;       /**< sizeof(tn_report) */
  int32_t iterations;  /**< most of any island */
  double violation;    /**< what is left over, relative */
  double correction;   /**< largest move of a point, change of its velocity or of its force */
  int64_t worst_row;   /**< the row with that violation; -1: not asked for. See tn_row_name */
  double largest_turn; /**< rad, of a rod in the step: beyond 0.4 the step is too long */
  double work;         /**< that lengths depending on time, and supports that move, did in this half of the step */
  double virial[6];    /**< sum of r (x) K lambda: xx yy zz xy xz yz */
} tn_report;

/* ---- life ---- */

TN_API int tn_abi(void); /**< TN_ABI of the library */
/** What `tanor --version` prints: "tanor 0.1.0", and on three more lines which QR and which CHOLMOD the library has,
 * which decide the licence that a binary must follow, and the instruction set of the hot loops. */
TN_API const char* tn_version(void);

/** n points with their masses (infinite: a support, which constraints never move) at `positions`, which are read now.
 * `options` may be null. `*out` is null after a failure; tn_create_error() then says why, for each thread its own. */
TN_API int tn_create(tn_system** out, size_t num_points, const double* masses, tn_const_points positions,
                     const tn_options* options);
TN_API void tn_destroy(tn_system* system); /**< null: nothing */
TN_API const char* tn_create_error(void);
/** What the last call that failed on this handle complained about; valid until the next one fails. Never null. */
TN_API const char* tn_last_error(const tn_system* system);

/* ---- what is constrained ---- */

/* What is constrained may change between steps. After tn_expect_edits the next call, or tn_plan, plans the islands that
 * an edit has touched with a few of their neighbours, and no others; without it the first edit of what was planned lets
 * it plan all anew. After an edit that fails nothing has changed. Each constraint has an id, which none had before; ids
 * ascend, and the rows of constraints are numbered in their order. */

/** Kinds of tn_add: points, then parameters of each member. A member's last parameter, which tn_set_lengths may change,
 * is one of its own; neighbours in the list with the same other ones are kept together. */
typedef enum tn_kind {
  TN_ROD = 1,    /**< i, j; length */
  TN_ANGLE = 2,  /**< i, j, k; the cosine of the angle at j */
  TN_PLANE = 3,  /**< i; normal n (3), offset a: n.r = a */
  TN_SPHERE = 4, /**< i; center (3), radius */
  TN_LINE = 5,   /**< i; a point of the line (3), direction (3): two rows; it has no length */
  TN_CIRCLE = 6  /**< i; center (3), normal (3), radius: two rows */
} tn_kind;

/** Rods between the points i = pairs[2k] and j = pairs[2k + 1], of these lengths (null: as long as they were where the
 * last call began, or tn_create). `images` (may be null), three whole numbers a rod: it joins r_i and r_j + n0 a + n1 b
 * + n2 c, see tn_set_box. `ids` [count] receives their ids (may be null). */
TN_API int tn_add_rods(tn_system* system, size_t count, const int32_t* pairs, const double* lengths,
                       const int32_t* images, int64_t* ids);
/** Constraints of a kind. `parameters` may be null for rods and angles, which are then as they were. */
TN_API int tn_add(tn_system* system, tn_kind kind, size_t count, const int32_t* points, const double* parameters,
                  int64_t* ids);
TN_API int tn_remove(tn_system* system, size_t count, const int64_t* ids);
/** Lengths (cosines, offsets, radii) from now on, and how fast they change (null: they are at rest). Where a rate was
 * given once nothing is planned any more. */
TN_API int tn_set_lengths(tn_system* system, size_t count, const int64_t* ids, const double* lengths,
                          const double* rates);
/** Masses of points from now on; what is infinite remains so, and what is not. */
TN_API int tn_set_masses(tn_system* system, size_t count, const int32_t* points, const double* masses);
/** Points come and go (those that migrate between ranks): number i was from[i], -1: a new one. Those that are missing
 * have left; no constraint holds them any more. `masses` of all; `x` (data may be null): where they are now. What only
 * changes its number keeps its plan. */
TN_API int tn_renumber(tn_system* system, size_t num_points, const int64_t* from, const double* masses,
                       tn_const_points x);
/** Edges of a periodic cell, rows a, b, c, from the next call on; it may change in every step. `repeats` three flags
 * (null: all are set). Rods join nearest images, wherever the host has wrapped its points; or, as soon as `images` of
 * some rod are given, those images, of positions that are never wrapped. The first one is that of the positions of
 * tn_create, and comes before the first constraints. */
TN_API int tn_set_box(tn_system* system, const double cell[9], const int repeats[3]);
/** The constraints will change: they are planned in parts from now on. */
TN_API int tn_expect_edits(tn_system* system);
/** The cell in which x_old of the next tn_constrain_positions is. Without it: that of the last call, if these are its
 * positions bit by bit, else the present one. */
TN_API int tn_set_old_box(tn_system* system, const double cell[9]);
/** Plans now what the next call would. `islands` (may be null) receives how many were planned. */
TN_API int tn_plan(tn_system* system, size_t* islands);
TN_API size_t tn_num_points(const tn_system* system);
TN_API size_t tn_num_rows(const tn_system* system);
/** Rows of a constraint: [first, first + count). */
TN_API int tn_rows(tn_system* system, int64_t id, size_t* first, size_t* count);
/** The name of a row, "rod0[17]": group and member as they were added, into `text`, cut off at `size` bytes with its
 * end. */
TN_API int tn_row_name(tn_system* system, size_t row, char* text, size_t size);

/* ---- a step: SHAKE and RATTLE ---- */

/** From x_old, which obeys the constraints, the host went to x. Moves x onto them along M^-1 K(x_old):
 *
 *     x += M^-1 K(x_old) mu,   v += M^-1 K(x_old) mu / dt,   multipliers 2 mu/dt^2
 *
 * v (data may be null): at half of the step. `wanted` and `report` may be null. Where x_old is, bit by bit, where the
 * last call ended, its factor is used again. */
TN_API int tn_constrain_positions(tn_system* system, double dt, tn_const_points x_old, tn_points x, tn_points v,
                                  const tn_wanted* wanted, tn_report* report);
/** v onto K(x)'v = 0 in the M-norm; multipliers 2 nu/dt, where dt is 0 the impulses nu. */
TN_API int tn_constrain_velocities(tn_system* system, double dt, tn_const_points x, tn_points v,
                                   const tn_wanted* wanted, tn_report* report);

/* ---- an instant ---- */

/** Accelerations w (data may be null) and multipliers at (x, v) under the host's forces f. The virial is exact: with
 * rigid molecules the atomic and the molecular pressure agree to rounding; multipliers of a step agree to O(dt) only.
 */
TN_API int tn_solve(tn_system* system, tn_const_points x, tn_const_points v, tn_const_points f, tn_points w,
                    const tn_wanted* wanted, tn_report* report);
/** f -= K S^-1 K'M^-1 f: what is left moves no constraint. For minimisers; without masses of their own: all masses 1.
 * Its virial, stress and multipliers are those of tn_solve with velocities 0.
 */
TN_API int tn_project_forces(tn_system* system, tn_const_points x, tn_points f, tn_report* report);
/** The nearest x on the constraints in the M-norm, from anywhere: for starts, before the first forces. */
TN_API int tn_project_positions(tn_system* system, tn_points x, tn_report* report);
/** ln det S at x and, where `gradient` has data, its derivative: Fixman's metric force is -kT/2 times that. */
TN_API int tn_log_det(tn_system* system, tn_const_points x, double* value, tn_points gradient);
/** Largest |xi|/length at x and its row. */
TN_API int tn_violation(tn_system* system, tn_const_points x, tn_report* report);
/** Degrees of freedom that the constraints take at x: the rank of K, also where rows depend on others. `group` (may be
 * null: all) [tn_num_points]: of the points with an entry that is not 0; each independent row counts by its share of
 * such points among those of its points that move. */
TN_API int tn_removed_dof(tn_system* system, tn_const_points x, const uint8_t* group, double* removed);

/* ---- the time loop, for a host that has none ---- */

/** Where a run is after a step. */
typedef struct tn_progress {
  uint32_t size;
  size_t steps; /**< done so far */
  double time;
  const tn_report* positions;  /**< of the step's tn_constrain_positions */
  const tn_report* velocities; /**< of its tn_constrain_velocities */
} tn_progress;

/** Steps of velocity Verlet. */
typedef struct tn_loop {
  uint32_t size;    /**< sizeof(tn_loop) */
  int32_t measures; /**< see tn_wanted */
  double dt;        /**< not 0; negative: backwards */
  double time;      /**< where the run begins */
  size_t steps;
  tn_points x,
      v;       /**< they obey the constraints, and are those of the run's end. Supports go on with their velocities */
  tn_points f; /**< the forces at x, also where the run begins */
  /** Writes them, at x as it is now, which is that of this time. Null: they remain. */
  void (*set_forces)(void* user, double time);
  /** Called after every step; 0 ends the run there. It may edit the constraints, but not the points. May be null. */
  int (*observe)(void* user, const tn_progress* progress);
  void* user;
} tn_loop;

/** Runs. `steps` (may be null) receives how many were done; after a failure x, v and f are those of the last good
 * one. */
TN_API int tn_run(tn_system* system, const tn_loop* loop, size_t* steps);

/* ---- going on elsewhere ---- */

/** All that the next call depends on beside the host's arrays, masses, constraints and cell: where guesses begin,
 * ranks, whether it was cut into parts.
 * `*size`: room at `data`; receives what is needed. data = null: asks for that alone. */
TN_API int tn_save(tn_system* system, void* data, size_t* size);
/** For a system with the same points, masses and constraints, which goes on to the last bit. TN_EINVAL where the bytes
 * are damaged, or belong to another one. */
TN_API int tn_restore(tn_system* system, const void* data, size_t size);

#ifdef __cplusplus
}
#endif
#endif
