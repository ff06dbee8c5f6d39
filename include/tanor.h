#ifndef TANOR_H
#define TANOR_H
/** \file
 * Exact constraints for a host's own time loop, in C: the interface of tanor::Constrainer (<tanor/constrainer.hpp>).
 *
 * The host owns every array and the time loop; a handle owns the plan, the factors and its scratch. Nothing throws,
 * prints or aborts, and a step allocates nothing once the handle is planned. Handles are independent: different ones
 * may be used by different threads at once, one handle by one thread at a time. Arrays handed to one call must not
 * overlap.
 *
 * Units are the host's own for lengths, times and masses; a force is mass * length / time^2.
 *
 * Rules of the binary interface: a struct that may grow begins with its `size`, which the caller sets to sizeof; what
 * lies beyond it is neither read nor written. A changed meaning changes TN_ABI. */
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

/** A system of points with their masses and the constraints between them. */
typedef struct tn_system tn_system;

/** Result of a call. Codes from 1 to 99 are mistakes of the caller; codes from 100 on are numerical outcomes. After a
 * code other than TN_OK no array has been changed. */
typedef enum tn_result {
  TN_OK = 0,
  TN_EINVAL = 1,     /**< wrong argument; see tn_last_error */
  TN_ENOMEM = 2,     /**< not enough memory; the handle can only be destroyed */
  TN_EINTERNAL = 3,  /**< defect of the library; the handle can only be destroyed */
  TN_SINGULAR = 101, /**< a constraint has no gradient here, or rows depend on each other */
  TN_CONTRADICTORY = 102,
  TN_NOT_CONVERGED = 103, /**< tn_last_error names the constraint; a shorter step may help */
  TN_NOT_FINITE = 104     /**< NaN or infinity in the host's arrays */
} tn_result;

/** Points of a host as it stores them. The three numbers of a point follow one another, and the next point begins
 * `stride` bytes further on (0 if packed). `index` gives the host's number of point i of this system and may be null;
 * with it, arrays in another order or with other points in between are read and written in place. The data is borrowed
 * for the call. */
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
  uint32_t size; /**< sizeof(tn_options) */
  /** Number of threads. 0 takes as many as OpenMP gives; OpenMP threads spin for some milliseconds after a call unless
   * OMP_WAIT_POLICY=passive is set. 1 starts no threads. */
  int32_t threads;
  /** Largest |xi|/length that tn_constrain_positions accepts. 0 iterates down to rounding, below 1e-13. */
  double tolerance;
  /** Not 0: tn_solve refines only if |K'w + phi| is above 1e-12 of its largest term. 0 refines down to rounding. */
  int32_t inexact;
} tn_options;

/** Optional output of a call; a null pointer costs nothing. */
typedef struct tn_wanted {
  uint32_t size;       /**< sizeof(tn_wanted) */
  int32_t measures;    /**< not 0: the report gets correction, worst_row, largest_turn, work and virial */
  double* multipliers; /**< [tn_num_rows] lambda; the tension of a rod is -lambda */
  tn_points forces;    /**< K lambda, the forces of the constraints on the points */
  /** Nine numbers for each point (packed if the stride is 0): r (x) F of each constraint, shared among its points. */
  tn_points stress;
} tn_wanted;

/** Results of a call, filled as far as `size` says. A member that has no meaning in a call is 0. */
typedef struct tn_report {
  uint32_t size;      /**< sizeof(tn_report) */
  int32_t iterations; /**< largest number over all islands */
  double violation;   /**< relative violation that remains */
  /** Largest change of a point's position, velocity or force, where a call changes one; 0 if not wanted. */
  double correction;
  int64_t worst_row; /**< row with that violation, see tn_row_name; -1 if not wanted */
  /** Largest rotation of a rod, rad, in tn_constrain_positions, where beyond 0.4 the step is too long, and in
   * tn_project_positions. */
  double largest_turn;
  /** Work of time-dependent lengths and of moving supports in this half of the step: in tn_constrain_positions and
   * tn_constrain_velocities. */
  double work;
  /** Sum of r (x) K lambda: xx yy zz xy xz yz. tn_project_positions and tn_violation have no multipliers. */
  double virial[6];
} tn_report;

