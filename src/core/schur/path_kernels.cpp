#include "schur/path_kernels.hpp"

#include <cmath>

#include "base/distance.hpp"
#include "base/lane_parts.hpp"

namespace tanor::detail::paths {

namespace {

/// Returns r_{i+1} - r_i + offset of rod i.
template <class Lanes>
[[gnu::always_inline]] inline auto distance(const Lanes& part, const Motion& motion, std::size_t i) {
  const auto a = part.of(motion.r[i + 1]) - part.of(motion.r[i]);
  return motion.offset != nullptr ? a + part.of(motion.offset[i]) : a;
}

/// Evaluates rod i and returns b = phi + K'w0.
template <class Lanes>
[[gnu::always_inline]] inline auto evaluate_rod(const Lanes& part, const Motion& motion, std::size_t i,
                                                typename Lanes::Vector* u) {
  *u = distance(part, motion, i);
  typename Lanes::Lane inverse;
  normalise(&u->x, &u->y, &u->z, &inverse);
  const auto velocity = part.of(motion.v[i + 1]) - part.of(motion.v[i]);
  auto b = second_derivative_of_distance(*u, velocity, inverse);
  if (motion.w0 != nullptr) b += dot(*u, part.of(motion.w0[i + 1]) - part.of(motion.w0[i]));
  if (motion.length_changes != nullptr) b -= part.of(motion.length_changes[i]);
  return b;
}

/// Eliminates rods [length] with take(i, &u), which returns b of rod i. If `has_b` is false, there is no right side.
template <bool has_b, class Lanes, class Take>
[[gnu::always_inline]] inline void eliminate_rods(const Lanes& part, const Pieces& pieces, const Take& take,
                                                  Border* border, Found* found) {
  using Lane = typename Lanes::Lane;
  const Lane one = Lane{} + 1.0;
  typename Lanes::Vector u, before{};
  Lane mass = part.of(pieces.inverse_mass[0]), inverse_before{}, y_before{}, spread = one, taken{}, taken_y{};
  Lane largest_inverse = part.of(found->largest_inverse);
  const std::size_t last = pieces.length - 1;
  for (std::size_t i = 0;; ++i) {
    const Lane b = take(i, &u), mass_behind = part.of(pieces.inverse_mass[i + 1]);
    // S_aa = u.u (1/m + 1/m') with u as it was rounded, and S_ab = -u_a.u_b/m of the point between.
    const Lane diagonal = dot(u, u) * (mass + mass_behind), coupling = -mass * dot(before, u);
    const Lane l = coupling * inverse_before, pivot = diagonal - l * coupling;
    if (i > 0) {
      part.of(pieces.l[i - 1]) = l;
      spread = -l * spread;
    }
    if constexpr (has_b) y_before = -b - l * y_before;
    if (i == last) {
      part.of(border->diagonal) = diagonal;
      part.of(border->pivot) = pivot;
      break;
    }
    const Lane inverse = 1.0 / pivot, ratio = diagonal * inverse, spike = spread * inverse;
    // A pivot that is 0, negative or NaN makes the largest one infinite.
    const Lane checked = ratio > 0.0 ? ratio : Lane{} + HUGE_VAL;
    largest_inverse = checked > largest_inverse ? checked : largest_inverse;
    taken += spread * spike;
    if constexpr (has_b) {
      part.of(pieces.y[i]) = y_before;
      taken_y += spike * y_before;
    }
    part.of(pieces.inverse_pivot[i]) = inverse_before = inverse;
    before = u;
    mass = mass_behind;
  }
  part.of(border->spread) = spread;
  part.of(border->taken) = taken;
  part.of(border->taken_y) = taken_y;
  part.of(border->y) = y_before;
  part.of(found->largest_inverse) = largest_inverse;
}

}  // namespace

void evaluate(const Pieces& pieces, const Motion& motion, Found* found) {
  for_each_part([=]<class Lanes>(const Lanes& part) __attribute__((always_inline)) {
    Seen<Lanes::width> seen;
    for (std::size_t i = 0; i < pieces.length; ++i) {
      typename Lanes::Vector u;
      const auto b = evaluate_rod(part, motion, i, &u);
      seen.see(magnitude(b));
      part.write(u, &pieces.u[i]);
      part.of(pieces.b[i]) = b;
    }
    seen.write(part, &found->row);
  });
}

void find_directions(const Pieces& pieces, const Motion& motion) {
  for_each_part([=]<class Lanes>(const Lanes& part) __attribute__((always_inline)) {
    for (std::size_t i = 0; i < pieces.length; ++i) {
      auto u = distance(part, motion, i);
      typename Lanes::Lane inverse;
      normalise(&u.x, &u.y, &u.z, &inverse);
      part.write(u, &pieces.u[i]);
    }
  });
}

void evaluate_values(const Pieces& pieces, const Motion& motion, const Pack<>* lengths, Found* found) {
  for_each_part([=]<class Lanes>(const Lanes& part) __attribute__((always_inline)) {
    Seen<Lanes::width> seen;
    for (std::size_t i = 0; i < pieces.length; ++i) {
      const auto a = distance(part, motion, i);
      auto rho = dot(a, a);
      take_roots(&rho);
      const auto xi = rho - part.of(lengths[i]);
      part.of(pieces.b[i]) = xi;
      seen.see(magnitude(xi) / part.of(lengths[i]));
    }
    seen.write(part, &found->row);
  });
}

void evaluate_rates(const Pieces& pieces, const Motion& motion, Found* found) {
  for_each_part([=]<class Lanes>(const Lanes& part) __attribute__((always_inline)) {
    Seen<Lanes::width> seen;
    for (std::size_t i = 0; i < pieces.length; ++i) {
      auto u = distance(part, motion, i);
      typename Lanes::Lane inverse;
      normalise(&u.x, &u.y, &u.z, &inverse);
      auto rate = dot(u, part.of(motion.v[i + 1]) - part.of(motion.v[i]));
      if (motion.length_changes != nullptr) rate -= part.of(motion.length_changes[i]);
      part.of(pieces.b[i]) = rate;
      seen.see(magnitude(rate));
    }
    seen.write(part, &found->row);
  });
}

void eliminate(const Pieces& pieces, Border* border, Found* found) {
  for_each_part([=]<class Lanes>(const Lanes& part) __attribute__((always_inline)) {
    const auto take = [&](std::size_t i, typename Lanes::Vector * u) __attribute__((always_inline)) {
      *u = part.of(pieces.u[i]);
      return typename Lanes::Lane{};
    };
    eliminate_rods<false>(part, pieces, take, border, found);
  });
}

void evaluate_and_eliminate(const Pieces& pieces, const Motion& motion, Border* border, Found* found) {
  for_each_part([=]<class Lanes>(const Lanes& part) __attribute__((always_inline)) {
    Seen<Lanes::width> seen;
    const auto take = [&](std::size_t i, typename Lanes::Vector * u) __attribute__((always_inline)) {
      const auto b = evaluate_rod(part, motion, i, u);
      motion.upcoming.fetch(i);
      part.write(*u, &pieces.u[i]);
      part.of(pieces.b[i]) = b;
      seen.see(magnitude(b));
      return b;
    };
    eliminate_rods<true>(part, pieces, take, border, found);
    seen.write(part, &found->row);
  });
}

void substitute_forward(const Pieces& pieces, Border* border) {
  for_each_part([=]<class Lanes>(const Lanes& part) __attribute__((always_inline)) {
    using Lane = typename Lanes::Lane;
    Lane y = -part.of(pieces.b[0]), spread = Lane{} + 1.0, taken_y{};
    for (std::size_t i = 0; i + 1 < pieces.length; ++i) {
      part.of(pieces.y[i]) = y;
      taken_y += spread * part.of(pieces.inverse_pivot[i]) * y;
      const Lane l = part.of(pieces.l[i]);
      spread = -l * spread;
      y = -part.of(pieces.b[i + 1]) - l * y;
    }
    part.of(border->y) = y;
    part.of(border->taken_y) = taken_y;
  });
}

void substitute_backward(const Pieces& pieces, const Border& border, Pack<>* spikes, Pack<>* x) {
  for_each_part([=]<class Lanes>(const Lanes& part) __attribute__((always_inline)) {
    using Lane = typename Lanes::Lane;
    const Lane before = part.of(border.taken_y);
    Lane spike = part.of(border.spread) * before, last = part.of(border.y);
    for (std::size_t i = 0; i + 1 < pieces.length; ++i) {
      part.of(spikes[i]) = spike;
      spike = -part.of(pieces.l[i]) * spike;
    }
    part.of(x[pieces.length - 1]) = last;
    for (std::size_t i = pieces.length - 1; i-- > 0;) {
      last =
          (part.of(pieces.y[i]) - part.of(spikes[i])) * part.of(pieces.inverse_pivot[i]) - part.of(pieces.l[i]) * last;
      part.of(x[i]) = last;
    }
  });
}

void accelerate(const Pieces& pieces, const Pack<>* x, const Pack3<>& force_before, const Upcoming& upcoming,
                Pack3<>* dw, Found* found) {
  for_each_part([ =, &force_before ]<class Lanes>(const Lanes& part) __attribute__((always_inline)) {
    Seen<Lanes::width> seen;
    auto before = part.of(force_before), u_before = before, dw_before = before;
    for (std::size_t i = 0; i < pieces.length; ++i) {
      const auto u = part.of(pieces.u[i]), force = part.of(x[i]) * u;
      const auto own = part.of(pieces.inverse_mass[i]) * (before - force);
      part.write(own, &dw[i]);
      upcoming.fetch(i);
      if (found != nullptr && i > 0) seen.see(magnitude(dot(u_before, own - dw_before) + part.of(pieces.b[i - 1])));
      before = force;
      u_before = u;
      dw_before = own;
    }
    if (found != nullptr) seen.write(part, &found->residual);
  });
}

void move(std::size_t length, Vec3 w0, Pack3<>* dw) {
  for_each_part([=]<class Lanes>(const Lanes& part) __attribute__((always_inline)) {
    using Lane = typename Lanes::Lane;
    const typename Lanes::Vector free{Lane{} + w0.x, Lane{} + w0.y, Lane{} + w0.z};
    for (std::size_t i = 0; i < length; ++i) part.write(free + part.of(dw[i]), &dw[i]);
  });
}

}  // namespace tanor::detail::paths
