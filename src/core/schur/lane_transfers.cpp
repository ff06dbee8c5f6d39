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

void gather_points(const double* from, const Index* points, std::size_t count, Pack3<>* to) {
  dispatch([=] {
    for (std::size_t p = 0; p < count; ++p) {
      const double* own[num_lanes];
      for (std::size_t lane = 0; lane < num_lanes; ++lane) {
        const Index point = points[num_lanes * p + lane];
        own[lane] = from + 3 * static_cast<std::size_t>(point < 0 ? ~point : point);
      }
      const auto component = [&](std::size_t c) __attribute__((always_inline)) {
        return Pack<>{own[0][c], own[1][c], own[2][c], own[3][c], own[4][c], own[5][c], own[6][c], own[7][c]};
      };
      to[p].x = component(0);
      to[p].y = component(1);
      to[p].z = component(2);
    }
  });
}

void scatter_points(const Pack3<>* from, const Index* points, std::size_t count, double* to) {
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    const double* lanes = reinterpret_cast<const double*>(from) + lane;
    const Index* point = points + lane;
    for (std::size_t p = 0; p < count; ++p, point += num_lanes, lanes += 3 * num_lanes) {
      if (*point < 0) continue;
      double* const a = at(to, *point);
      *reinterpret_cast<Two*>(a) = Two{lanes[0], lanes[num_lanes]};
      a[2] = lanes[2 * num_lanes];
    }
  }
}

void gather_blocks(const double* from, const Index* blocks, std::size_t count, Pack3<>* u) {
  static constexpr double nowhere[3]{1.0, 0.0, 0.0};
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    double* lanes = reinterpret_cast<double*>(u) + lane;
    const Index* block = blocks + lane;
    for (std::size_t k = 0; k < count; ++k, block += num_lanes, lanes += 3 * num_lanes) {
      const bool is_turned = *block < 0 && *block != no_block;
      const double* const g = *block == no_block ? nowhere : at(from, is_turned ? ~*block : *block);
      for (std::size_t c = 0; c < 3; ++c) lanes[c * num_lanes] = (is_turned ? -1.0 : 1.0) * g[c];
    }
  }
}

void scatter_blocks(const Pack3<>* u, const Index* blocks, std::size_t count, double* to) {
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    const double* lanes = reinterpret_cast<const double*>(u) + lane;
    const Index* block = blocks + lane;
    for (std::size_t k = 0; k < count; ++k, block += num_lanes, lanes += 3 * num_lanes) {
      if (*block == no_block) continue;
      const double sign = *block < 0 ? -1.0 : 1.0;
      double* const g = at(to, *block < 0 ? ~*block : *block);
      *reinterpret_cast<Two*>(g) = Two{sign * lanes[0], sign * lanes[num_lanes]};
      g[2] = sign * lanes[2 * num_lanes];
    }
  }
}

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

/// Calls tile(k) for four numbers of each lane from the k-th on. The last tile overlaps the one before it if needed.
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
  if (count < 4) {
    for (std::size_t k = 0; k < count; ++k) {
      put(k, Four{low.a[k], low.b[k], low.c[k], low.d[k]}, Four{high.a[k], high.b[k], high.c[k], high.d[k]});
    }
    return;
  }
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
    for (std::size_t k = 0; count < 4 && k < count; ++k) {
      const Four value = take(k);
      at.a[k] = value[0];
      at.b[k] = value[1];
      at.c[k] = value[2];
      at.d[k] = value[3];
    }
    if (count < 4) continue;
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
