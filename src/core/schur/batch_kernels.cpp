#include "schur/batch_kernels.hpp"

#include <limits>

#include "base/distance.hpp"
#include "base/instruction_sets.hpp"
#include "base/parallel.hpp"

namespace tanor::detail {

// ---- in and out one by one: plain loads and stores, which no instruction set does better ----

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
  for (std::size_t lane = 0; lane < num_lanes; lane += 2) {
    double* lanes = reinterpret_cast<double*>(to) + lane;
    const Index* point = points + lane;
    for (std::size_t p = 0; p < count; ++p, point += num_lanes, lanes += 3 * num_lanes) {
      const double *const a = at(from, point[0]), *const b = at(from, point[1]);
      const Two a_xy = *reinterpret_cast<const Two*>(a), b_xy = *reinterpret_cast<const Two*>(b);
      *reinterpret_cast<Two*>(lanes) = Two{a_xy[0], b_xy[0]};
      *reinterpret_cast<Two*>(lanes + num_lanes) = Two{a_xy[1], b_xy[1]};
      *reinterpret_cast<Two*>(lanes + 2 * num_lanes) = Two{a[2], b[2]};
    }
  }
}

void scatter_points(const Pack3<>* from, const Index* points, std::size_t count, double* to) {
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    const double* lanes = reinterpret_cast<const double*>(from) + lane;
    const Index* point = points + lane;
    for (std::size_t p = 0; p < count; ++p, point += num_lanes, lanes += 3 * num_lanes) {
      double* const a = at(to, *point);
      *reinterpret_cast<Two*>(a) = Two{lanes[0], lanes[num_lanes]};
      a[2] = lanes[2 * num_lanes];
    }
  }
}

void gather_blocks(const double* from, const Index* blocks, std::size_t count, Pack3<>* u) {
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    double* lanes = reinterpret_cast<double*>(u) + lane;
    const Index* block = blocks + lane;
    for (std::size_t k = 0; k < count; ++k, block += num_lanes, lanes += 3 * num_lanes) {
      const double sign = *block < 0 ? -1.0 : 1.0;
      const double* const g = at(from, *block < 0 ? ~*block : *block);
      for (std::size_t c = 0; c < 3; ++c) lanes[c * num_lanes] = sign * g[c];
    }
  }
}

void scatter_blocks(const Pack3<>* u, const Index* blocks, std::size_t count, double* to) {
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    const double* lanes = reinterpret_cast<const double*>(u) + lane;
    const Index* block = blocks + lane;
    for (std::size_t k = 0; k < count; ++k, block += num_lanes, lanes += 3 * num_lanes) {
      const double sign = *block < 0 ? -1.0 : 1.0;
      double* const g = at(to, *block < 0 ? ~*block : *block);
      *reinterpret_cast<Two*>(g) = Two{sign * lanes[0], sign * lanes[num_lanes]};
      g[2] = sign * lanes[2 * num_lanes];
    }
  }
}

void gather_rows(const double* from, const Index* rows, std::size_t count, Pack<>* to) {
  auto* const lanes = reinterpret_cast<double*>(to);
  for (std::size_t k = 0; k < count * num_lanes; ++k) lanes[k] = from[rows[k]];
}

void scatter_rows(const Pack<>* from, const Index* rows, std::size_t count, double* to) {
  const auto* const lanes = reinterpret_cast<const double*>(from);
  for (std::size_t k = 0; k < count * num_lanes; ++k) to[rows[k]] = lanes[k];
}

// ---- numbers: each function is its own loop nest, so that every instruction set has all of it ----

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

