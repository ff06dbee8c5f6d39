#pragma once

#include <array>
#include <vector>

#include <tanor/system.hpp>

#include "base/pack.hpp"
#include "schur/island_schedule.hpp"

/// \file Arithmetic of islands of one topology, eight at once. The same number of each island stands in the lanes of
/// one vector. See instruction_sets.hpp.
namespace tanor::detail {

/// Gathers numbers [place][lane] that lie anywhere into lanes, or scatters them from lanes.
void gather_points(const double* from, const Index* points, std::size_t count, Pack3<>* to);
void scatter_points(const Pack3<>* from, const Index* points, std::size_t count, double* to);
void gather_rows(const double* from, const Index* rows, std::size_t count, Pack<>* to);
void scatter_rows(const Pack<>* from, const Index* rows, std::size_t count, double* to);
/// Does the same for blocks of K, whose signs follow from the direction of u. Block ~k is the negative of block k.
void gather_blocks(const double* from, const Index* blocks, std::size_t count, Pack3<>* u);
void scatter_blocks(const Pack3<>* u, const Index* blocks, std::size_t count, double* to);

/// Does the same where the numbers of a lane follow one another: `count` from width first[lane] on, times `sign`.
void gather_sequences(const double* from, const Index* first, std::size_t width, std::size_t count, double sign,
                      Pack<>* to);
void scatter_sequences(const Pack<>* from, const Index* first, std::size_t width, std::size_t count, double sign,
                       double* to);
/// Says where the numbers of a sequence stand in the lanes: the k-th at place[k], times sign[k].
struct SequencePlaces {
  std::vector<int> place;
  std::vector<double> sign;
};
/// Does the same for sequences in another order than that of the lanes.
void gather_sequences(const double* from, const Index* first, std::size_t width, const SequencePlaces& places,
                      Pack<>* to);
void scatter_sequences(const Pack<>* from, const Index* first, std::size_t width, const SequencePlaces& places,
                       double* to);
/// Gathers `count` points of each lane, which follow one another, from two arrays at once.
void gather_following_points(const std::array<const double*, 2>& from, const Index* first, std::size_t count,
                             const std::array<Pack3<>*, 2>& to);
/// Prefetches such sequences while something else is computed. The function is inlined, since gcc drops the call of a
/// function that does nothing else if it sees the body.
[[gnu::always_inline]] inline void call_for_sequences(const double* array, const Index* first, std::size_t width,
                                                      std::size_t count) {
  constexpr std::size_t line = 8;
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    const double* const own = array + width * static_cast<std::size_t>(first[lane]);
    for (std::size_t k = 0; k < count; k += line) __builtin_prefetch(own + k);
  }
}
[[gnu::always_inline]] inline void call_for(const Pack<>* array, std::size_t count) {
  for (std::size_t k = 0; k < count; ++k) __builtin_prefetch(array + k);
}
/// Scatters points that follow one another, eight to a place.
void scatter_neighbours(const Pack3<>* from, std::size_t count, double* to);

void fill(Pack3<>* points, std::size_t count, Vec3 value);
void add(const Pack3<>* from, std::size_t count, Pack3<>* to);
void add(Vec3 value, std::size_t count, Pack3<>* to);

/// Evaluates u along each rod and b = phi + K'w0 from r, v and w0 [point], and the largest |b|. `offsets` and the
/// second derivatives of lengths may be null. w0 may be null if it is the same for all points.
void evaluate_rods(const IslandTopology& topology, const Pack3<>* r, const Pack3<>* v, const Pack3<>* w0,
                   const Pack3<>* offsets, const Pack<>* second_derivatives, Pack3<>* u, Pack<>* b, Largest* largest);

/// Evaluates u along the rods.
void evaluate_directions(const IslandTopology& topology, const Pack3<>* r, const Pack3<>* offsets, Pack3<>* u);

/// Evaluates xi [rod] and the largest |xi|/length.
void evaluate_values(const IslandTopology& topology, const Pack3<>* r, const Pack3<>* offsets, const Pack<>* lengths,
                     Pack<>* xi, Largest* largest);

/// Evaluates K'v + xi_t [rod] for rods along u. `first_derivatives` of lengths may be null.
void evaluate_rates(const IslandTopology& topology, const Pack3<>* u, const Pack3<>* v, const Pack<>* first_derivatives,
                    Pack<>* rates, Largest* largest);

/// Computes points += M^-1 K rows.
void move(const IslandTopology& topology, const Pack<>* inverse_mass, const Pack3<>* u, const Pack<>* rows,
          Pack3<>* points);

/// Factorizes S = L D L' of rods along u. `factor` [slot] holds L below the diagonal and 1/D on it. `smallest` becomes
/// the least of itself and of the pivots over their diagonals; it is 0 if S is not positive definite.
void eliminate(const IslandTopology& topology, const IslandSchedule& schedule, const Pack<>* inverse_mass,
               const Pack3<>* u, Pack<>* factor, Pack<>* smallest);

/// Computes x := -S^-1 b [rod]; x may be b.
void solve_negative(const IslandSchedule& schedule, const Pack<>* factor, const Pack<>* b, Pack<>* x);

/// Does both.
void eliminate_and_solve(const IslandTopology& topology, const IslandSchedule& schedule, const Pack<>* inverse_mass,
                         const Pack3<>* u, const Pack<>* b, Pack<>* factor, Pack<>* x, Pack<>* smallest);

/// The largest numbers of all batches of a solve: |b|, |K'dw + b|, and the latter over the largest |b| of its island.
struct LargestResiduals {
  Largest right_side, residual, own_residual;
};

/// Computes dw = M^-1 K lambda [point], 0 at supports, includes the residuals K'dw + b of the batch, whose largest |b|
/// are `right_side`, and writes w := w0 + dw. If w0 is null, it is `uniform` for all points.
void apply(const IslandTopology& topology, const Pack<>* inverse_mass, const Pack3<>* u, const Pack<>* b,
           const Pack<>* lambda, const Largest& right_side, const Pack3<>* w0, Vec3 uniform, Pack3<>* w,
           LargestResiduals* found);

}  // namespace tanor::detail
