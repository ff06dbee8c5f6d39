#include "schur/lane_kernels.hpp"

#include <cmath>

#include "base/distance.hpp"

namespace tanor::detail::lanes {

namespace {

/// Includes a diagonal over its pivot in the largest one. A pivot that is 0, negative or NaN makes it
/// infinite.
[[gnu::always_inline]] inline void include(const Pack<>& ratio, Pack<>* largest) {
  const Pack<> checked = ratio > 0.0 ? ratio : Pack<>{} + HUGE_VAL;
  *largest = checked > *largest ? checked : *largest;
}

/// Returns the vector along a rod.
template <class Ends>
[[gnu::always_inline]] inline Pack3<> distance(const Ends& ends, std::size_t k, const Pack3<>* r,
                                               const Pack3<>* offset) {
  const Pack3<> apart = difference(ends, k, r);
  return offset != nullptr ? apart + offset[k] : apart;
}
/// Returns its direction, and 1/|r_j - r_i| in `inverse`.
template <class Ends>
[[gnu::always_inline]] inline Pack3<> direction(const Ends& ends, std::size_t k, const Pack3<>* r,
                                                const Pack3<>* offset, Pack<>* inverse) {
  Pack3<> u = distance(ends, k, r, offset);
  normalise(&u.x, &u.y, &u.z, inverse);
  return u;
}

/// Evaluates u and b, and returns b.
template <class Ends>
[[gnu::always_inline]] inline Pack<> evaluate_rod(const Ends& ends, const Motion& motion, std::size_t k,
                                                  const Rods& rods) {
  Pack<> inverse;
  const Pack3<> u = direction(ends, k, motion.r, motion.offset, &inverse);
  Pack<> b = second_derivative_of_distance(u, difference(ends, k, motion.v), inverse);
  if (motion.length_second != nullptr) b -= motion.length_second[k];
  if (motion.w0 != nullptr) b += dot(u, difference(ends, k, motion.w0));
  u.write(&rods.u[k]);
  rods.b[k] = b;
  return b;
}

/// Returns the largest |number(k)| of all rods.
template <class Number>
[[gnu::always_inline]] inline Pack<> largest_of(const Shape& shape, const Number& number) {
  Largest seen;
  for (std::size_t k = 0; k < shape.num_rods; ++k) {
    const Pack<> x = number(k);
    seen.see(x < 0.0 ? -x : x);
  }
  return seen.value + seen.zero;
}

// ---- pieces of trees ----

[[gnu::always_inline]] inline Pack3<> operator*(const Mobility& W, const Pack3<>& F) {
  return {W.xx * F.x + W.xy * F.y + W.xz * F.z, W.xy * F.x + W.yy * F.y + W.yz * F.z,
          W.xz * F.x + W.yz * F.y + W.zz * F.z};
}
template <class Place>
[[gnu::always_inline]] inline Mobility get(const Place& place, const Mobility* mobility) {
  return {place.get(mobility, 0), place.get(mobility, 1), place.get(mobility, 2),
          place.get(mobility, 3), place.get(mobility, 4), place.get(mobility, 5)};
}

template <class Parent>
[[gnu::always_inline]] inline void eliminate_rod(const Parent& parent, std::size_t k, const Points& points,
                                                 const Rods& rods, Pack<>* largest) {
  const Pack3<> u = rods.u[k];
  const Mobility W = get(parent, points.mobility);
  const Pack3<> h = W * u;
  const Pack<> pivot = dot(u, h) + dot(u, points.mobility[k] * u), inverse = 1.0 / pivot;
  include(dot(u, u) * rods.inverse_masses[k] * inverse, largest);
  const Pack3<> scaled = inverse * h;
  parent.set(points.mobility, 0, W.xx - scaled.x * h.x);
  parent.set(points.mobility, 1, W.xy - scaled.x * h.y);
  parent.set(points.mobility, 2, W.xz - scaled.x * h.z);
  parent.set(points.mobility, 3, W.yy - scaled.y * h.y);
  parent.set(points.mobility, 4, W.yz - scaled.y * h.z);
  parent.set(points.mobility, 5, W.zz - scaled.z * h.z);
  scaled.write(&rods.rod_factor(k).h);
  rods.rod_factor(k).inverse_pivot = inverse;
}

template <class Parent>
[[gnu::always_inline]] inline void substitute_rod(const Parent& parent, std::size_t k, const Points& points,
                                                  const Rods& rods) {
  const Pack3<> of_parent = get(parent, points.s);
  const Pack<> z = rods.b[k] + dot(rods.u[k], of_parent - points.s[k]);
  rods.z[k] = z;
  set(parent, points.s, of_parent - z * rods.rod_factor(k).h);
}

// ---- equal islands ----

/// Factorizes S = L D L'. The factor [slot] holds L below the diagonal and 1/D on it.
[[gnu::always_inline]] inline void eliminate_columns(const IslandStructure& structure, const Pack<>* inverse_mass,
                                                     const Rods& rods, Pack<>* largest) {
  const auto& [topology, schedule] = structure;
  const Pack3<>* const u = rods.u;
  Pack<>* const factor = rods.factor;
  for (int slot = 0; slot < schedule.num_slots; ++slot) factor[slot] = Pack<>{};
  for (const auto& [slot, a, b, point, sign] : schedule.products)
    factor[slot] += sign * inverse_mass[point] * dot(u[a], u[b]);
  for (const auto& [row, first, end, first_target] : schedule.columns) {
    const auto [i, j] = topology.rods[static_cast<std::size_t>(row)];
    // The diagonal is g.g (1/m_i + 1/m_j) with g as it was rounded; its slot holds what earlier columns have
    // subtracted.
    const Pack<> diagonal = dot(u[row], u[row]) * (inverse_mass[i] + inverse_mass[j]);
    const Pack<> pivot = diagonal + factor[first], inverse = 1.0 / pivot;
    include(diagonal * inverse, largest);
    factor[first] = inverse;
    const int* target = schedule.targets.data() + first_target;
    for (int f = first + 1; f < end; ++f) {
      const Pack<> l = factor[f] * inverse;
      for (int e = f; e < end; ++e) factor[*target++] -= l * factor[e];
      factor[f] = l;
    }
  }
}

[[gnu::always_inline]] inline void substitute(const IslandSchedule& schedule, const EqualEnds& ends, const Pack3<>* s,
                                              const Rods& rods) {
  const Pack<>* const factor = rods.factor;
  Pack<>* const x = rods.z;
  for (std::size_t a = 0; a < schedule.columns.size(); ++a) {
    x[a] = -rods.b[a];
    if (s != nullptr) x[a] -= dot(rods.u[a], difference(ends, a, s));
  }
  for (const auto& [row, first, end, targets] : schedule.columns) {
    const Pack<> known = x[row];
    for (int e = first + 1; e < end; ++e) x[schedule.slot_row[static_cast<std::size_t>(e)]] -= factor[e] * known;
  }
  for (auto column = schedule.columns.rbegin(); column != schedule.columns.rend(); ++column) {
    Pack<> sum = x[column->row] * factor[column->first];
    for (int e = column->first + 1; e < column->end; ++e)
      sum -= factor[e] * x[schedule.slot_row[static_cast<std::size_t>(e)]];
    x[column->row] = sum;
  }
}

// ---- all rods of a group ----

template <class Ends>
[[gnu::always_inline]] inline Pack<> evaluate(const Ends& ends, const Shape& shape, const Motion& motion,
                                              const Rods& rods) {
  return largest_of(
      shape, [&](std::size_t k) __attribute__((always_inline)) { return evaluate_rod(ends, motion, k, rods); });
}

template <class Ends>
[[gnu::always_inline]] inline void substitute_up(const Ends& ends, const Shape& shape, const Points& points,
                                                 const Rods& rods) {
  if constexpr (Ends::are_of_pieces) {
    for (std::size_t k = 0; k < shape.num_rods; ++k) substitute_rod(ends.second(k), k, points, rods);
  } else {
    substitute(shape.structure->schedule, ends, points.s, rods);
  }
}

template <class Ends>
[[gnu::always_inline]] inline void substitute_down(const Ends& ends, const Shape& shape, const Rods& rods,
                                                   bool lambda_is_known, const Pack3<>* on_roots, Pack3<>* F) {
  const Pack3<> nothing{};
  for (std::size_t i = 0; i < shape.num_places; ++i) nothing.write(&F[i]);
  if (on_roots != nullptr) on_roots->write(&F[shape.num_rods]);
  for (std::size_t k = shape.num_rods; k-- > 0;) {
    if constexpr (Ends::are_of_pieces) {
      if (!lambda_is_known) {
        const RodFactor& factor = rods.rod_factor(k);
        rods.z[k] = -rods.z[k] * factor.inverse_pivot - dot(factor.h, get(ends.second(k), F));
      }
    }
    pull(ends, k, rods.z[k] * rods.u[k], F);
  }
}

[[gnu::always_inline]] inline void add_dw(const Shape& shape, const Pack<>* inverse_mass, Pack3<>* F, const Pack3<>* w0,
                                          Vec3 uniform, Pack3<>* w) {
  const Pack<> nothing{};
  const Pack3<> everywhere{nothing + uniform.x, nothing + uniform.y, nothing + uniform.z};
  for (std::size_t i = 0; i < shape.num_places; ++i) {
    const Pack3<> dw = inverse_mass[i] * F[i];
    dw.write(&F[i]);
    ((w0 != nullptr ? w0[i] : everywhere) + dw).write(&w[i]);
  }
}

template <class Ends>
[[gnu::always_inline]] inline Pack<> largest_residual(const Ends& ends, const Shape& shape, const Rods& rods,
                                                      const Pack3<>* dw) {
  return largest_of(
      shape, [&](std::size_t k)
                 __attribute__((always_inline)) { return dot(rods.u[k], difference(ends, k, dw)) + rods.b[k]; });
}

/// Runs body(ends) for the kind of ends that the shape has. Each kind has a function of its own for each instruction
/// set, which gcc optimizes better than all kinds in one. Bodies of many numbers capture where these are and copy them
/// inside, since a body is copied twice.
template <class Body>
void dispatch_ends(const Shape& shape, const Body& body) {
  with_ends(shape, [&](auto ends) { dispatch([body, ends] { body(ends); }); });
}

}  // namespace

void free_points(const Shape& shape, const Points& points) {
  dispatch([=] {
    const Pack<> nothing{};
    const Pack3<> none{};
    for (std::size_t i = 0; i < shape.num_places; ++i) {
      Mobility& W = points.mobility[i];
      W.xx = W.yy = W.zz = points.inverse_mass[i];
      W.xy = W.xz = W.yz = nothing;
      none.write(&points.s[i]);
    }
  });
}

void find_directions(const Shape& shape, const Pack3<>* r, const Pack3<>* offset, Pack3<>* u) {
  dispatch_ends(shape, [=](auto ends) {
    Pack<> inverse;
    for (std::size_t k = 0; k < shape.num_rods; ++k) direction(ends, k, r, offset, &inverse).write(&u[k]);
  });
}

void evaluate(const Shape& given, const Motion& of_points, const Rods& joined, Pack<>* right_side) {
  dispatch_ends(given, [=, at = &given, motion_at = &of_points, rods_at = &joined](auto ends) {
    const Shape shape = *at;
    const Motion motion = *motion_at;
    const Rods rods = *rods_at;
    *right_side = evaluate(ends, shape, motion, rods);
  });
}

void eliminate(const Shape& given, const Points& moved, const Rods& joined, Findings* found) {
  dispatch_ends(given, [=, at = &given, points_at = &moved, rods_at = &joined](auto ends) {
    const Shape shape = *at;
    const Points points = *points_at;
    const Rods rods = *rods_at;
    Pack<> largest = found->largest_inverse;
    if constexpr (ends.are_of_pieces) {
      for (std::size_t k = 0; k < shape.num_rods; ++k) eliminate_rod(ends.second(k), k, points, rods, &largest);
    } else {
      eliminate_columns(*shape.structure, points.inverse_mass, rods, &largest);
    }
    found->largest_inverse = largest;
  });
}

void substitute_up(const Shape& shape, const Points& points, const Rods& rods) {
  dispatch_ends(shape, [=](auto ends) { substitute_up(ends, shape, points, rods); });
}

void evaluate_and_eliminate(const Shape& shape, const Motion& motion, const Points& points, const Rods& rods,
                            Pack<>* right_side, Findings* found) {
  dispatch_ends(shape, [=](auto ends) {
    Pack<> largest = found->largest_inverse;
    *right_side = largest_of(shape, [&](std::size_t k) {
      const Pack<> b = evaluate_rod(ends, motion, k, rods);
      if constexpr (ends.are_of_pieces) {
        eliminate_rod(ends.second(k), k, points, rods, &largest);
        substitute_rod(ends.second(k), k, points, rods);
      }
      return b;
    });
    found->largest_inverse = largest;
  });
}

void finish(const Shape& given, const Points& moved, const Rods& joined, bool is_substituted, Pack3<>* F,
            const Pack3<>* w0, Vec3 uniform, Pack3<>* w, const Pack<>* right_side, Findings* found) {
  const auto body = [=, at = &given, points_at = &moved, rods_at = &joined](auto ends) {
    const Shape shape = *at;
    const Points points = *points_at;
    const Rods rods = *rods_at;
    if (!is_substituted) substitute_up(ends, shape, points, rods);
    substitute_down(ends, shape, rods, false, nullptr, F);
    add_dw(shape, points.inverse_mass, F, w0, uniform, w);
    found->include(*right_side, largest_residual(ends, shape, rods, F));
  };
  dispatch_ends(given, body);
}

void substitute_down(const Shape& shape, const Pack<>* inverse_mass, const Rods& rods, bool lambda_is_known,
                     const Pack3<>* on_roots, Pack3<>* F, Pack3<>* points) {
  dispatch_ends(shape, [=](auto ends) {
    substitute_down(ends, shape, rods, lambda_is_known, on_roots, F);
    for (std::size_t i = 0; points != nullptr && i < shape.num_places; ++i)
      (points[i] + inverse_mass[i] * F[i]).write(&points[i]);
  });
}

void accelerate(const Shape& shape, const Pack<>* inverse_mass, Pack3<>* F, const Pack3<>* w0, Vec3 uniform,
                Pack3<>* w) {
  dispatch([=] { add_dw(shape, inverse_mass, F, w0, uniform, w); });
}

void find_residual(const Shape& shape, const Rods& rods, const Pack3<>* dw, Pack<>* residual) {
  dispatch_ends(shape, [=](auto ends) { *residual = largest_residual(ends, shape, rods, dw); });
}

void evaluate_values(const Shape& shape, const Pack3<>* r, const Pack3<>* offset, const Pack<>* length, Pack<>* b,
                     Pack<>* largest) {
  dispatch_ends(shape, [=](auto ends) {
    *largest = largest_of(
        shape, [&](std::size_t k) __attribute__((always_inline)) {
          const Pack3<> apart = distance(ends, k, r, offset);
          Pack<> rho = dot(apart, apart);
          take_roots(&rho);
          b[k] = rho - length[k];
          return b[k] / length[k];
        });
  });
}

void evaluate_rates(const Shape& shape, const Pack3<>* u, const Pack3<>* v, const Pack<>* length_first, Pack<>* b,
                    Pack<>* largest) {
  dispatch_ends(shape, [=](auto ends) {
    *largest = largest_of(
        shape, [&](std::size_t k) __attribute__((always_inline)) {
          const Pack<> rate = dot(u[k], difference(ends, k, v));
          return b[k] = length_first != nullptr ? rate - length_first[k] : rate;
        });
  });
}

// ---- joints ----

namespace {

/// Packs of some number of each lane's joint, which begin at `first` in the first joint. Lanes without a joint have
/// those of `others`.
struct OfJoints {
  const double* at[num_lanes];
  [[gnu::always_inline]] OfJoints(const JointPlace& place, const void* first, const void* others) {
    for (std::size_t lane = 0; lane < num_lanes; ++lane) {
      const auto joint = static_cast<std::size_t>(place.joint[lane]);
      at[lane] = place.joint[lane] < 0 ? static_cast<const double*>(others) + lane
                                       : static_cast<const double*>(first) +
                                             joint / num_lanes * (sizeof(Joint) / sizeof(double)) + joint % num_lanes;
    }
  }
  [[gnu::always_inline]] Pack<> get(std::size_t k) const {
    const std::size_t n = num_lanes * k;
    return Pack<>{at[0][n], at[1][n], at[2][n], at[3][n], at[4][n], at[5][n], at[6][n], at[7][n]};
  }
  [[gnu::always_inline]] Pack3<> point() const { return {get(0), get(1), get(2)}; }
  [[gnu::always_inline]] Mobility mobility() const { return {get(0), get(1), get(2), get(3), get(4), get(5)}; }
};

}  // namespace

void take_mobilities(std::span<const JointPlace> places, const Joint* joints, Mobility* mobility) {
  dispatch([=] {
    for (const JointPlace& each : places) {
      Mobility& to = mobility[each.place];
      const OfJoints own(each, &joints->mobility, &to);
      for (std::size_t k = 0; k < 6; ++k) reinterpret_cast<Pack<>*>(&to)[k] = own.get(k);
    }
  });
}

void take_joints(std::span<const JointPlace> places, const Joint* joints, Pack3<>* points) {
  dispatch([=] {
    for (const JointPlace& each : places)
      OfJoints(each, &joints->dw, &points[each.place]).point().write(&points[each.place]);
  });
}

void answer_at_joints(std::span<const JointPlace> places, const Joint* joints, const Pack3<>* force, Pack3<>* s) {
  static constexpr Mobility nothing{};
  dispatch([=] {
    for (const JointPlace& each : places) {
      const Pack3<> own = OfJoints(each, &joints->s, &s[each.place]).point();
      if (force == nullptr) {
        own.write(&s[each.place]);
      } else {
        (own + OfJoints(each, &joints->mobility, &nothing).mobility() * force[each.place]).write(&s[each.place]);
      }
    }
  });
}

void pull_joints(std::span<const JointPlace> places, const Pack3<>* F, const Pack3<>* known, Joint* joints) {
  dispatch([=] {
    for (const JointPlace& each : places) {
      const Pack3<> force = known != nullptr ? F[each.place] + known[each.place] : F[each.place];
      for (std::size_t lane = 0; lane < num_lanes; ++lane) {
        if (each.joint[lane] < 0) continue;
        const auto joint = static_cast<std::size_t>(each.joint[lane]);
        set_lane(&joints[joint / num_lanes].dw, joint % num_lanes, {force.x[lane], force.y[lane], force.z[lane]});
      }
    }
  });
}

}  // namespace tanor::detail::lanes
