#pragma once

#include <cstddef>

/// \file Every number that decides how S lambda = -b is solved, with the program under bench/ that found it: run that
/// again before you change one. Who asks: make_composite_solver, take_equal_islands, partition_islands, analyze, Reuse.
namespace tanor::plan {

// ---- which islands a solver takes ----

/// Systems with fewer rows leave lanes and chunks nearly empty: sparse factors take them (bench/rivals, the pendulum).
inline constexpr std::size_t fewest_rows = 8;

/// Batches take islands up to so many rods of topologies with little fill; beyond, a batch's numbers leave the first
/// caches, and sparse factors or paths are as good (bench/linear_solvers: clusters, rings, tetrahedra, melt).
inline constexpr std::size_t most_rods_of_batch = 128;
inline constexpr double most_flops_a_rod = 500.0;
/// Lanes that must have an island of their own: half of them, and of paths that are long enough to be solved alone …
inline constexpr double fullness_of_lanes = 0.5;
inline constexpr std::size_t long_path = 32;
/// … four of five.
inline constexpr double fullness_of_long_paths = 0.8;

/// Rods of the branches of trees that are eliminated in lanes: with fewer, what is done rod by rod is not worth the
/// lanes, with more they leave the first caches. Of a tree that the tree solver takes, the points in lanes: without
/// them it gains no more than 1.3 over sparse factors (bench/linear_solvers: trees).
inline constexpr std::size_t fewest_rods_of_branch = 2, most_rods_of_branch = 127;
inline constexpr double share_of_tree_in_lanes = 0.5;

/// What sparse factors may have to do beside special solvers, for each row of those; beyond, all of the system gets one
/// sparse factor, which is re-used inside steps (see Reuse). Clusters beside a net of 100 x 100: steps of dop853 take
/// as long on both where the net's factor takes 300 products for each row of a cluster, half as long on the sparse
/// factor at 3000; with less of a net all methods gain from the mixture, up to 2.7 times (bench/step_cost). A row left
/// over seldom takes fewer than 100 products: no analysis is made in vain where there are too many rows.
inline constexpr double most_sparse_rows = 3.0, most_sparse_products = 300.0;

// ---- sparse factors ----

/// Parts that are factorized side by side, and the rows below which a part is not worth its overhead (bench/phases).
inline constexpr int most_parts = 16, least_rows_of_part = 512;

/// Flops per nonzero of L from which dense fronts repay their overhead, and nested dissection its own (bench/phases:
/// nets).
inline constexpr double flops_for_fronts = 8.0, flops_for_dissection = 50.0;

/// Flops per nonzero of S from which METIS may repay its time, on the points and on the rows: it takes as long as 1e4
/// and 4e4 of them. A hundred factorizations are expected, and a gain of half and of a tenth (bench/orderings).
inline constexpr double flops_worth_metis = 500.0, flops_worth_metis_on_rows = 5000.0;
/// METIS cuts the points once, in a thirtieth of its time; it goes on where that parts fewer rows than so many times
/// those of the first cut along an axis: 0.7 and 0.8 in clouds of rods, where METIS then needs half the flops, 1 and
/// more in nets, tubes and lattices, also such with holes, where it needs more (bench/orderings).
inline constexpr double clearly_better_cut = 0.9;

/// Fronts of which tiles are tasks: rows^2 columns (bench/fronts: lattices).
inline constexpr double products_of_tiled_front = 2e7;
/// Subtrees that are one task each: of the cost of all, in flops, and at least (bench/fronts).
inline constexpr double share_of_task = 1.0 / 64.0, least_cost_of_task = 1e6;
/// Flops of a factorization, and numbers of L in a solve, from which there are more threads than one. Nets of 300 and
/// lattices of 20 gain 1.6 and more there (bench/fronts); what lies between them and nets of 100 was not tried.
inline constexpr double flops_worth_threads = 1e8, numbers_worth_threads = 2e6;

/// Iterations that conjugate gradients are expected to take before a solve was made (bench/reuse).
inline constexpr double first_guess_of_iterations = 4.0;

// ---- threads and caches (bench/linear_solvers --threads) ----

inline constexpr std::size_t rows_worth_a_thread = 4096, rows_of_batches_worth_a_thread = 2048,
                             groups_of_points_worth_a_thread = 256;
/// Groups of islands that are handed out to threads.
inline constexpr std::size_t most_groups_of_islands = 64;
/// So few paths are split into halves where there are more threads than one.
inline constexpr std::size_t few_paths = 8;
/// Fewer rows stay in the second cache of all machines and need no prefetching (about 140 bytes each).
inline constexpr std::size_t rows_beyond_cache = 16384;
/// Nor do fewer numbers of L, a megabyte (not searched for); of more, solves fetch what they need so many numbers later
/// (bench/fronts: nets).
inline constexpr std::size_t numbers_beyond_cache = 1 << 17, numbers_fetched_ahead = 4096;

}  // namespace tanor::plan