/* ---- life ---- */

TN_API int tn_abi(void); /**< TN_ABI of the library */
/** Returns what `tanor --version` prints: "tanor 0.2.0", then three lines with the QR and the CHOLMOD of the library,
 * which decide the licence that a binary must follow, and the instruction set of the hot loops. */
TN_API const char* tn_version(void);

/** Creates a system of `num_points` points. A point of infinite mass is a support, which constraints never move.
 * `positions` are read in this call. `options` may be null. After a failure `*out` is null and tn_create_error() gives
 * the reason, for each thread its own. */
TN_API int tn_create(tn_system** out, size_t num_points, const double* masses, tn_const_points positions,
                     const tn_options* options);
TN_API void tn_destroy(tn_system* system); /**< null is allowed */
TN_API const char* tn_create_error(void);
/** Message of the last call that failed on this handle, valid until the next one fails. Never null. */
TN_API const char* tn_last_error(const tn_system* system);

/* ---- what is constrained ---- */

/* The constraints may change between steps. After tn_expect_edits the next call, or tn_plan, plans only the islands
 * that an edit has touched, with a few of their neighbours; without it, the first edit after planning makes everything
 * be planned again. An edit that fails changes nothing. Each constraint has an id, which is never used twice. Ids
 * ascend, and the rows are numbered in the order of the ids. */

/** Kinds of constraint for tn_add, each with its points and its parameters. The last parameter of a member is its own
 * and can be changed by tn_set_lengths. Neighbours in the list whose other parameters agree are stored as one group. */
typedef enum tn_kind {
  TN_ROD = 1,    /**< i, j; length */
  TN_ANGLE = 2,  /**< i, j, k; the cosine of the angle at j */
  TN_PLANE = 3,  /**< i; normal n (3), offset a: n.r = a */
  TN_SPHERE = 4, /**< i; center (3), radius */
  TN_LINE = 5,   /**< i; a point of the line (3), direction (3): two rows, no length */
  TN_CIRCLE = 6  /**< i; center (3), normal (3), radius: two rows */
} tn_kind;

/** Adds rods between the points i = pairs[2k] and j = pairs[2k + 1]. If `lengths` is null, each rod is as long as its
 * points are apart in the positions that the last call, or tn_create, began with. `images` (may be null) has three
 * integers for each rod, which then joins r_i and r_j + n0 a + n1 b + n2 c, see tn_set_box. `ids` [count] (may be
 * null) receives the ids. */
TN_API int tn_add_rods(tn_system* system, size_t count, const int32_t* pairs, const double* lengths,
                       const int32_t* images, int64_t* ids);
/** Adds constraints of one kind. `parameters` may be null for rods and angles, which then keep their present values. */
TN_API int tn_add(tn_system* system, tn_kind kind, size_t count, const int32_t* points, const double* parameters,
                  int64_t* ids);
TN_API int tn_remove(tn_system* system, size_t count, const int64_t* ids);
/** Sets lengths (cosines, offsets, radii) and their rates of change; null rates are zero. A constraint that was given a
 * nonzero rate once is read in every call, so that later changes of its length need no planning. */
TN_API int tn_set_lengths(tn_system* system, size_t count, const int64_t* ids, const double* lengths,
                          const double* rates);
/** Sets the masses of points. A finite mass must remain finite, an infinite one infinite. */
TN_API int tn_set_masses(tn_system* system, size_t count, const int32_t* points, const double* masses);
/** Renumbers the points when some come or go, for instance between ranks. Point i had the number from[i]; -1 marks a
 * new point. Points that are missing in `from` have left, and no constraint may hold them any more. `masses` and `x`
 * (data may be null) are the masses and the present positions of all points. A point that only changes its number
 * keeps its plan. */
TN_API int tn_renumber(tn_system* system, size_t num_points, const int64_t* from, const double* masses,
                       tn_const_points x);
/** Sets the edges of a periodic cell, rows a, b, c, from the next call on; they may change in every step. `repeats` are
 * three flags, all set if null. Rods join nearest images, wherever the host has wrapped its points. As soon as
 * `images` of some rod are given, rods join those images, and positions must never be wrapped. The first cell belongs
 * to the positions of tn_create and must be set before the first constraints are added. */
