#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include <tanor/system.hpp>

#include "base/pack.hpp"

/// \file Moves numbers between arrays of the system and lanes. The same number of eight islands, or pieces of them,
/// stands in the lanes of one vector.
namespace tanor::detail {

/// Gathers points or blocks of K [place][lane] that lie anywhere into lanes, or scatters them from lanes. A number ~p
/// stands for point p, which is not written, or for the negative of block p, whose sign follows from the direction of
/// u. The block of a lane without one is (1, 0, 0).
inline constexpr Index no_block = std::numeric_limits<Index>::min();
template <bool are_blocks>
void gather(const double* from, const Index* numbers, std::size_t count, Pack3<>* to);
template <bool are_blocks>
void scatter(const Pack3<>* from, const Index* numbers, std::size_t count, double* to);
/// Does the same with numbers of rows; those of row -1, which is missing, are 0.
void gather_rows(const double* from, const Index* rows, std::size_t count, Pack<>* to);
void scatter_rows(const Pack<>* from, const Index* rows, std::size_t count, double* to);

/// Things of each lane that follow one another in memory: `count` of them from first[lane] on, each of so many numbers,
/// four and more in all, which are moved times the sign.
struct Sequences {
  std::array<Index, num_lanes> first{};
  std::size_t count = 0;  ///< 0 if they do not follow, or are too few
  double sign = 1.0;
};
void gather_sequences(const double* from, const Sequences& given, std::size_t width, Pack<>* to);
void scatter_sequences(const Pack<>* from, const Sequences& given, std::size_t width, double* to);
/// Prefetches such sequences while something else is computed. The function is inlined, since gcc drops the call of a
/// function that does nothing else if it sees the body.
[[gnu::always_inline]] inline void call_for(const double* array, const Sequences& wanted, std::size_t width) {
  constexpr std::size_t line = 8;
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    const double* const own = array + width * static_cast<std::size_t>(wanted.first[lane]);
    for (std::size_t k = 0; k < width * wanted.count; k += line) __builtin_prefetch(own + k);
  }
}
[[gnu::always_inline]] inline void call_for(const Pack<>* array, std::size_t count) {
  for (std::size_t k = 0; k < count; ++k) __builtin_prefetch(array + k);
}
/// Scatters points that follow one another, eight to a place.
void scatter_neighbours(const Pack3<>* from, std::size_t count, double* to);

void fill(Pack3<>* points, std::size_t count, Vec3 value);

}  // namespace tanor::detail
