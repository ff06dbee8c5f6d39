#pragma once

#include <cstddef>

/// \file The thresholds that choose how S lambda = -b is solved: the solver, the order of elimination, the sizes of
/// tiles and chunks, the threads, and whether the tangent form is taken instead. Each names the program under bench/
/// that found it; run that program again before you change one. Where none is named, the words "argued, not measured"
/// and the argument stand instead.
///
/// These numbers stand elsewhere, each beside its only reader: tolerances of arithmetic (what counts as singular, when
/// a refinement or an iteration ends), the shapes of kernels that follow from the registers (`front_width`, `tile` of
/// columns), and the counts of operations that the thresholds are compared with.
namespace tanor::detail::plan {

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

/// Pieces that trees are cut into: branches of at least so many rods, at most so many rods, and so many pieces of a
/// tree of more rods if they are not too small or too large then. With fewer rods, the work around a group of pieces is
/// not worth its lanes; with more, they leave the first cache. Trees that leave more lanes empty than that get sparse
/// factors (bench/linear_solvers: trees).
inline constexpr std::size_t fewest_rods_of_branch = 2, most_rods_of_branch = 31, pieces_of_tree = 64,
                             rods_of_grove = 4096;
inline constexpr double fullness_of_trees = 0.3;

/// Limits of the work left to sparse factors beside special solvers, for each row of the latter. Beyond these limits,
/// the whole system gets one sparse factor, which is reused inside steps (see FactorReuse). The case measured is
/// clusters beside a net of 100 x 100. Steps of dop853 take as long on both if the net's factor takes 300 products for
/// each row of a cluster, and half as long on the sparse factor at 3000; with a smaller net all methods gain from the
/// mixture, up to 2.7 times (bench/step_cost). A row left over seldom takes fewer than 100 products, so no analysis is
/// made in vain if there are too many rows.
inline constexpr double most_sparse_rows = 3.0, most_sparse_products = 300.0;

// ---- sparse factors ----

/// Largest number of parts that are factorized side by side, and the rows below which a part is not worth its overhead
/// (bench/phases).
inline constexpr int most_parts = 16, least_rows_of_part = 512;

/// Flops per nonzero of L from which dense fronts, and nested dissection, repay their overhead (bench/phases: nets).
inline constexpr double flops_for_fronts = 8.0, flops_for_dissection = 50.0;

/// Cuts along an axis end at parts of this many points, cuts of the graph at parts of so many. Argued, not measured:
/// the rows between so few points fill their block of S anyway, whatever their order.
inline constexpr std::size_t most_points_of_leaf = 4, most_points_of_part = 8;
/// Cuts across an axis are tried only if the points reach this far along it, relative to the longest axis. Argued, not
/// measured: a cut across a shorter axis is longer, and so it parts more rows.
inline constexpr double least_extent = 0.75;
/// A half of a cut by METIS may have this many thousandths more of the points than its share. Argued, not measured: a
/// tenth lets METIS find cuts with fewer rows, and the halves stay comparable.
inline constexpr int imbalance_of_halves = 100;

/// Rows from which cuts along axes are tried before AMD (bench/orderings: on nets of 1000 AMD takes a quarter of the
/// whole ordering, and its order more flops).
inline constexpr std::size_t rows_worth_axes_first = 200'000;

/// Flops per nonzero of S from which METIS may repay its time, on the points and on the rows. METIS takes as long as
/// 1e4 and 4e4 flops per nonzero; a hundred factorizations are expected, and a gain of half and of a tenth
/// (bench/orderings).
inline constexpr double flops_worth_metis = 500.0, flops_worth_metis_on_rows = 5000.0;
/// METIS first cuts the points once, in a thirtieth of its time. It goes on if that cut parts fewer rows than this
/// factor times those of the first cut along an axis. The ratio is 0.7 and 0.8 in clouds of rods, where METIS then
/// needs half the flops; it is 1 and more in nets, tubes and lattices, also with holes, where METIS needs more flops
/// (bench/orderings).
inline constexpr double clearly_better_cut = 0.9;

/// Terms of a product of dense blocks that are worked on at once. Argued, not measured: the factor of 24 rows, 12 KiB,
/// stays in the first cache, and that of 512 columns in the second one.
inline constexpr std::size_t terms_of_product = 64;
/// Numbers of L that take as much time to read and write as it takes to enter another front. Columns share a front if
/// that stores no more numbers than this beyond those of both (bench/fronts: nets and lattices; times of 64 to 128
/// differ by less than a tenth, with 160 a solve of a net of 300 takes a sixth more).
inline constexpr std::size_t numbers_worth_a_front = 96;
/// Length from which a column of an update is added to the parent in whole lanes. Argued, not measured: in shorter
/// columns few rows follow each other, and the search for those that do takes longer than the additions.
inline constexpr std::size_t long_column = 48;
/// Rows and columns of a tile of a front; a multiple of the 24 rows and 8 columns of the kernels. Argued, not measured:
/// two factors of 192 x 64 numbers stay in the second cache, and a front above `products_of_tiled_front` has several
/// tiles.
inline constexpr std::size_t rows_of_tile = 192;
/// Panels in which an update looks for room, from its grandparent's on upwards. Argued, not measured: an update that
/// finds no room in this many seldom finds any.
inline constexpr std::size_t most_panels_tried = 16;

/// Size, rows^2 columns, from which the tiles of a front are separate tasks (bench/fronts: lattices).
inline constexpr double products_of_tiled_front = 2e7;
/// Least cost of a subtree that is one task, as a share of the total cost and in flops (bench/fronts).
inline constexpr double share_of_task = 1.0 / 64.0, least_cost_of_task = 1e6;
/// Flops of a factorization, and numbers of L in a solve, from which L is cut into tasks for several threads. Nets of
/// 300 and lattices of 20 gain 1.6 and more there (bench/fronts). Sizes between these and nets of 100 were not tried.
inline constexpr double flops_worth_threads = 1e8, numbers_worth_threads = 2e6;

/// Iterations that conjugate gradients are expected to take before the first solve (bench/reuse).
inline constexpr double first_guess_of_iterations = 4.0;
/// They are tried as long as a mean of the iterations of earlier solves costs less than a factor. `weight_of_mean` is
/// the weight of the mean so far beside the latest solve. `fading_of_mean` is the factor by which it falls where none
/// were made. Argued, not measured: the mean follows a change within some four solves, and iterations that cost twice
/// as much as a factor are tried again after some 350 solves.
inline constexpr double weight_of_mean = 0.75, fading_of_mean = 0.998;
/// Largest number of iterations, however much the factor costs. Argued, not measured: solves take some four iterations,
/// and one that has taken so many does not get on.
inline constexpr double most_iterations_of_reuse = 100.0;

// ---- which form of the equations is solved ----

/// Operations of both forms beside those of their factors: of the normal form for each nonzero of S and for each row of
/// K, of the tangent form for each product of H and for each moving point. The form with fewer operations is taken.
/// Argued, not measured: three multiplications and three additions assemble a product, and a row or a point costs some
/// 60 operations in K and phi, or in A and psi, and in the accelerations.
inline constexpr double flops_of_normal_entry = 6.0, flops_of_normal_row = 60.0;
inline constexpr double flops_of_tangent_product = 6.0, flops_of_tangent_point = 60.0;

// ---- threads and caches (bench/linear_solvers --threads) ----

inline constexpr std::size_t rows_of_lanes_worth_a_thread = 2048;
/// Products of S from which its assembly is worth a thread. A thread that sleeps takes longer to wake than a net of 30
/// points a side, with a third of that number, takes to assemble (bench/linear_solvers --threads 2: net 30).
inline constexpr std::size_t products_worth_a_thread = 16384;
/// Rods of a path that are eliminated one after the other in a lane before a separator. Measured with 32, 64 and 128
/// (bench/linear_solvers, chains): few enough that eight lanes stay in the first caches.
inline constexpr std::size_t most_rods_of_piece = 64;
/// Paths with fewer rods have none in lanes. Argued, not measured: two rods a lane are the least that share any work.
inline constexpr std::size_t fewest_rods_in_lanes = 16;
/// Method `taylor` cuts paths of so many rods into pieces for the lanes, and does shorter ones one by one.
inline constexpr std::size_t fewest_rods_of_cut_path = 64;
/// Part of the rows that may be left out of the lanes where `taylor` takes as many terms as if all had a lane. Terms of
/// the others cost some five times as much a row (bench/series: 1e4 clusters beside a net take 0.6 of the time so).
inline constexpr double most_left_of_cheap_terms = 0.1;
/// Groups of islands in lanes from which `taylor` takes more terms, since few groups need the last ones (bench/series:
/// a melt of 320 chains; a single chain of 1e5 rods is slower so).
inline constexpr std::size_t groups_that_differ = 8;
/// With fewer numbers of L, solves need no prefetching either. Argued, not measured: a megabyte fits the second cache
/// of most machines.
inline constexpr std::size_t numbers_beyond_cache = 1 << 17;
/// Solves of larger factors prefetch numbers of L this far ahead (bench/fronts: nets).
inline constexpr std::size_t numbers_fetched_ahead = 4096;

}  // namespace tanor::detail::plan
