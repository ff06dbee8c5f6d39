#include "schur/lane_transfers.hpp"

#include "base/instruction_sets.hpp"

namespace tanor::detail {

// ---- one by one: plain loads and stores, which no instruction set does better, but for points ----

namespace {

using Two [[gnu::vector_size(16), gnu::aligned(8), gnu::may_alias]] = double;

const double* at(const double* array, Index k) {
  return array + 3 * static_cast<std::size_t>(k);
}
double* at(double* array, Index k) {
  return array + 3 * static_cast<std::size_t>(k);
}

}  // namespace

template <bool are_blocks>
void gather(const double* from, const Index* numbers, std::size_t count, Pack3<>* to) {
  static constexpr double nowhere[3]{1.0, 0.0, 0.0};
  dispatch([=] {
    for (std::size_t p = 0; p < count; ++p) {
      const double* own[num_lanes];
      Pack<> sign{};
      for (std::size_t lane = 0; lane < num_lanes; ++lane) {
        const Index number = numbers[num_lanes * p + lane];
        const bool is_there = !are_blocks || number != no_block;
        own[lane] = is_there ? at(from, number < 0 ? ~number : number) : nowhere;
        if constexpr (are_blocks) sign[lane] = is_there && number < 0 ? -1.0 : 1.0;
      }
      const auto component = [&](std::size_t c) __attribute__((always_inline)) {
        const Pack<> all{own[0][c], own[1][c], own[2][c], own[3][c], own[4][c], own[5][c], own[6][c], own[7][c]};
        return are_blocks ? sign * all : all;
      };
      to[p].x = component(0);
      to[p].y = component(1);
      to[p].z = component(2);
    }
  });
}

template <bool are_blocks>
void scatter(const Pack3<>* from, const Index* numbers, std::size_t count, double* to) {
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    const double* lanes = reinterpret_cast<const double*>(from) + lane;
    const Index* number = numbers + lane;
    for (std::size_t k = 0; k < count; ++k, number += num_lanes, lanes += 3 * num_lanes) {
      if (are_blocks ? *number == no_block : *number < 0) continue;
      const double sign = are_blocks && *number < 0 ? -1.0 : 1.0;
      double* const a = at(to, *number < 0 ? ~*number : *number);
      *reinterpret_cast<Two*>(a) = Two{sign * lanes[0], sign * lanes[num_lanes]};
      a[2] = sign * lanes[2 * num_lanes];
    }
  }
}
template void gather<false>(const double*, const Index*, std::size_t, Pack3<>*);
template void gather<true>(const double*, const Index*, std::size_t, Pack3<>*);
template void scatter<false>(const Pack3<>*, const Index*, std::size_t, double*);
template void scatter<true>(const Pack3<>*, const Index*, std::size_t, double*);

void gather_rows(const double* from, const Index* rows, std::size_t count, Pack<>* to) {
  auto* const lanes = reinterpret_cast<double*>(to);
  for (std::size_t k = 0; k < count * num_lanes; ++k) lanes[k] = rows[k] < 0 ? 0.0 : from[rows[k]];
}

void scatter_rows(const Pack<>* from, const Index* rows, std::size_t count, double* to) {
  const auto* const lanes = reinterpret_cast<const double*>(from);
  for (std::size_t k = 0; k < count * num_lanes; ++k) {
    if (rows[k] >= 0) to[rows[k]] = lanes[k];
  }
}

// ---- sequences: each function is its own loop nest, so that every instruction set has all of it ----

namespace {

/// The addresses of the numbers of four lanes.
template <class Number>
struct FourSequences {
  Number *a, *b, *c, *d;

