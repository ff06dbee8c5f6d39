#pragma once

#include "schur/lane_kernels.hpp"

/// \file The three programs that eliminate S, see lane_kernels.hpp, for some lanes.
namespace tanor::detail::lanes {

// ---- pieces of trees ----

template <class Place>
[[gnu::always_inline]] inline MobilityOf<Place::width> get(const Place& place, const Mobility* mobility) {
  return {place.get(mobility, 0), place.get(mobility, 1), place.get(mobility, 2),
          place.get(mobility, 3), place.get(mobility, 4), place.get(mobility, 5)};
}

template <class Lanes, class Ends>
[[gnu::always_inline]] inline void eliminate_rod(const Lanes& part, const Ends& ends, std::size_t k, const Arrays& in,
                                                 typename Lanes::Lane* largest) {
  const auto u = part.of(in.u[k]);
  const auto parent = ends.second(part, k);
  const auto W = get(parent, in.mobility);
  const auto h = W * u;
  const auto pivot = dot(u, h) + dot(u, get(ends.first(part, k), in.mobility) * u), inverse = 1.0 / pivot;
  include(dot(u, u) * (part.of(in.inverse_mass[k]) + parent.get(in.inverse_mass, 0)) * inverse, largest);
  const auto scaled = inverse * h;
  parent.set(in.mobility, 0, W.xx - scaled.x * h.x);
  parent.set(in.mobility, 1, W.xy - scaled.x * h.y);
  parent.set(in.mobility, 2, W.xz - scaled.x * h.z);
  parent.set(in.mobility, 3, W.yy - scaled.y * h.y);
  parent.set(in.mobility, 4, W.yz - scaled.y * h.z);
  parent.set(in.mobility, 5, W.zz - scaled.z * h.z);
  part.write(scaled, &in.rod_factor(k).h);
  part.of(in.rod_factor(k).inverse_pivot) = inverse;
}

template <class Lanes, class Ends>
[[gnu::always_inline]] inline void substitute_rod(const Lanes& part, const Ends& ends, std::size_t k,
                                                  const Arrays& in) {
  const auto parent = ends.second(part, k);
  const auto of_parent = get(parent, in.s);
  const auto z = part.of(in.b[k]) + dot(part.of(in.u[k]), of_parent - part.of(in.s[k]));
  part.of(in.z[k]) = z;
  set(parent, in.s, of_parent - z * part.of(in.rod_factor(k).h));
}

// ---- pieces of paths ----

/// Eliminates the rods of a piece but for the separator, with take(k, &u), which returns b of rod k.
template <class Lanes, class Take>
[[gnu::always_inline]] inline void eliminate_piece(const Lanes& part, const Arrays& in, const Take& take,
                                                   typename Lanes::Lane* largest) {
  using Lane = typename Lanes::Lane;
  typename Lanes::Vector u, before{};
  Lane mass = part.of(in.inverse_mass[0]), inverse_before{}, y{}, spread = Lane{} + 1.0, taken{}, taken_y{};
  Border& border = *in.border;
  const std::size_t last = in.num_rods - 1;
  for (std::size_t k = 0;; ++k) {
    const Lane b = take(k, &u), mass_behind = part.of(in.inverse_mass[k + 1]);
    // S_aa = u.u (1/m + 1/m') with u as it was rounded, and S_ab = -u_a.u_b/m of the point between.
    const Lane diagonal = dot(u, u) * (mass + mass_behind), coupling = -mass * dot(before, u);
    const Lane l = coupling * inverse_before, pivot = diagonal - l * coupling;
    if (k > 0) {
      part.of(in.path_factor(k - 1).l) = l;
      spread = -l * spread;
    }
    y = -b - l * y;
    if (k == last) {
      part.of(border.inverse_mass_behind) = mass_behind;
      part.of(border.diagonal) = diagonal;
      part.of(border.pivot) = pivot;
      part.of(border.b) = b;
      break;
    }
    const Lane inverse = 1.0 / pivot, spike = spread * inverse;
    include(diagonal * inverse, largest);
    taken += spread * spike;
    part.of(in.path_factor(k).y) = y;
    taken_y += spike * y;
    part.of(in.path_factor(k).inverse_pivot) = inverse_before = inverse;
    before = u;
    mass = mass_behind;
  }
  part.write(part.of(in.u[0]), &border.first);
  part.write(u, &border.u);
  part.of(border.inverse_mass_before) = part.of(in.inverse_mass[0]);
  part.of(border.spread) = spread;
  part.of(border.taken) = taken;
  part.of(border.taken_y) = taken_y;
  part.of(border.y) = y;
}

template <class Lanes, class Ends>
[[gnu::always_inline]] inline void substitute_piece_up(const Lanes& part, const Ends& ends, const Arrays& in) {
  using Lane = typename Lanes::Lane;
  const auto right_side = [&](std::size_t k) __attribute__((always_inline)) {
    Lane right = -part.of(in.b[k]);
    if (in.s != nullptr) right -= dot(part.of(in.u[k]), difference(part, ends, k, in.s));
    return right;
  };
  Lane y = right_side(0), spread = Lane{} + 1.0, taken_y{};
  for (std::size_t k = 0; k + 1 < in.num_rods; ++k) {
    part.of(in.path_factor(k).y) = y;
    taken_y += spread * part.of(in.path_factor(k).inverse_pivot) * y;
    const Lane l = part.of(in.path_factor(k).l);
    spread = -l * spread;
    y = right_side(k + 1) - l * y;
  }
  part.of(in.border->b) = part.of(in.b[in.num_rods - 1]);
  part.of(in.border->y) = y;
  part.of(in.border->taken_y) = taken_y;
}

/// Computes lambda: D^-1 (y - spike) with the spike of the separator before, then L'^-1 of that.
template <class Lanes>
[[gnu::always_inline]] inline void substitute_piece_down(const Lanes& part, const Arrays& in) {
  using Lane = typename Lanes::Lane;
  const Border& border = *in.border;
  Lane spike = part.of(border.b_of_first), lambda = part.of(border.x);
  for (std::size_t k = 0; k + 1 < in.num_rods; ++k) {
    part.of(in.z[k]) = part.of(in.path_factor(k).y) - spike;
    spike = -part.of(in.path_factor(k).l) * spike;
  }
  part.of(in.z[in.num_rods - 1]) = lambda;
  for (std::size_t k = in.num_rods - 1; k-- > 0;) {
    const PathFactor& factor = in.path_factor(k);
    lambda = part.of(in.z[k]) * part.of(factor.inverse_pivot) - part.of(factor.l) * lambda;
    part.of(in.z[k]) = lambda;
  }
}

// ---- equal islands ----

/// Factorizes S = L D L'. The factor [slot] holds L below the diagonal and 1/D on it.
template <class Lanes>
[[gnu::always_inline]] inline void eliminate_columns(const Lanes& part, const Arrays& in,
                                                     typename Lanes::Lane* largest) {
  using Lane = typename Lanes::Lane;
  const IslandSchedule& schedule = *in.schedule;
  const auto u = [ part, from = in.u ](int k) __attribute__((always_inline)) {
    return part.of(from[k]);
  };
  const auto mass = [ part, from = in.inverse_mass ](int point) __attribute__((always_inline)) {
    return part.of(from[point]);
  };
  const auto factor = [ part, to = in.factor ](int slot) __attribute__((always_inline))->Lane& {
    return part.of(to[slot]);
  };
  for (int slot = 0; slot < schedule.num_slots; ++slot) factor(slot) = Lane{};
  for (const auto& [slot, a, b, point, sign] : schedule.products) factor(slot) += sign * mass(point) * dot(u(a), u(b));
  for (const auto& [row, first, end, first_target] : schedule.columns) {
    const auto [i, j] = schedule.topology.rods[static_cast<std::size_t>(row)];
    // The diagonal is u.u (1/m_i + 1/m_j) with u as it was rounded; its slot holds what earlier columns subtract.
    const Lane diagonal = dot(u(row), u(row)) * (mass(i) + mass(j));
    const Lane pivot = diagonal + factor(first), inverse = 1.0 / pivot;
    include(diagonal * inverse, largest);
    factor(first) = inverse;
    const int* target = schedule.targets.data() + first_target;
    for (int f = first + 1; f < end; ++f) {
      const Lane l = factor(f) * inverse;
      for (int e = f; e < end; ++e) factor(*target++) -= l * factor(e);
      factor(f) = l;
    }
  }
}

template <class Lanes>
[[gnu::always_inline]] inline void substitute(const Lanes& part, const EqualEnds& ends, const Arrays& in) {
  using Lane = typename Lanes::Lane;
  const IslandSchedule& schedule = *in.schedule;
  const auto factor = [ part, from = in.factor ](int slot) __attribute__((always_inline)) {
    return part.of(from[slot]);
  };
  const auto x = [ part, to = in.z ](std::size_t a) __attribute__((always_inline))->Lane& {
    return part.of(to[a]);
  };
  const auto row_of = [&](int slot) __attribute__((always_inline)) {
    return static_cast<std::size_t>(schedule.slot_row[static_cast<std::size_t>(slot)]);
  };
  for (std::size_t a = 0; a < schedule.columns.size(); ++a) {
    Lane right = -part.of(in.b[a]);
    if (in.s != nullptr) right -= dot(part.of(in.u[a]), difference(part, ends, a, in.s));
    x(a) = right;
  }
  for (const auto& [row, first, end, targets] : schedule.columns) {
    const Lane known = x(static_cast<std::size_t>(row));
    for (int e = first + 1; e < end; ++e) x(row_of(e)) -= factor(e) * known;
  }
  for (auto column = schedule.columns.rbegin(); column != schedule.columns.rend(); ++column) {
    Lane sum = x(static_cast<std::size_t>(column->row)) * factor(column->first);
    for (int e = column->first + 1; e < column->end; ++e) sum -= factor(e) * x(row_of(e));
    x(static_cast<std::size_t>(column->row)) = sum;
  }
}

// ---- all rods of a group ----

template <class Lanes, class Ends>
[[gnu::always_inline]] inline void substitute_up(const Lanes& part, const Ends& ends, const Arrays& in) {
  if constexpr (Ends::program == Program::Trees) {
    for (std::size_t k = 0; k < in.num_rods; ++k) substitute_rod(part, ends, k, in);
  } else if constexpr (Ends::program == Program::Paths) {
    substitute_piece_up(part, ends, in);
  } else {
    substitute(part, ends, in);
  }
}

/// Computes lambda, unless it is known, and F = K lambda.
template <class Lanes, class Ends>
[[gnu::always_inline]] inline void substitute_down(const Lanes& part, const Ends& ends, const Arrays& in,
                                                   bool lambda_is_known, const Pack3<>* on_roots) {
  if constexpr (Ends::program == Program::Paths) return substitute_piece_down(part, in);
  Pack3<>* const F = in.dw;
  const typename Lanes::Vector nothing{};
  for (std::size_t i = 0; i < in.num_places; ++i) part.write(nothing, &F[i]);
  if (on_roots != nullptr) part.write(part.of(*on_roots), &F[in.num_rods]);
  for (std::size_t k = in.num_rods; k-- > 0;) {
    if constexpr (Ends::program == Program::Trees) {
      if (!lambda_is_known) {
        const RodFactor& factor = in.rod_factor(k);
        part.of(in.z[k]) =
            -part.of(in.z[k]) * part.of(factor.inverse_pivot) - dot(part.of(factor.h), get(ends.second(part, k), F));
      }
    }
    pull(part, ends, k, part.of(in.z[k]) * part.of(in.u[k]), F);
  }
}

}  // namespace tanor::detail::lanes
