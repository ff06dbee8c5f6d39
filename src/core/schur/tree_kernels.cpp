#include "schur/tree_kernels.hpp"

#include <cmath>

#include "base/distance.hpp"
#include "base/instruction_sets.hpp"

namespace tanor::detail::trees {

namespace {

/// Runs body(Parent type) for the kind of parents that the shape has, compiled for each instruction set.
template <class Body>
auto dispatch_parents(const Shape& shape, const Body& body) {
  return dispatch([body, same = shape.have_same_parents] {
    return same ? body(std::type_identity<SameParent>{}) : body(std::type_identity<OwnParents>{});
  });
}
template <class Parent>
[[gnu::always_inline]] inline Parent parent_of(std::type_identity<Parent>, const Shape& shape, std::size_t k) {
  return Parent(shape.parent + num_lanes * k);
}

[[gnu::always_inline]] inline Pack<> magnitude(const Pack<>& x) {
  return x < 0.0 ? -x : x;
}
[[gnu::always_inline]] inline Pack3<> operator*(const Mobility& W, const Pack3<>& F) {
  return {W.xx * F.x + W.xy * F.y + W.xz * F.z, W.xy * F.x + W.yy * F.y + W.yz * F.z,
          W.xz * F.x + W.yz * F.y + W.zz * F.z};
}
template <class Parent>
[[gnu::always_inline]] inline Mobility get(const Parent& parent, const Mobility* mobility) {
  return {parent.get(mobility, 0), parent.get(mobility, 1), parent.get(mobility, 2),
          parent.get(mobility, 3), parent.get(mobility, 4), parent.get(mobility, 5)};
}

/// Returns the vector from the child to the parent.
template <class Parent>
[[gnu::always_inline]] inline Pack3<> distance(const Parent& parent, const Pack3<>* r, const Pack3<>* offset,
                                               std::size_t k) {
  const Pack3<> apart = get(parent, r) - r[k];
  return offset != nullptr ? apart + offset[k] : apart;
}
/// Returns its direction, and 1/|r_p - r_c| in `inverse`.
template <class Parent>
[[gnu::always_inline]] inline Pack3<> direction(const Parent& parent, const Pack3<>* r, const Pack3<>* offset,
                                                std::size_t k, Pack<>* inverse) {
  Pack3<> u = distance(parent, r, offset, k);
  normalise(&u.x, &u.y, &u.z, inverse);
  return u;
}

template <class Parent>
[[gnu::always_inline]] inline void evaluate_rod(const Parent& parent, const Motion& motion, std::size_t k,
                                                const Rods& rods, Largest* right_side) {
  Pack<> inverse;
  const Pack3<> u = direction(parent, motion.r, motion.offset, k, &inverse);
  const Pack3<> rate = get(parent, motion.v) - motion.v[k];
  Pack<> b = second_derivative_of_distance(u, rate, inverse);
  if (motion.length_second != nullptr) b -= motion.length_second[k];
  if (motion.w0 != nullptr) b += dot(u, get(parent, motion.w0) - motion.w0[k]);
  u.write(&rods.u[k]);
  rods.b[k] = b;
  right_side->see(magnitude(b));
}

template <class Parent>
[[gnu::always_inline]] inline void eliminate_rod(const Parent& parent, std::size_t k, const Points& points,
                                                 const Rods& rods, Pack<>* largest) {
  const Pack3<> u = rods.u[k];
  const Mobility W = get(parent, points.mobility);
  const Pack3<> h = W * u;
  const Pack<> pivot = dot(u, h) + dot(u, points.mobility[k] * u);
  const Pack<> diagonal = dot(u, u) * rods.inverse_masses[k];
  const Pack<> inverse = 1.0 / pivot, ratio = diagonal * inverse;
  const Pack<> checked = ratio > 0.0 ? ratio : Pack<>{} + HUGE_VAL;
  *largest = checked > *largest ? checked : *largest;
  const Pack3<> scaled = inverse * h;
  parent.set(points.mobility, 0, W.xx - scaled.x * h.x);
  parent.set(points.mobility, 1, W.xy - scaled.x * h.y);
  parent.set(points.mobility, 2, W.xz - scaled.x * h.z);
  parent.set(points.mobility, 3, W.yy - scaled.y * h.y);
  parent.set(points.mobility, 4, W.yz - scaled.y * h.z);
  parent.set(points.mobility, 5, W.zz - scaled.z * h.z);
  scaled.write(&rods.factor[k].h);
  rods.factor[k].inverse_pivot = inverse;
}

template <class Parent>
[[gnu::always_inline]] inline void substitute_rod(const Parent& parent, std::size_t k, const Points& points,
                                                  const Rods& rods) {
  const Pack3<> of_parent = get(parent, points.s);
  const Pack<> z = rods.b[k] + dot(rods.u[k], of_parent - points.s[k]);
  rods.z[k] = z;
  set(parent, points.s, of_parent - z * rods.factor[k].h);
}

[[gnu::always_inline]] inline double largest_of(const Pack<>& found) {
  double result = 1.0;
  for (std::size_t lane = 0; lane < num_lanes; ++lane) result = found[lane] > result ? found[lane] : result;
  return result;
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

void clear(const Shape& shape, Pack3<>* points) {
  dispatch([=] {
    const Pack3<> nothing{};
    for (std::size_t i = 0; i < shape.num_places; ++i) nothing.write(&points[i]);
  });
}

void add(const Shape& shape, Vec3 w0, const Pack3<>* dw, Pack3<>* w) {
  dispatch([=] {
    const Pack<> nothing{};
    const Pack3<> all{nothing + w0.x, nothing + w0.y, nothing + w0.z};
    for (std::size_t i = 0; i < shape.num_places; ++i) (all + dw[i]).write(&w[i]);
  });
}

void find_directions(const Shape& shape, const Pack3<>* r, const Pack3<>* offset, const Rods& rods) {
  dispatch_parents(shape, [=](auto kind) {
    for (std::size_t k = 0; k < shape.num_rods; ++k) {
      Pack<> inverse;
      direction(parent_of(kind, shape, k), r, offset, k, &inverse).write(&rods.u[k]);
    }
  });
}

void evaluate(const Shape& shape, const Motion& motion, const Rods& rods, Largest* right_side) {
  dispatch_parents(shape, [=](auto kind) {
    Largest seen = *right_side;
    for (std::size_t k = 0; k < shape.num_rods; ++k) evaluate_rod(parent_of(kind, shape, k), motion, k, rods, &seen);
    *right_side = seen;
  });
}

double eliminate(const Shape& shape, const Points& points, const Rods& rods) {
  return dispatch_parents(shape, [=](auto kind) {
    Pack<> found{};
    for (std::size_t k = 0; k < shape.num_rods; ++k) eliminate_rod(parent_of(kind, shape, k), k, points, rods, &found);
    return largest_of(found);
  });
}

void substitute_up(const Shape& shape, const Points& points, const Rods& rods) {
  dispatch_parents(shape, [=](auto kind) {
    for (std::size_t k = 0; k < shape.num_rods; ++k) substitute_rod(parent_of(kind, shape, k), k, points, rods);
  });
}

double evaluate_and_eliminate(const Shape& shape, const Motion& motion, const Points& points, const Rods& rods,
                              Largest* right_side) {
  return dispatch_parents(shape, [=](auto kind) {
    Pack<> found{};
    Largest seen = *right_side;
    for (std::size_t k = 0; k < shape.num_rods; ++k) {
      const auto parent = parent_of(kind, shape, k);
      evaluate_rod(parent, motion, k, rods, &seen);
      eliminate_rod(parent, k, points, rods, &found);
      substitute_rod(parent, k, points, rods);
    }
    *right_side = seen;
    return largest_of(found);
  });
}

void substitute_down(const Shape& shape, const Rods& rods, Pack3<>* F) {
  dispatch_parents(shape, [=](auto kind) {
    for (std::size_t k = shape.num_rods; k-- > 0;) {
      const auto parent = parent_of(kind, shape, k);
      const Pack3<> of_parent = get(parent, F);
      const Pack<> lambda = -rods.z[k] * rods.factor[k].inverse_pivot - dot(rods.factor[k].h, of_parent);
      rods.z[k] = lambda;
      const Pack3<> own = lambda * rods.u[k];
      set(parent, F, of_parent + own);
      (F[k] - own).write(&F[k]);
    }
  });
}

void accelerate(const Shape& shape, const Points& points, Pack3<>* F) {
  dispatch([=] {
    for (std::size_t i = 0; i < shape.num_places; ++i) (points.inverse_mass[i] * F[i]).write(&F[i]);
  });
}

void accelerate(const Shape& shape, const Points& points, const Pack3<>* F, Pack3<>* to) {
  dispatch([=] {
    for (std::size_t i = 0; i < shape.num_places; ++i) (to[i] + points.inverse_mass[i] * F[i]).write(&to[i]);
  });
}

void find_reactions(const Shape& shape, const Rods& rods, const Pack<>* lambda, Pack3<>* F) {
  dispatch_parents(shape, [=](auto kind) {
    for (std::size_t k = shape.num_rods; k-- > 0;) {
      const auto parent = parent_of(kind, shape, k);
      const Pack3<> own = lambda[k] * rods.u[k];
      set(parent, F, get(parent, F) + own);
      (F[k] - own).write(&F[k]);
    }
  });
}

void evaluate_values(const Shape& shape, const Pack3<>* r, const Pack3<>* offset, const Pack<>* length,
                     const Rods& rods, Largest* largest) {
  dispatch_parents(shape, [=](auto kind) {
    Largest seen = *largest;
    for (std::size_t k = 0; k < shape.num_rods; ++k) {
      const Pack3<> apart = distance(parent_of(kind, shape, k), r, offset, k);
      Pack<> rho = dot(apart, apart);
      take_roots(&rho);
      rods.b[k] = rho - length[k];
      seen.see(magnitude(rods.b[k]) / length[k]);
    }
    *largest = seen;
  });
}

void evaluate_rates(const Shape& shape, const Pack3<>* r, const Pack3<>* v, const Pack3<>* offset,
                    const Pack<>* length_first, const Rods& rods, Largest* largest) {
  dispatch_parents(shape, [=](auto kind) {
    Largest seen = *largest;
    for (std::size_t k = 0; k < shape.num_rods; ++k) {
      const auto parent = parent_of(kind, shape, k);
      Pack<> inverse;
      const Pack3<> u = direction(parent, r, offset, k, &inverse);
      Pack<> rate = dot(u, get(parent, v) - v[k]);
      if (length_first != nullptr) rate -= length_first[k];
      rods.b[k] = rate;
      seen.see(magnitude(rate));
    }
    *largest = seen;
  });
}

void find_residual(const Shape& shape, const Rods& rods, const Pack3<>* dw, Largest* residual) {
  dispatch_parents(shape, [=](auto kind) {
    Largest seen = *residual;
    for (std::size_t k = 0; k < shape.num_rods; ++k) {
      const Pack<> left = dot(rods.u[k], get(parent_of(kind, shape, k), dw) - dw[k]) + rods.b[k];
      seen.see(magnitude(left));
    }
    *residual = seen;
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
      const Mobility W = OfJoints(each, &joints->mobility, &to).mobility();
      to.xx = W.xx;
      to.xy = W.xy;
      to.xz = W.xz;
      to.yy = W.yy;
      to.yz = W.yz;
      to.zz = W.zz;
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

// ---- in and out ----

void gather_places(const double* from, const Index* points, std::size_t count, Pack3<>* to) {
  dispatch([=] {
    for (std::size_t p = 0; p < count; ++p) {
      const double* at[num_lanes];
      for (std::size_t lane = 0; lane < num_lanes; ++lane) {
        const Index point = points[num_lanes * p + lane];
        at[lane] = from + 3 * static_cast<std::size_t>(point < 0 ? ~point : point);
      }
      const auto component = [&](std::size_t c) __attribute__((always_inline)) {
        return Pack<>{at[0][c], at[1][c], at[2][c], at[3][c], at[4][c], at[5][c], at[6][c], at[7][c]};
      };
      to[p].x = component(0);
      to[p].y = component(1);
      to[p].z = component(2);
    }
  });
}

void scatter_places(const Pack3<>* from, const Index* points, std::size_t count, double* to) {
  for (std::size_t p = 0; p < count; ++p) {
    for (std::size_t lane = 0; lane < num_lanes; ++lane) {
      const Index point = points[num_lanes * p + lane];
      if (point >= 0) store(to, point, {from[p].x[lane], from[p].y[lane], from[p].z[lane]});
    }
  }
}

void scatter_directions(const Pack3<>* u, const Index* rows, const Index* blocks, std::size_t count, double* to) {
  for (std::size_t k = 0; k < count; ++k) {
    for (std::size_t lane = 0; lane < num_lanes; ++lane) {
      const Index block = blocks[num_lanes * k + lane];
      const Vec3 own{u[k].x[lane], u[k].y[lane], u[k].z[lane]};
      if (rows[num_lanes * k + lane] >= 0) store(to, block < 0 ? ~block : block, block < 0 ? -own : own);
    }
  }
}

void gather_some(const double* from, const Index* rows, std::size_t count, Pack<>* to) {
  auto* const lanes = reinterpret_cast<double*>(to);
  for (std::size_t k = 0; k < num_lanes * count; ++k) lanes[k] = rows[k] < 0 ? 0.0 : from[rows[k]];
}

void scatter_some(const Pack<>* from, const Index* rows, std::size_t count, double* to) {
  const auto* const lanes = reinterpret_cast<const double*>(from);
  for (std::size_t k = 0; k < num_lanes * count; ++k) {
    if (rows[k] >= 0) to[rows[k]] = lanes[k];
  }
}

}  // namespace tanor::detail::trees
