#pragma once

#include <cmath>
#include <cstddef>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "base/vec3.hpp"

/// \file Packs of numbers, or of points, side by side in one vector register. Functions that use packs are compiled
/// once for each instruction set (instruction_sets.hpp).
namespace tanor::detail {

// All functions that take or return packs are inlined, so no binary interface has to be kept.
#pragma GCC diagnostic ignored "-Wpsabi"

inline constexpr std::size_t num_lanes = 8;

template <std::size_t N>
struct PackOf {
  using Type [[gnu::vector_size(N * sizeof(double)), gnu::aligned(N * sizeof(double))]] = double;
};
/// N numbers side by side in one vector register. A pack is aligned, since an unaligned load would touch two cache
/// lines.
template <std::size_t N = num_lanes>
using Pack = typename PackOf<N>::Type;

/// N points side by side, with a pack for each component.
template <std::size_t N = num_lanes>
struct Pack3 {
  Pack<N> x, y, z;

  [[gnu::always_inline]] friend Pack3 operator+(const Pack3& a, const Pack3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  [[gnu::always_inline]] friend Pack3 operator-(const Pack3& a, const Pack3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  [[gnu::always_inline]] friend Pack3 operator*(const Pack<N>& s, const Pack3& a) {
    return {s * a.x, s * a.y, s * a.z};
  }
  [[gnu::always_inline]] friend Pack3 operator*(const Pack3& a, const Pack3& b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
  }
  [[gnu::always_inline]] friend Pack<N> dot(const Pack3& a, const Pack3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
  }
  [[gnu::always_inline]] Pack<N> sum() const { return x + y + z; }
  /// Copies component by component. gcc copies a whole Pack3 through the stack, in pieces of another size than those
  /// that were stored there.
  [[gnu::always_inline]] void write(Pack3* to) const {
    to->x = x;
    to->y = y;
    to->z = z;
  }
};

/// Loads and stores eight numbers at any address. The load returns a value: if a reference to a Pack<> were bound to an
/// UnalignedPack, clang would assume that its address is aligned.
using UnalignedPack [[gnu::vector_size(64), gnu::aligned(8), gnu::may_alias]] = double;
[[gnu::always_inline]] inline Pack<> pack_at(const double* place) {
  return *reinterpret_cast<const UnalignedPack*>(place);
}
[[gnu::always_inline]] inline UnalignedPack& pack_to(double* place) {
  return *reinterpret_cast<UnalignedPack*>(place);
}

/// Eight numbers in registers of `width` lanes each. `dispatch` passes this type to bodies that ask for it. gcc keeps a
/// pack that is wider than a register in memory, so that every sum goes through memory: fronts took ten times as long
/// with AVX2.
template <std::size_t width>
struct PackIn {
  static constexpr std::size_t num_parts = num_lanes / width;
  static constexpr std::size_t num_registers = width == 8 ? 32 : 16;
  /// Number of such packs that stay in registers beside the factors of a product.
  static constexpr std::size_t most_in_registers = (num_registers - 4) / num_parts;

  using Part = Pack<width>;
  using PartAnywhere [[gnu::vector_size(width * sizeof(double)), gnu::aligned(8), gnu::may_alias]] = double;
  Part parts[num_parts];

  [[gnu::always_inline]] static PackIn at(const double* place) {
    PackIn result;
    for (std::size_t k = 0; k < num_parts; ++k)
      result.parts[k] = *reinterpret_cast<const PartAnywhere*>(place + width * k);
    return result;
  }
  /// Puts get(0), …, get(7) side by side; get() takes compile-time constants.
  template <class Get>
  [[gnu::always_inline]] static PackIn of(const Get& get) {
    PackIn result;
    const auto put = [&]<std::size_t... lane>(auto part, std::index_sequence<lane...>) __attribute__((always_inline)) {
      result.parts[part] = Part{get(std::integral_constant<std::size_t, part * width + lane>{})...};
    };
    [&]<std::size_t... part>(std::index_sequence<part...>) __attribute__((always_inline)) {
      (put(std::integral_constant<std::size_t, part>{}, std::make_index_sequence<width>{}), ...);
    }
    (std::make_index_sequence<num_parts>{});
    return result;
  }
  /// Returns these numbers, and those of `others` in the lanes for which from_others(lane) is true.
  template <class FromOthers>
  [[gnu::always_inline]] PackIn blended_with(const PackIn& others, const FromOthers&) const {
    constexpr FromOthers from_others;
    PackIn result;
    const auto blend = [&]<std::size_t... lane>(auto part, std::index_sequence<lane...>)
        __attribute__((always_inline)) {
      result.parts[part] = __builtin_shufflevector(parts[part], others.parts[part],
                                                   (from_others(part * width + lane) ? width + lane : lane)...);
    };
    [&]<std::size_t... part>(std::index_sequence<part...>) __attribute__((always_inline)) {
      (blend(std::integral_constant<std::size_t, part>{}, std::make_index_sequence<width>{}), ...);
    }
    (std::make_index_sequence<num_parts>{});
    return result;
  }
  /// Returns these numbers with x in one lane.
  template <std::size_t lane>
  [[gnu::always_inline]] PackIn with(double x) const {
    PackIn all;
    for (std::size_t k = 0; k < num_parts; ++k) all.parts[k] = Part{} + x;
    return blended_with(all, [](std::size_t each) { return each == lane; });
  }
  [[gnu::always_inline]] void write(double* place) const {
    for (std::size_t k = 0; k < num_parts; ++k) *reinterpret_cast<PartAnywhere*>(place + width * k) = parts[k];
  }
  [[gnu::always_inline]] PackIn& operator+=(const PackIn& a) {
    for (std::size_t k = 0; k < num_parts; ++k) parts[k] += a.parts[k];
    return *this;
  }
  [[gnu::always_inline]] PackIn& operator-=(const PackIn& a) {
    for (std::size_t k = 0; k < num_parts; ++k) parts[k] -= a.parts[k];
    return *this;
  }
  [[gnu::always_inline]] friend PackIn operator+(const PackIn& a, const PackIn& b) {
    PackIn result = a;
    return result += b;
  }
  [[gnu::always_inline]] friend PackIn operator-(const PackIn& a, const PackIn& b) {
    PackIn result = a;
    return result -= b;
  }
  [[gnu::always_inline]] friend PackIn operator*(double s, const PackIn& a) {
    PackIn result;
    for (std::size_t k = 0; k < num_parts; ++k) result.parts[k] = s * a.parts[k];
    return result;
  }
  [[gnu::always_inline]] friend PackIn operator*(const PackIn& a, const PackIn& b) {
    PackIn result;
    for (std::size_t k = 0; k < num_parts; ++k) result.parts[k] = a.parts[k] * b.parts[k];
    return result;
  }
  /// Adds neighbouring lanes, then pairs, then fours, in the same order for any width.
  [[gnu::always_inline]] double sum() const {
    const auto lane = [this](std::size_t k) __attribute__((always_inline)) {
      return parts[k / width][k % width];
    };
    return ((lane(0) + lane(1)) + (lane(2) + lane(3))) + ((lane(4) + lane(5)) + (lane(6) + lane(7)));
  }
};

/// Four numbers. Both AVX2 and AVX-512 can shuffle them.
using Four = Pack<4>;
using FourAnywhere [[gnu::vector_size(32), gnu::aligned(8), gnu::may_alias]] = double;
[[gnu::always_inline]] inline Four four_at(const double* place) {
  return *reinterpret_cast<const FourAnywhere*>(place);
}
[[gnu::always_inline]] inline FourAnywhere& four_to(double* place) {
  return *reinterpret_cast<FourAnywhere*>(place);
}

/// Loads four consecutive points: x y z x | y z x y | z x y z
[[gnu::always_inline]] inline void load_four_points(const double* from, Four* x, Four* y, Four* z) {
  const Four a = four_at(from), b = four_at(from + 4), c = four_at(from + 8);
  const Four ab = __builtin_shufflevector(a, b, 0, 1, 6, 3), x_0321 = __builtin_shufflevector(ab, c, 0, 5, 2, 3);
  const Four ba = __builtin_shufflevector(b, a, 0, 5, 2, 3), y_1032 = __builtin_shufflevector(ba, c, 0, 1, 6, 3);
  const Four cb = __builtin_shufflevector(c, b, 0, 5, 2, 3), z_2103 = __builtin_shufflevector(cb, a, 0, 1, 6, 3);
  *x = __builtin_shufflevector(x_0321, x_0321, 0, 3, 2, 1);
  *y = __builtin_shufflevector(y_1032, y_1032, 1, 0, 3, 2);
  *z = __builtin_shufflevector(z_2103, z_2103, 2, 1, 0, 3);
}
[[gnu::always_inline]] inline void store_four_points(const Four& x, const Four& y, const Four& z, double* to) {
  const Four x_0321 = __builtin_shufflevector(x, x, 0, 3, 2, 1), y_1032 = __builtin_shufflevector(y, y, 1, 0, 3, 2),
             z_2103 = __builtin_shufflevector(z, z, 2, 1, 0, 3);
  const Four xy = __builtin_shufflevector(x_0321, y_1032, 0, 5, 2, 3),
             yz = __builtin_shufflevector(y_1032, z_2103, 0, 5, 2, 3),
             zx = __builtin_shufflevector(z_2103, x_0321, 0, 5, 2, 3);
  four_to(to) = __builtin_shufflevector(xy, z_2103, 0, 1, 6, 3);
  four_to(to + 4) = __builtin_shufflevector(yz, x_0321, 0, 1, 6, 3);
  four_to(to + 8) = __builtin_shufflevector(zx, y_1032, 0, 1, 6, 3);
}

/// Loads eight consecutive points: x y z x y z …
[[gnu::always_inline]] inline void load_points(const double* from, Pack<>* x, Pack<>* y, Pack<>* z) {
  Four x0, y0, z0, x1, y1, z1;
  load_four_points(from, &x0, &y0, &z0);
  load_four_points(from + 12, &x1, &y1, &z1);
  *x = __builtin_shufflevector(x0, x1, 0, 1, 2, 3, 4, 5, 6, 7);
  *y = __builtin_shufflevector(y0, y1, 0, 1, 2, 3, 4, 5, 6, 7);
  *z = __builtin_shufflevector(z0, z1, 0, 1, 2, 3, 4, 5, 6, 7);
}
[[gnu::always_inline]] inline void store_points(const Pack<>& x, const Pack<>& y, const Pack<>& z, double* to) {
  const Four x0 = __builtin_shufflevector(x, x, 0, 1, 2, 3), x1 = __builtin_shufflevector(x, x, 4, 5, 6, 7);
  const Four y0 = __builtin_shufflevector(y, y, 0, 1, 2, 3), y1 = __builtin_shufflevector(y, y, 4, 5, 6, 7);
  const Four z0 = __builtin_shufflevector(z, z, 0, 1, 2, 3), z1 = __builtin_shufflevector(z, z, 4, 5, 6, 7);
  store_four_points(x0, y0, z0, to);
  store_four_points(x1, y1, z1, to + 12);
}

/// Transposes a 4 x 4 matrix: lane k of the i-th vector becomes lane i of the k-th.
[[gnu::always_inline]] inline void transpose(Four* a, Four* b, Four* c, Four* d) {
  const Four ab_02 = __builtin_shufflevector(*a, *b, 0, 4, 2, 6), ab_13 = __builtin_shufflevector(*a, *b, 1, 5, 3, 7);
  const Four cd_02 = __builtin_shufflevector(*c, *d, 0, 4, 2, 6), cd_13 = __builtin_shufflevector(*c, *d, 1, 5, 3, 7);
  *a = __builtin_shufflevector(ab_02, cd_02, 0, 1, 4, 5);
  *b = __builtin_shufflevector(ab_13, cd_13, 0, 1, 4, 5);
  *c = __builtin_shufflevector(ab_02, cd_02, 2, 3, 6, 7);
  *d = __builtin_shufflevector(ab_13, cd_13, 2, 3, 6, 7);
}

inline Vec3 lane_of(const Pack3<>& points, std::size_t lane) {
  return {points.x[lane], points.y[lane], points.z[lane]};
}
inline void set_lane(Pack3<>* points, std::size_t lane, Vec3 value) {
  points->x[lane] = value.x;
  points->y[lane] = value.y;
  points->z[lane] = value.z;
}

template <class Lane>
[[gnu::always_inline]] inline void take_roots(Lane* squares) {
#pragma GCC unroll 1
  for (std::size_t lane = 0; lane < sizeof(Lane) / sizeof(double); ++lane)
    (*squares)[lane] = std::sqrt((*squares)[lane]);
}

/// Normalizes a = (x, y, z) and writes 1/|a|, with the length before, to `inverse`.
template <class Lane>
[[gnu::always_inline]] inline void normalise(Lane* x, Lane* y, Lane* z, Lane* inverse) {
  Lane length = *x * *x + *y * *y + *z * *z;
  take_roots(&length);
  *inverse = 1.0 / length;
  *x *= *inverse;
  *y *= *inverse;
  *z *= *inverse;
}

/// A list of packs, aligned so that each can be loaded at once.
class Packs {
 public:
  void resize(std::size_t size) { cells_.resize(size); }
  std::size_t size() const { return cells_.size(); }
  Pack<>* data() { return reinterpret_cast<Pack<>*>(cells_.data()); }
  const Pack<>* data() const { return reinterpret_cast<const Pack<>*>(cells_.data()); }

 private:
  struct alignas(Pack<>) Cell {
    double lanes[num_lanes] = {};
  };
  std::vector<Cell> cells_;
};

/// The largest absolute value seen so far. A NaN stays NaN.
struct Largest {
  Pack<> value{}, zero{};  // zero adds up 0 times each number seen: NaN if one was not finite

  void see(const Pack<>& magnitudes) {
    value = magnitudes > value ? magnitudes : value;
    zero += 0.0 * magnitudes;
  }
  double read() const {
    double result = 0.0;
    for (std::size_t lane = 0; lane < num_lanes; ++lane) result = larger(result, value[lane] + zero[lane]);
    return result;
  }
};

}  // namespace tanor::detail
