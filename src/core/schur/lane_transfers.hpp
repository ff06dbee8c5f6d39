#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include <tanor/system.hpp>

#include "base/pack.hpp"

/// \file Moves numbers between arrays of the system and lanes: one of each of eight islands, or pieces of them.
namespace tanor::detail {

/// Says what stands in the lanes. Points have three numbers; ~p stands for point p, which is not written. Blocks of K
/// have three, too; ~b stands for the negative of block b, whose sign follows from the direction of u, and `no_block`
/// for (1, 0, 0). Rows have one number; row -1 is missing, and 0.
enum class Listed { Points, Blocks, Rows };
inline constexpr Index no_block = std::numeric_limits<Index>::min();

/// Things of each lane that follow one another in memory: `count` of them from first[lane] on, moved times the sign.
struct Sequences {
  std::array<Index, num_lanes> first{};
  std::size_t count = 0;  ///< 0 if they do not follow, or have fewer than four numbers
  double sign = 1.0;
};

/// Things [place][lane] of a group. The first ones are moved as sequences if they are.
template <Listed kind>
class LaneList {
 public:
  /// Keeps the pointer.
  LaneList(const Index* numbers, std::size_t count);

  const Index* numbers() const { return numbers_; }
  const Sequences& in_order() const { return in_order_; }
  void read(const double* from, Pack<>* to) const;
  void read(const double* from, Pack3<>* to) const { read(from, &to->x); }
  /// Reads what stands in one place.
  void read_at(std::size_t place, const double* from, Pack<>* to) const;
  void write(const Pack<>* from, double* to) const;
  void write(const Pack3<>* from, double* to) const { write(&from->x, to); }
  /// Prefetches sequences while something else is computed. It is inlined, since gcc drops calls that do nothing else.
  [[gnu::always_inline]] void call_for(const double* array) const {
    constexpr std::size_t line = 8;
    for (std::size_t lane = 0; lane < num_lanes; ++lane) {
      const double* const own = array + width * static_cast<std::size_t>(in_order_.first[lane]);
      for (std::size_t k = 0; k < width * in_order_.count; k += line) __builtin_prefetch(own + k);
    }
  }

 private:
  static constexpr std::size_t width = kind == Listed::Rows ? 1 : 3;

  const Index* numbers_;
  std::size_t count_;
  Sequences in_order_;
  std::size_t to_write_;  // places that are written as sequences
};
[[gnu::always_inline]] inline void call_for(const Pack<>* array, std::size_t count) {
  for (std::size_t k = 0; k < count; ++k) __builtin_prefetch(array + k);
}

/// Scatters points that follow one another, eight to a place.
void scatter_neighbours(const Pack3<>* from, std::size_t count, double* to);

void fill(Pack3<>* points, std::size_t count, Vec3 value);

}  // namespace tanor::detail
