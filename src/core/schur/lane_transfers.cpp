#include "schur/lane_transfers.hpp"

#include <algorithm>

#include "base/instruction_sets.hpp"

namespace tanor::detail {

// ---- one by one: plain loads and stores, which no instruction set does better, but for points ----

namespace {

using Two [[gnu::vector_size(16), gnu::aligned(8), gnu::may_alias]] = double;

template <Listed kind>
void gather(const double* from, const Index* numbers, std::size_t count, Pack<>* to) {
  static constexpr std::size_t width = kind == Listed::Rows ? 1 : 3;
  static constexpr double nowhere[3]{kind == Listed::Blocks ? 1.0 : 0.0, 0.0, 0.0};
  dispatch([=] {
    for (std::size_t p = 0; p < count; ++p) {
      const double* own[num_lanes];
      Pack<> sign{};
      for (std::size_t lane = 0; lane < num_lanes; ++lane) {
        const Index number = numbers[num_lanes * p + lane];
        const bool is_there = kind == Listed::Points || (kind == Listed::Rows ? number >= 0 : number != no_block);
        own[lane] = is_there ? from + width * static_cast<std::size_t>(number < 0 ? ~number : number) : nowhere;
        sign[lane] = is_there && number < 0 ? -1.0 : 1.0;
      }
      const auto put = [&](std::size_t c) __attribute__((always_inline)) {
        const Pack<> all{own[0][c], own[1][c], own[2][c], own[3][c], own[4][c], own[5][c], own[6][c], own[7][c]};
        to[width * p + c] = kind == Listed::Blocks ? sign * all : all;
      };
      put(0);
      if constexpr (width == 3) {
        put(1);
        put(2);
      }
    }
  });
}

template <Listed kind>
void scatter(const Pack<>* from, const Index* numbers, std::size_t count, double* to) {
  constexpr std::size_t width = kind == Listed::Rows ? 1 : 3;
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    const double* lanes = reinterpret_cast<const double*>(from) + lane;
    const Index* number = numbers + lane;
    for (std::size_t k = 0; k < count; ++k, number += num_lanes, lanes += width * num_lanes) {
      if (kind == Listed::Blocks ? *number == no_block : *number < 0) continue;
      const double sign = *number < 0 ? -1.0 : 1.0;
      double* const a = to + width * static_cast<std::size_t>(*number < 0 ? ~*number : *number);
      if constexpr (width == 1) {
        *a = *lanes;
      } else {
        *reinterpret_cast<Two*>(a) = Two{sign * lanes[0], sign * lanes[num_lanes]};
        a[2] = sign * lanes[2 * num_lanes];
      }
    }
  }
}

/// Returns the sequences that the first ones of so many things form. All blocks of sequences are turned, or none is.
template <Listed kind>
Sequences find_sequences(const Index* numbers, std::size_t count) {
  const bool are_turned = kind == Listed::Blocks && numbers[0] < 0;
  const auto number = [&](std::size_t slot) {
    const Index own = numbers[slot];
    if (kind == Listed::Points) return own < 0 ? ~own : own;
    return own == no_block ? -1 : are_turned ? ~own : own;
  };
  Sequences result{.sign = are_turned ? -1.0 : 1.0};
  for (std::size_t lane = 0; lane < num_lanes; ++lane) result.first[lane] = number(lane);
  for (std::size_t slot = 0; slot < count * num_lanes; ++slot) {
    const auto k = static_cast<Index>(slot / num_lanes);
    if (number(slot) < 0 || number(slot) != result.first[slot % num_lanes] + k) break;
    result.count = (slot + 1) / num_lanes;
  }
  if ((kind == Listed::Rows ? 1 : 3) * result.count < 4) result.count = 0;
  return result;
}

}  // namespace

// ---- sequences: each function is its own loop nest, so that every instruction set has all of it ----

namespace {

/// Calls tile(k) for four numbers from the k-th on; there are no fewer. The last tile may overlap the one before.
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
  const auto at = [&](std::size_t lane, std::size_t k) __attribute__((always_inline)) {
    return four_at(from + width * static_cast<std::size_t>(first[lane]) + k);
  };
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
        Four a = at(0, k), b = at(1, k), c = at(2, k), d = at(3, k);
        Four e = at(4, k), f = at(5, k), g = at(6, k), h = at(7, k);
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
    const auto put = [&](std::size_t of, std::size_t k, const Four& numbers) __attribute__((always_inline)) {
      four_to(to + width * static_cast<std::size_t>(first[lane + of]) + k) = numbers;
    };
    const auto take = [&](std::size_t k) __attribute__((always_inline))->Four {
      return sign * four_at(lanes + k * num_lanes);
    };
    for_each_tile(
        count, [&](std::size_t k) __attribute__((always_inline)) {
          Four a = take(k), b = take(k + 1), c = take(k + 2), d = take(k + 3);
          transpose(&a, &b, &c, &d);
          put(0, k, a);
          put(1, k, b);
          put(2, k, c);
          put(3, k, d);
        });
  }
}

}  // namespace

template <Listed kind>
LaneList<kind>::LaneList(const Index* numbers, std::size_t count)
    : numbers_(numbers), count_(count), in_order_(find_sequences<kind>(numbers, count)), to_write_(in_order_.count) {
  if (kind != Listed::Points) return;
  const Index* const end = numbers + num_lanes * to_write_;
  to_write_ =
      static_cast<std::size_t>(std::find_if(numbers, end, [](Index each) { return each < 0; }) - numbers) / num_lanes;
  if (width * to_write_ < 4) to_write_ = 0;
}

template <Listed kind>
void LaneList<kind>::read(const double* from, Pack<>* to) const {
  const std::size_t first = in_order_.count;
  if (first > 0) {
    dispatch([=, places = in_order_.first.data(), count = width * first,
              sign = in_order_.sign]<std::size_t of_register>(std::type_identity<PackIn<of_register>>) {
      gather_numbers<of_register>(from, places, width, count, sign, to);
    });
  }
  if (first < count_) gather<kind>(from, numbers_ + num_lanes * first, count_ - first, to + width * first);
}

template <Listed kind>
void LaneList<kind>::read_at(std::size_t place, const double* from, Pack<>* to) const {
  gather<kind>(from, numbers_ + num_lanes * place, 1, to);
}

template <Listed kind>
void LaneList<kind>::write(const Pack<>* from, double* to) const {
  const std::size_t first = to_write_;
  if (first > 0) {
    dispatch([=, places = in_order_.first.data(), count = width * first, sign = in_order_.sign] {
      scatter_numbers(from, places, width, count, sign, to);
    });
  }
  if (first < count_) scatter<kind>(from + width * first, numbers_ + num_lanes * first, count_ - first, to);
}
template class LaneList<Listed::Points>;
template class LaneList<Listed::Blocks>;
template class LaneList<Listed::Rows>;

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
