#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>

#include "base/instruction_sets.hpp"
#include "base/pack.hpp"

/// \file Kernels whose lanes do not meet run over the lanes part by part, each as wide as a register of the instruction
/// set. gcc keeps a pack that is wider than a register in memory, which made them two to five times slower with AVX2.
namespace tanor::detail {

/// Some lanes of packs, as many as a register has.
template <std::size_t num>
class Part {
 public:
  static constexpr std::size_t width = num;
  using Lane = Pack<width>;
  using Vector = Pack3<width>;
  using Anywhere [[gnu::vector_size(width * sizeof(double)), gnu::aligned(8), gnu::may_alias]] = double;

  [[gnu::always_inline]] explicit Part(std::size_t number) : number_(number) {}
  /// Returns the first of its lanes.
  [[gnu::always_inline]] std::size_t first() const { return width * number_; }
  /// Puts get(0), get(1), … of its lanes side by side.
  template <class Get>
  [[gnu::always_inline]] static Lane put_together(const Get& get) {
    return [&]<std::size_t... lane>(std::index_sequence<lane...>) __attribute__((always_inline)) {
      return Lane{get(lane)...};
    }
    (std::make_index_sequence<width>{});
  }
  [[gnu::always_inline]] Lane& of(Pack<>& cell) const { return reinterpret_cast<Lane*>(&cell)[number_]; }
  [[gnu::always_inline]] const Lane& of(const Pack<>& cell) const {
    return reinterpret_cast<const Lane*>(&cell)[number_];
  }
  [[gnu::always_inline]] Vector of(const Pack3<>& cell) const { return {of(cell.x), of(cell.y), of(cell.z)}; }
  [[gnu::always_inline]] void write(const Vector& value, Pack3<>* cell) const {
    of(cell->x) = value.x;
    of(cell->y) = value.y;
    of(cell->z) = value.z;
  }
  /// Loads and stores numbers, or points, of eight that follow one another at `place`.
  [[gnu::always_inline]] Lane load(const double* place) const {
    return *reinterpret_cast<const Anywhere*>(place + width * number_);
  }
  [[gnu::always_inline]] void store(const Lane& value, double* place) const {
    *reinterpret_cast<Anywhere*>(place + width * number_) = value;
  }
  [[gnu::always_inline]] Vector load_points(const double* place) const {
    const double* const from = place + 3 * width * number_;
    Vector result;
    if constexpr (width == 8) {
      detail::load_points(from, &result.x, &result.y, &result.z);
    } else if constexpr (width == 4) {
      load_four_points(from, &result.x, &result.y, &result.z);
    } else {
      result = {Lane{from[0], from[3]}, Lane{from[1], from[4]}, Lane{from[2], from[5]}};
    }
    return result;
  }
  [[gnu::always_inline]] void store_points(const Vector& value, double* place) const {
    double* const to = place + 3 * width * number_;
    if constexpr (width == 8) {
      detail::store_points(value.x, value.y, value.z, to);
    } else if constexpr (width == 4) {
      store_four_points(value.x, value.y, value.z, to);
    } else {
      for (std::size_t lane = 0; lane < width; ++lane) {
        to[3 * lane] = value.x[lane];
        to[3 * lane + 1] = value.y[lane];
        to[3 * lane + 2] = value.z[lane];
      }
    }
  }

 private:
  std::size_t number_;
};

/// Calls body(part) for all lanes, part by part.
template <class Body>
[[gnu::always_inline]] inline void for_each_part(const Body& body) {
  dispatch([body]<std::size_t width>(std::type_identity<PackIn<width>>) {
    for (std::size_t part = 0; part < PackIn<width>::num_parts; ++part) body(Part<width>(part));
  });
}

template <class Lane>
[[gnu::always_inline]] inline Lane magnitude(const Lane& x) {
  return x < 0.0 ? -x : x;
}

/// The largest number that is seen in the lanes of a part.
template <std::size_t width>
struct Seen {
  using Lane = Pack<width>;
  Lane value{}, zero{};

  [[gnu::always_inline]] void see(const Lane& size) {
    value = size > value ? size : value;
    zero += 0.0 * size;
  }
  template <class Lanes>
  [[gnu::always_inline]] void write(const Lanes& part, Largest* to) const {
    Lane& largest = part.of(to->value);
    largest = value > largest ? value : largest;
    part.of(to->zero) += zero;
  }
};

}  // namespace tanor::detail