/// Moves `count` numbers of each lane. `place(k)` returns where the k-th stands among the lanes and `sign(k)` its sign.
/// Where a register holds a pack, it is written as a whole, since a load of it would wait for two halves to reach the
/// cache.
template <std::size_t register_width, class Place, class Sign>
[[gnu::always_inline]] inline void gather_placed(const double* from, const Index* first, std::size_t width,
                                                 std::size_t count, const Place& place, const Sign& sign, Pack<>* to) {
  const FourSequences<const double> low(from, first, width), high(from, first + 4, width);
  const auto put = [&](std::size_t k, const Four& left, const Four& right) __attribute__((always_inline)) {
    if constexpr (register_width == num_lanes) {
      to[place(k)] = sign(k) * __builtin_shufflevector(left, right, 0, 1, 2, 3, 4, 5, 6, 7);
    } else {
      auto* const halves = reinterpret_cast<Four*>(to + place(k));
      halves[0] = sign(k) * left;
      halves[1] = sign(k) * right;
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

template <class Place, class Sign>
[[gnu::always_inline]] inline void scatter_placed(const Pack<>* from, const Index* first, std::size_t width,
                                                  std::size_t count, const Place& place, const Sign& sign, double* to) {
  for (std::size_t lane = 0; lane < num_lanes; lane += 4) {
    const double* const lanes = reinterpret_cast<const double*>(from) + lane;
    const FourSequences<double> at(to, first + lane, width);
    const auto take = [&](std::size_t k) __attribute__((always_inline))->Four {
      return sign(k) * four_at(lanes + place(k) * num_lanes);
    };
    if (count < 4) {
      for (std::size_t k = 0; k < count; ++k) {
        const Four value = take(k);
        at.a[k] = value[0];
        at.b[k] = value[1];
        at.c[k] = value[2];
        at.d[k] = value[3];
      }
      continue;
    }
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

constexpr auto same_place = [](std::size_t k) __attribute__((always_inline)) {
  return k;
};

}  // namespace

void gather_sequences(const double* from, const Index* first, std::size_t width, std::size_t count, double sign,
                      Pack<>* to) {
  dispatch([=]<std::size_t width_of>(std::type_identity<PackIn<width_of>>) {
    gather_placed<width_of>(
        from, first, width, count, same_place, [=](std::size_t) { return sign; }, to);
  });
}

void gather_following_points(const std::array<const double*, 2>& from, const Index* first, std::size_t count,
                             const std::array<Pack3<>*, 2>& to) {
  const double *const a = from[0], *const b = from[1];
  Pack3<>*const to_a = to[0], *const to_b = to[1];
  dispatch([=]<std::size_t width_of>(std::type_identity<PackIn<width_of>>) {
    const auto one = [](std::size_t) { return 1.0; };
    gather_placed<width_of>(a, first, 3, 3 * count, same_place, one, &to_a->x);
    gather_placed<width_of>(b, first, 3, 3 * count, same_place, one, &to_b->x);
  });
}

void scatter_sequences(const Pack<>* from, const Index* first, std::size_t width, std::size_t count, double sign,
                       double* to) {
  dispatch([=] {
    scatter_placed(
        from, first, width, count, same_place, [=](std::size_t) { return sign; }, to);
  });
}

void gather_sequences(const double* from, const Index* first, std::size_t width, const SequencePlaces& places,
                      Pack<>* to) {
  const int* const place = places.place.data();
  dispatch([=, sign = places.sign.data(),
            count = places.place.size()]<std::size_t width_of>(std::type_identity<PackIn<width_of>>) {
    gather_placed<width_of>(
        from, first, width, count, [=](std::size_t k) { return static_cast<std::size_t>(place[k]); },
        [=](std::size_t k) { return sign[k]; }, to);
  });
}

void scatter_sequences(const Pack<>* from, const Index* first, std::size_t width, const SequencePlaces& places,
                       double* to) {
  const int* const place = places.place.data();
  dispatch([=, sign = places.sign.data(), count = places.place.size()] {
    scatter_placed(
        from, first, width, count, [=](std::size_t k) { return static_cast<std::size_t>(place[k]); },
        [=](std::size_t k) { return sign[k]; }, to);
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

void add(const Pack3<>* from, std::size_t count, Pack3<>* to) {
  dispatch([=] {
    for (std::size_t p = 0; p < count; ++p) {
      to[p].x += from[p].x;
      to[p].y += from[p].y;
      to[p].z += from[p].z;
    }
  });
}

void add(Vec3 value, std::size_t count, Pack3<>* to) {
  dispatch([=] {
    for (std::size_t p = 0; p < count; ++p) {
      to[p].x += value.x;
      to[p].y += value.y;
      to[p].z += value.z;
    }
  });
}

namespace {

/// Returns r_j - r_i + offset of rod a.
[[gnu::always_inline]] inline Pack3<> distance(const IslandTopology& topology, std::size_t a, const Pack3<>* r,
                                               const Pack3<>* offsets) {
  const auto [i, j] = topology.rods[a];
  const Pack3<> result = r[j] - r[i];
  return offsets != nullptr ? result + offsets[a] : result;
}

}  // namespace

void evaluate_rods(const IslandTopology& topology, const Pack3<>* r, const Pack3<>* v, const Pack3<>* w0,
                   const Pack3<>* offsets, const Pack<>* second_derivatives, Pack3<>* u, Pack<>* b, Largest* largest) {
  dispatch([=, &topology] {
    Largest seen = *largest;
    for (std::size_t a = 0; a < topology.rods.size(); ++a) {
      const auto [i, j] = topology.rods[a];
      const Pack3<> velocity = v[j] - v[i];
      // rho = |a|, u = a/rho
      Pack3<> unit = distance(topology, a, r, offsets);
      Pack<> inverse;
      normalise(&unit.x, &unit.y, &unit.z, &inverse);
      Pack<> right = second_derivative_of_distance(unit, velocity, inverse);
      if (w0 != nullptr) right += dot(unit, w0[j] - w0[i]);
      if (second_derivatives != nullptr) right -= second_derivatives[a];
      seen.see(right < 0.0 ? -right : right);
      unit.write(&u[a]);
      b[a] = right;
    }
    *largest = seen;
  });
}

void evaluate_directions(const IslandTopology& topology, const Pack3<>* r, const Pack3<>* offsets, Pack3<>* u) {
  dispatch([=, &topology] {
    for (std::size_t a = 0; a < topology.rods.size(); ++a) {
      Pack3<> unit = distance(topology, a, r, offsets);
      Pack<> inverse;
      normalise(&unit.x, &unit.y, &unit.z, &inverse);
      unit.write(&u[a]);
    }
  });
}

void evaluate_values(const IslandTopology& topology, const Pack3<>* r, const Pack3<>* offsets, const Pack<>* lengths,
                     Pack<>* xi, Largest* largest) {
  dispatch([=, &topology] {
    Largest seen = *largest;
    for (std::size_t a = 0; a < topology.rods.size(); ++a) {
      const Pack3<> along = distance(topology, a, r, offsets);
      Pack<> rho = dot(along, along);
      take_roots(&rho);
      xi[a] = rho - lengths[a];
      seen.see((xi[a] < 0.0 ? -xi[a] : xi[a]) / lengths[a]);
    }
    *largest = seen;
  });
}

void evaluate_rates(const IslandTopology& topology, const Pack3<>* u, const Pack3<>* v, const Pack<>* first_derivatives,
                    Pack<>* rates, Largest* largest) {
  dispatch([=, &topology] {
    Largest seen = *largest;
    for (std::size_t a = 0; a < topology.rods.size(); ++a) {
      const auto [i, j] = topology.rods[a];
      Pack<> rate = dot(u[a], v[j] - v[i]);
      if (first_derivatives != nullptr) rate -= first_derivatives[a];
      seen.see(rate < 0.0 ? -rate : rate);
      rates[a] = rate;
    }
    *largest = seen;
  });
}

void move(const IslandTopology& topology, const Pack<>* inverse_mass, const Pack3<>* u, const Pack<>* rows,
          Pack3<>* points) {
  dispatch([=, &topology] {
    for (std::size_t a = 0; a < topology.rods.size(); ++a) {
      const auto [i, j] = topology.rods[a];
      const Pack3<> impulse = rows[a] * u[a];
      (points[i] - inverse_mass[i] * impulse).write(&points[i]);
      (points[j] + inverse_mass[j] * impulse).write(&points[j]);
    }
  });
}

namespace {

/// Factorizes S = L D L' and returns the least pivot over its diagonal, at most 1, or 0 if S is not positive definite.
[[gnu::always_inline]] inline Pack<> eliminate_columns(const IslandTopology& topology, const IslandSchedule& schedule,
                                                       const Pack<>* inverse_mass, const Pack3<>* u, Pack<>* factor) {
  const Pack<> nothing{};
  for (int slot = 0; slot < schedule.num_slots; ++slot) factor[slot] = nothing;
  for (const auto& [slot, a, b, point, sign] : schedule.products)
    factor[slot] += sign * inverse_mass[point] * dot(u[a], u[b]);
  Pack<> largest_inverse = nothing + 1.0;  // largest inverse of a scaled pivot
  for (const auto& [row, first, end, first_target] : schedule.columns) {
    const auto [i, j] = topology.rods[row];
    // The diagonal is g.g (1/m_i + 1/m_j) with g as it was rounded; its slot holds what earlier columns have
    // subtracted.
    const Pack<> diagonal = dot(u[row], u[row]) * (inverse_mass[i] + inverse_mass[j]);
    const Pack<> pivot = diagonal + factor[first], inverse = 1.0 / pivot, scaled = diagonal * inverse;
    // A pivot that is 0, negative or NaN makes the smallest one 0.
    const Pack<> checked = scaled > 0.0 ? scaled : nothing + HUGE_VAL;
    largest_inverse = checked > largest_inverse ? checked : largest_inverse;
    factor[first] = inverse;
    const int* target = schedule.targets.data() + first_target;
    for (int f = first + 1; f < end; ++f) {
      const Pack<> l = factor[f] * inverse;
      for (int e = f; e < end; ++e) factor[*target++] -= l * factor[e];
      factor[f] = l;
    }
  }
  return 1.0 / largest_inverse;
}

[[gnu::always_inline]] inline void substitute(const IslandSchedule& schedule, const Pack<>* factor, const Pack<>* b,
                                              Pack<>* x) {
  for (std::size_t a = 0; a < schedule.columns.size(); ++a) x[a] = -b[a];
  for (const auto& [row, first, end, targets] : schedule.columns) {
    const Pack<> known = x[row];
    for (int e = first + 1; e < end; ++e) x[schedule.slot_row[e]] -= factor[e] * known;
  }
  for (auto column = schedule.columns.rbegin(); column != schedule.columns.rend(); ++column) {
    Pack<> sum = x[column->row] * factor[column->first];
    for (int e = column->first + 1; e < column->end; ++e) sum -= factor[e] * x[schedule.slot_row[e]];
    x[column->row] = sum;
  }
}

}  // namespace

void eliminate(const IslandTopology& topology, const IslandSchedule& schedule, const Pack<>* inverse_mass,
               const Pack3<>* u, Pack<>* factor, Pack<>* smallest) {
  dispatch([=, &topology, &schedule] {
    const Pack<> found = eliminate_columns(topology, schedule, inverse_mass, u, factor);
    *smallest = found < *smallest ? found : *smallest;
  });
}

void solve_negative(const IslandSchedule& schedule, const Pack<>* factor, const Pack<>* b, Pack<>* x) {
  dispatch([=, &schedule] { substitute(schedule, factor, b, x); });
}

void eliminate_and_solve(const IslandTopology& topology, const IslandSchedule& schedule, const Pack<>* inverse_mass,
                         const Pack3<>* u, const Pack<>* b, Pack<>* factor, Pack<>* x, Pack<>* smallest) {
  dispatch([=, &topology, &schedule] {
    const Pack<> found = eliminate_columns(topology, schedule, inverse_mass, u, factor);
    *smallest = found < *smallest ? found : *smallest;
    substitute(schedule, factor, b, x);
  });
}

void apply(const IslandTopology& topology, const Pack<>* inverse_mass, const Pack3<>* u, const Pack<>* b,
           const Pack<>* lambda, const Largest& right_side, const Pack3<>* w0, Vec3 uniform, Pack3<>* w,
           LargestResiduals* found) {
  dispatch([=, &topology, &right_side] {
    Pack3<>* const dw = w;  // until w0 is added
    const Pack<> nothing{};
    const int num_points = topology.num_points, num_places = num_points + topology.num_supports;
    for (int p = 0; p < num_places; ++p) dw[p].x = dw[p].y = dw[p].z = nothing;
    for (std::size_t a = 0; a < topology.rods.size(); ++a) {
      const auto [i, j] = topology.rods[a];
      const Pack3<> force = lambda[a] * u[a];
      (dw[i] - force).write(&dw[i]);
      (dw[j] + force).write(&dw[j]);
    }
    for (int p = 0; p < num_places; ++p) {
      dw[p].x *= inverse_mass[p];
      dw[p].y *= inverse_mass[p];
      dw[p].z *= inverse_mass[p];
    }
    Largest seen;
    for (std::size_t a = 0; a < topology.rods.size(); ++a) {
      const auto [i, j] = topology.rods[a];
      const Pack<> left = dot(u[a], dw[j] - dw[i]) + b[a];
      seen.see(left < 0.0 ? -left : left);
    }
    for (int p = 0; w0 != nullptr && p < num_points; ++p) (w0[p] + dw[p]).write(&w[p]);
    for (int p = 0; w0 == nullptr && p < num_points; ++p) {
      w[p].x += uniform.x;
      w[p].y += uniform.y;
      w[p].z += uniform.z;
    }
    const Pack<> largest_b = right_side.value + right_side.zero, largest_left = seen.value + seen.zero;
    found->right_side.see(largest_b);
    found->residual.see(largest_left);
    found->own_residual.see(largest_left / (largest_b + std::numeric_limits<double>::min()));
  });
}

}  // namespace tanor::detail