TN_API int tn_set_box(tn_system* system, const double cell[9], const int repeats[3]);
/** Announces that the constraints will change: islands are planned in parts from now on. */
TN_API int tn_expect_edits(tn_system* system);
/** Sets the cell of x_old for the next tn_constrain_positions. Without this call it is the cell of the last call if
 * x_old are the positions of that call bit by bit, else the present cell. */
TN_API int tn_set_old_box(tn_system* system, const double cell[9]);
/** Plans now what the next call would plan. `islands` (may be null) receives how many islands were planned. */
TN_API int tn_plan(tn_system* system, size_t* islands);
TN_API size_t tn_num_points(const tn_system* system);
TN_API size_t tn_num_rows(const tn_system* system);
/** Rows [first, first + count) of a constraint. */
TN_API int tn_rows(tn_system* system, int64_t id, size_t* first, size_t* count);
/** Writes the name of a row, such as "rod0[17]" (group and member as they were added), into `text`, cut off at `size`
 * bytes including the terminating zero. */
TN_API int tn_row_name(tn_system* system, size_t row, char* text, size_t size);

/* ---- a step: SHAKE and RATTLE ---- */

/** Moves the positions x, which the host reached from x_old, onto the constraints along M^-1 K(x_old):
 *
 *     x += M^-1 K(x_old) mu,   v += M^-1 K(x_old) mu / dt,   multipliers 2 mu/dt^2
 *
 * x_old must satisfy the constraints. v (data may be null) are the velocities at half of the step. `wanted` and
 * `report` may be null. If x_old are, bit by bit, the positions at which the last call ended, its factor is used
 * again. */
TN_API int tn_constrain_positions(tn_system* system, double dt, tn_const_points x_old, tn_points x, tn_points v,
                                  const tn_wanted* wanted, tn_report* report);
/** Projects v onto K(x)'v = 0 in the M-norm. The multipliers are 2 nu/dt, or the impulses nu if dt is 0. */
TN_API int tn_constrain_velocities(tn_system* system, double dt, tn_const_points x, tn_points v,
                                   const tn_wanted* wanted, tn_report* report);

/* ---- an instant ---- */

/** Computes accelerations w (data may be null) and multipliers at (x, v) under the host's forces f. The virial is
 * exact: with rigid molecules the atomic and the molecular pressure agree to rounding. The multipliers of a step agree
 * with these to O(dt) only. */
TN_API int tn_solve(tn_system* system, tn_const_points x, tn_const_points v, tn_const_points f, tn_points w,
                    const tn_wanted* wanted, tn_report* report);
/** Projects the forces, f += K lambda with S lambda = -K'M^-1 f, so that they do not act on the constraints. It serves
 * minimisers; if their variables have no masses, all masses are 1. */
TN_API int tn_project_forces(tn_system* system, tn_const_points x, tn_points f, const tn_wanted* wanted,
                             tn_report* report);
/** Finds the nearest x on the constraints in the M-norm, from any x. It serves starts, before the first forces. */
TN_API int tn_project_positions(tn_system* system, tn_points x, tn_report* report);
/** Computes ln det S at x and, if `gradient` has data, its derivative. Fixman's metric force is -kT/2 times that. */
TN_API int tn_log_det(tn_system* system, tn_const_points x, double* value, tn_points gradient);
/** Finds the largest |xi|/|gradient|/length at x and its row. */
TN_API int tn_violation(tn_system* system, tn_const_points x, tn_report* report);
/** Computes the degrees of freedom that the constraints remove at x: the rank of K, also where rows depend on others.
 * `group` [tn_num_points] restricts the count to the points with a nonzero entry: each independent row then counts by
 * the share of such points among its moving points. A null `group` means all points. */
TN_API int tn_removed_dof(tn_system* system, tn_const_points x, const uint8_t* group, double* removed);

/* ---- observables: docs/observables.md has their language ---- */

/** Adds an observable such as "max tension(rod0)", "load(support0)" or "moment(support0, z)". `number` (may be null)
 * receives its number. Names are those of rows; all supports together are "support0", in the order of the points, which
 * have the host's numbers. Only the host knows its forces one by one, so there is no potential(), energy(), pressure(),
 * virial() and friction(). A text that cannot be read is TN_EINVAL, with the column and what would be right. */
