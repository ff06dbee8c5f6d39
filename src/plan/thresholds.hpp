#pragma once

#include <cstddef>

/// \file All thresholds that decide how S lambda = -b is solved. Each names the
/// program under bench/ that found it; run that program again before you change one. They are read by
/// make_composite_solver, take_equal_islands, partition_islands, analyze and Reuse.
namespace tanor::plan {

// ---- which islands a solver takes ----

/// Systems with fewer rows leave lanes and chunks nearly empty and get sparse factors (bench/rivals, the pendulum).
inline constexpr std::size_t fewest_rows = 8;

/// Batches take islands of up to this many rods if their topology has little fill. The numbers of a batch of larger
/// islands leave the first caches, and sparse factors or paths are as good (bench/linear_solvers: clusters, rings,
/// tetrahedra, melt).
inline constexpr std::size_t most_rods_of_batch = 128;
inline constexpr double most_flops_a_rod = 500.0;
/// Least share of the lanes that must hold an island. The second one is for paths that are long enough to be solved
/// alone.
inline constexpr double fullness_of_lanes = 0.5;
inline constexpr std::size_t long_path = 32;
inline constexpr double fullness_of_long_paths = 0.8;

/// Numbers of rods that a branch of a tree has if it is eliminated in lanes. With fewer rods, the work done rod by rod
/// is not worth the lanes; with more, they leave the first caches. `share_of_tree_in_lanes` is the least share of a
/// tree's points in lanes: with fewer, the tree solver gains no more than 1.3 over sparse factors
/// (bench/linear_solvers: trees).
inline constexpr std::size_t fewest_rods_of_branch = 2, most_rods_of_branch = 127;
inline constexpr double share_of_tree_in_lanes = 0.5;

/// Limits of the work left to sparse factors beside special solvers, for each row of the latter. Beyond these limits,
/// the whole system gets one sparse factor, which is reused inside steps (see Reuse). The case measured is clusters
/// beside a net of 100 x 100. Steps of dop853 take as long on both if the net's factor takes 300 products for each row
/// of a cluster, and half as long on the sparse factor at 3000; with a smaller net all methods gain from the mixture,
/// up to 2.7 times (bench/step_cost). A row left over seldom takes fewer than 100 products, so no analysis is made in
/// vain if there are too many rows.
inline constexpr double most_sparse_rows = 3.0, most_sparse_products = 300.0;

// ---- sparse factors ----

/// Largest number of parts that are factorized side by side, and the rows below which a part is not worth its overhead
/// (bench/phases).
inline constexpr int most_parts = 16, least_rows_of_part = 512;

/// Flops per nonzero of L from which dense fronts, and nested dissection, repay their overhead (bench/phases: nets).
inline constexpr double flops_for_fronts = 8.0, flops_for_dissection = 50.0;

/// Flops per nonzero of S from which METIS may repay its time, on the points and on the rows. METIS takes as long as
/// 1e4 and 4e4 flops per nonzero; a hundred factorizations are expected, and a gain of half and of a tenth
/// (bench/orderings).
inline constexpr double flops_worth_metis = 500.0, flops_worth_metis_on_rows = 5000.0;
/// METIS first cuts the points once, in a thirtieth of its time. It goes on if that cut parts fewer rows than this
/// factor times those of the first cut along an axis. The ratio is 0.7 and 0.8 in clouds of rods, where METIS then
/// needs half the flops; it is 1 and more in nets, tubes and lattices, also with holes, where METIS needs more flops
/// (bench/orderings).
inline constexpr double clearly_better_cut = 0.9;

/// Size, rows^2 columns, from which the tiles of a front are separate tasks (bench/fronts: lattices).
inline constexpr double products_of_tiled_front = 2e7;
/// Least cost of a subtree that is one task, as a share of the total cost and in flops (bench/fronts).
inline constexpr double share_of_task = 1.0 / 64.0, least_cost_of_task = 1e6;
/// Flops of a factorization, and numbers of L in a solve, from which more than one thread is used. Nets of 300 and
/// lattices of 20 gain 1.6 and more there (bench/fronts). Sizes between these and nets of 100 were not tried.
inline constexpr double flops_worth_threads = 1e8, numbers_worth_threads = 2e6;

/// Iterations that conjugate gradients are expected to take before the first solve (bench/reuse).
inline constexpr double first_guess_of_iterations = 4.0;

// ---- threads and caches (bench/linear_solvers --threads) ----

inline constexpr std::size_t rows_worth_a_thread = 4096, rows_of_batches_worth_a_thread = 2048,
                             groups_of_points_worth_a_thread = 256;
/// Largest number of groups of islands that are handed out to threads.
inline constexpr std::size_t most_groups_of_islands = 64;
/// At most this many paths are split into halves if there is more than one thread.
inline constexpr std::size_t few_paths = 8;
/// Points between two rows of a path from which they are accelerated in lanes (bench/compare_builds.py: chain.json by
/// rattle, 10 rods).
inline constexpr std::size_t fewest_points_in_lanes = 16;
/// With fewer rows, the data stay in the second cache of all machines and need no prefetching (about 140 bytes a row).
inline constexpr std::size_t rows_beyond_cache = 16384;
/// With fewer numbers of L, a megabyte, solves need no prefetching either (not searched for). Solves of larger factors
/// prefetch numbers of L this far ahead (bench/fronts: nets).
inline constexpr std::size_t numbers_beyond_cache = 1 << 17, numbers_fetched_ahead = 4096;

}  // namespace tanor::plan