  [[gnu::always_inline]] FourSequences(Number* array, const Index* first, std::size_t width)
      : a(at(array, first[0], width)),
        b(at(array, first[1], width)),
        c(at(array, first[2], width)),
        d(at(array, first[3], width)) {}
  static Number* at(Number* array, Index first, std::size_t width) {
    return array + width * static_cast<std::size_t>(first);
  }
};

/// Calls tile(k) for four numbers of each lane from the k-th on; there are no fewer. The last tile overlaps the one
/// before it if needed.
template <class Tile>
[[gnu::always_inline]] inline void for_each_tile(std::size_t count, const Tile& tile) {
  for (std::size_t k = 0; k + 4 <= count; k += 4) tile(k);
  if (count % 4 != 0) tile(count - 4);
}

/// Moves `count` numbers of each lane. Where a register holds a pack, it is written as a whole, since a load of it
/// would wait for two halves to reach the cache.
template <std::size_t of_register>
[[gnu::always_inline]] inline void gather_numbers(const double* from, const Index* first, std::size_t width,
                                                  std::size_t count, double sign, Pack<>* to) {
  const FourSequences<const double> low(from, first, width), high(from, first + 4, width);
  const auto put = [&](std::size_t k, const Four& left, const Four& right) __attribute__((always_inline)) {
    if constexpr (of_register == num_lanes) {
      to[k] = sign * __builtin_shufflevector(left, right, 0, 1, 2, 3, 4, 5, 6, 7);
    } else {
      auto* const halves = reinterpret_cast<Four*>(to + k);
      halves[0] = sign * left;
      halves[1] = sign * right;
    }
  };
  for_each_tile(
      count, [&](std::size_t k) __attribute__((always_inline)) {
        Four a = four_at(low.a + k), b = four_at(low.b + k), c = four_at(low.c + k), d = four_at(low.d + k);
        Four e = four_at(high.a + k), f = four_at(high.b + k), g = four_at(high.c + k), h = four_at(high.d + k);
        transpose(&a, &b, &c, &d);
        transpose(&e, &f, &g, &h);
        put(k, a, e);
        put(k + 1, b, f);
        put(k + 2, c, g);
        put(k + 3, d, h);
      });
}

[[gnu::always_inline]] inline void scatter_numbers(const Pack<>* from, const Index* first, std::size_t width,
                                                   std::size_t count, double sign, double* to) {
  for (std::size_t lane = 0; lane < num_lanes; lane += 4) {
    const double* const lanes = reinterpret_cast<const double*>(from) + lane;
    const FourSequences<double> at(to, first + lane, width);
    const auto take = [&](std::size_t k) __attribute__((always_inline))->Four {
      return sign * four_at(lanes + k * num_lanes);
    };
    for_each_tile(
        count, [&](std::size_t k) __attribute__((always_inline)) {
          Four a = take(k), b = take(k + 1), c = take(k + 2), d = take(k + 3);
          transpose(&a, &b, &c, &d);
          four_to(at.a + k) = a;
          four_to(at.b + k) = b;
          four_to(at.c + k) = c;
          four_to(at.d + k) = d;
        });
  }
}

}  // namespace

void gather_sequences(const double* from, const Sequences& given, std::size_t width, Pack<>* to) {
  dispatch([=, first = given.first.data(), count = width * given.count,
            sign = given.sign]<std::size_t of_register>(std::type_identity<PackIn<of_register>>) {
    gather_numbers<of_register>(from, first, width, count, sign, to);
  });
}

void scatter_sequences(const Pack<>* from, const Sequences& given, std::size_t width, double* to) {
  dispatch([=, first = given.first.data(), count = width * given.count, sign = given.sign] {
    scatter_numbers(from, first, width, count, sign, to);
  });
}

void scatter_neighbours(const Pack3<>* from, std::size_t count, double* to) {
  dispatch([=] {
    for (std::size_t k = 0; k < count; ++k) store_points(from[k].x, from[k].y, from[k].z, to + 3 * num_lanes * k);
  });
}

void fill(Pack3<>* points, std::size_t count, Vec3 value) {
  dispatch([=] {
    const Pack<> nothing{};
    const Pack3<> everywhere{nothing + value.x, nothing + value.y, nothing + value.z};
    for (std::size_t p = 0; p < count; ++p) everywhere.write(&points[p]);
  });
}

}  // namespace tanor::detail
