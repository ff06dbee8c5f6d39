#pragma once

#include <tanor/system.hpp>

#include "base/eight.hpp"
#include "schur/island_schedule.hpp"

/// \file Islands of one topology, eight at once: the same number of each in the lanes of one vector.
/// See instruction_sets.hpp.
namespace tanor {

/// In and out of lanes: numbers [place][lane] that lie anywhere.
void gather_points(const double* from, const Index* points, std::size_t count, Eight3* to);
void scatter_points(const Eight3* from, const Index* points, std::size_t count, double* to);
void gather_rows(const double* from, const Index* rows, std::size_t count, Eight* to);
void scatter_rows(const Eight* from, const Index* rows, std::size_t count, double* to);
/// Blocks of K, whose signs follow from the direction of u: block ~k stands for the negative of block k.
void gather_blocks(const double* from, const Index* blocks, std::size_t count, Eight3* u);
void scatter_blocks(const Eight3* u, const Index* blocks, std::size_t count, double* to);

/// The same where each lane's follow one another: `count` numbers from width first[lane] on, times `sign`.
void gather_sequences(const double* from, const Index* first, std::size_t width, std::size_t count, double sign,
                      Eight* to);
void scatter_sequences(const Eight* from, const Index* first, std::size_t width, std::size_t count, double sign,
                       double* to);
/// Has them brought into the caches, while something else is computed. Inlined, since gcc drops the call of a function
/// that does nothing else, where it sees it.
[[gnu::always_inline]] inline void call_for_sequences(const double* array, const Index* first, std::size_t width,
                                                      std::size_t count) {
  constexpr std::size_t line = 8;
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    const double* const own = array + width * static_cast<std::size_t>(first[lane]);
    for (std::size_t k = 0; k < count; k += line) __builtin_prefetch(own + k);
  }
}
[[gnu::always_inline]] inline void call_for(const Eight* array, std::size_t count) {
  for (std::size_t k = 0; k < count; ++k) __builtin_prefetch(array + k);
}
/// Points that follow one another, eight to a place.
void scatter_neighbours(const Eight3* from, std::size_t count, double* to);

void fill(Eight3* points, std::size_t count, Vec3 value);
void add(const Eight3* from, std::size_t count, Eight3* to);
void add(Vec3 value, std::size_t count, Eight3* to);

/// Per rod, from points r, v and w0 [point]: u along the rod, b = phi + K'w0, with offsets and the second derivatives
/// of lengths where these are not null. w0 may be null where it is the same for all.
void evaluate_rods(const IslandTopology& topology, const Eight3* r, const Eight3* v, const Eight3* w0,
                   const Eight3* offsets, const Eight* second_derivatives, Eight3* u, Eight* b, Largest* largest);

/// u along the rods.
void evaluate_directions(const IslandTopology& topology, const Eight3* r, const Eight3* offsets, Eight3* u);

/// xi [rod], and the largest of |xi|/length.
void evaluate_values(const IslandTopology& topology, const Eight3* r, const Eight3* offsets, const Eight* lengths,
                     Eight* xi, Largest* largest);

/// K'v + xi_t [rod] with rods along u; `first_derivatives` of lengths may be null.
void evaluate_rates(const IslandTopology& topology, const Eight3* u, const Eight3* v, const Eight* first_derivatives,
                    Eight* rates, Largest* largest);

/// points += M^-1 K rows
void move(const IslandTopology& topology, const Eight* inverse_mass, const Eight3* u, const Eight* rows,
          Eight3* points);

/// S = L D L' of rods along u: L below the diagonal and 1/D on it [slot]. `smallest` := the least of it and of the
/// pivots over their diagonals; 0 or less: not positive definite.
void eliminate(const IslandTopology& topology, const IslandSchedule& schedule, const Eight* inverse_mass,
               const Eight3* u, Eight* factor, Eight* smallest);

/// x := -S^-1 b [rod]; x may be b.
void solve_negative(const IslandSchedule& schedule, const Eight* factor, const Eight* b, Eight* x);

/// dw := M^-1 K lambda [point], 0 at supports, and the largest of |K'dw + b|.
void apply(const IslandTopology& topology, const Eight* inverse_mass, const Eight3* u, const Eight* b,
           const Eight* lambda, Eight3* dw, Largest* largest);

}  // namespace tanor