TN_API int tn_add_observable(tn_system* system, const char* text, size_t* number);
/** Removes an observable; those behind it move up by one. It serves those whose thing was removed. */
TN_API int tn_remove_observable(tn_system* system, size_t number);
/** Does what tn_solve does, and evaluates all observables; `time` is their t. If no observable needs forces, the data
 * of f may be null; then nothing is solved. In a periodic cell points stand at the images that their constraints join.
 * An edit makes the texts be read again; TN_EINVAL names one whose thing was removed, and nothing is observed. */
TN_API int tn_observe(tn_system* system, double time, tn_const_points x, tn_const_points v, tn_const_points f,
                      tn_points w, const tn_wanted* wanted, tn_report* report);
/** Writes the values at the last tn_observe, NaN before it: one for each column. `*size` is the room at `values` and
 * receives the number of values. If `values` is null, the call only asks for that number. */
TN_API int tn_observed(tn_system* system, size_t number, double* values, size_t* size);
/** Writes the name of the member whose value `max` or `min` took at the last tn_observe ("rod0[17]", or empty), as
 * tn_row_name does. */
TN_API int tn_observed_member(tn_system* system, size_t number, char* member, size_t size);
/** Writes the name of a column, such as "load(support0).x" or "tension(rod0): rod0[17]", as tn_row_name does. */
TN_API int tn_column_name(tn_system* system, size_t number, size_t column, char* text, size_t size);

typedef enum tn_which { TN_LEAST = 1, TN_LARGEST = 2 } tn_which;
/** Tells the least or the largest value of all calls of tn_observe, with its time and the member whose value it was
 * ("rod0[17]", or empty), as tn_row_name writes names. `part` is 0 for numbers, and 0, 1, 2 for x, y, z of vectors.
 * `value`, `time` and `member` may be null. */
TN_API int tn_extreme(tn_system* system, size_t number, size_t part, tn_which which, double* value, double* time,
                      char* member, size_t size);

/* ---- the time loop, for a host that has none ---- */

/** Progress of a run after a step. */
typedef struct tn_progress {
  uint32_t size;
  size_t steps; /**< number of steps done so far */
  double time;
  const tn_report* positions;  /**< report of the step's tn_constrain_positions */
  const tn_report* velocities; /**< report of the step's tn_constrain_velocities */
} tn_progress;

/** A run of velocity Verlet. */
typedef struct tn_loop {
  uint32_t size;    /**< sizeof(tn_loop) */
  int32_t measures; /**< as in tn_wanted */
  double dt;        /**< not 0; a negative value runs backwards */
  double time;      /**< start time of the run */
  size_t steps;
  /** Positions and velocities, which satisfy the constraints. They become those at the end of the run. Supports move on
   * with their velocities. */
  tn_points x, v;
  /** Forces at x, also at the start of the run. */
  tn_points f;
  /** Writes the forces at the present x, which belongs to this time. If null, the forces stay as they are. */
  void (*set_forces)(void* user, double time);
  /** Called after every step; a return of 0 ends the run. It may edit the constraints, but not the points. May be
   * null. */
  int (*observe)(void* user, const tn_progress* progress);
  void* user;
} tn_loop;

/** Runs the loop. `steps` (may be null) receives the number of steps done. After a failure x, v and f are those of the
 * last good step. */
TN_API int tn_run(tn_system* system, const tn_loop* loop, size_t* steps);

/* ---- going on elsewhere ---- */

/** Saves all that the next call depends on beside the host's arrays, masses, constraints and cell: the initial guesses,
 * the ranks, and whether the islands are planned in parts. `*size` is the room at `data` and receives the size needed.
 * If `data` is null, the call only asks for that size. */
TN_API int tn_save(tn_system* system, void* data, size_t* size);
/** Restores saved bytes in a system with the same points, masses and constraints, which then continues to the last bit.
 * Returns TN_EINVAL if the bytes are damaged or belong to another system. */
TN_API int tn_restore(tn_system* system, const void* data, size_t size);

#ifdef __cplusplus
}
#endif
#endif
