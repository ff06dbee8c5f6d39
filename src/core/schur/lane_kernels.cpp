#include <cstring>

#include "schur/lane_groups.hpp"

#include "base/distance.hpp"
#include "schur/lane_programs.hpp"

namespace tanor::detail::lanes {

namespace {

/// Returns the vector along a rod.
template <class Lanes, class Ends>
[[gnu::always_inline]] inline auto distance(const Lanes& part, const Ends& ends, std::size_t k, const Arrays& in,
                                            const Pack3<>* r) {
  const auto apart = difference(part, ends, k, r);
  return in.offset != nullptr ? apart + part.of(in.offset[k]) : apart;
}
/// Returns its direction, and 1/|r_j - r_i| in `inverse`.
template <class Lanes, class Ends>
[[gnu::always_inline]] inline auto direction(const Lanes& part, const Ends& ends, std::size_t k, const Arrays& in,
                                             const Pack3<>* r, typename Lanes::Lane* inverse) {
  auto u = distance(part, ends, k, in, r);
  normalise(&u.x, &u.y, &u.z, inverse);
  return u;
}

/// Evaluates u and b, and returns b.
template <class Lanes, class Ends>
[[gnu::always_inline]] inline auto evaluate_rod(const Lanes& part, const Ends& ends, const Motion& motion,
                                                std::size_t k, const Arrays& in, typename Lanes::Vector* u) {
  typename Lanes::Lane inverse;
  *u = direction(part, ends, k, in, motion.r, &inverse);
  auto b = second_derivative_of_distance(*u, difference(part, ends, k, motion.v), inverse);
  if (in.length_second != nullptr) b -= part.of(in.length_second[k]);
  if (motion.w0 != nullptr) b += dot(*u, difference(part, ends, k, motion.w0));
  part.write(*u, &in.u[k]);
  part.of(in.b[k]) = b;
  return b;
}

/// Returns the largest |number(k)| of so many rods.
template <class Lanes, class Number>
[[gnu::always_inline]] inline auto largest_of(const Lanes&, std::size_t num_rods, const Number& number) {
  Seen<Lanes::width> seen;
  for (std::size_t k = 0; k < num_rods; ++k) seen.see(magnitude(number(k)));
  return seen.value + seen.zero;
}

template <class Lanes>
[[gnu::always_inline]] inline void add_dw(const Lanes& part, const Arrays& in, const Pack3<>* w0, Vec3 uniform,
                                          Pack3<>* w) {
  using Lane = typename Lanes::Lane;
  const typename Lanes::Vector everywhere{Lane{} + uniform.x, Lane{} + uniform.y, Lane{} + uniform.z};
  for (std::size_t i = 0; i < in.num_places; ++i) {
    const auto dw = part.of(in.inverse_mass[i]) * part.of(in.dw[i]);
    part.write(dw, &in.dw[i]);
    if (w != nullptr) part.write((w0 != nullptr ? part.of(w0[i]) : everywhere) + dw, &w[i]);
  }
}

template <class Lanes, class Ends>
[[gnu::always_inline]] inline auto largest_residual(const Lanes& part, const Ends& ends, const Arrays& in,
                                                    const Pack3<>* dw) {
  return largest_of(
      part, in.num_rods, [&](std::size_t k) __attribute__((always_inline)) {
        return dot(part.of(in.u[k]), difference(part, ends, k, dw)) + part.of(in.b[k]);
      });
}

}  // namespace

void substitute_up(const Arrays& arrays) {
  for_group(
      arrays, [](const auto& part, auto ends, const Arrays& in)
                  __attribute__((always_inline)) { substitute_up(part, ends, in); });
}

void evaluate(const Arrays& arrays, const Motion& motion_of, bool eliminates) {
  for_group(
      arrays, [ eliminates, motion_at = &motion_of ]<class Lanes>(const Lanes& part, auto ends,
                                                                  const Arrays& in) __attribute__((always_inline)) {
        const Motion motion = *motion_at;
        typename Lanes::Lane largest = part.of(in.found->largest_inverse);
        Seen<Lanes::width> seen;
        const auto take = [&](std::size_t k, typename Lanes::Vector * u) __attribute__((always_inline)) {
          const auto b = evaluate_rod(part, ends, motion, k, in, u);
          seen.see(magnitude(b));
          return b;
        };
        typename Lanes::Vector u;
        if (!eliminates) {
          for (std::size_t k = 0; k < in.num_rods; ++k) (void)take(k, &u);
        } else if constexpr (ends.program == Program::Paths) {
          const auto take_next = [&](std::size_t k, typename Lanes::Vector * own) __attribute__((always_inline)) {
            const auto b = take(k, own);
            motion.upcoming.fetch(k);
            return b;
          };
          eliminate_piece(part, in, take_next, &largest);
        } else if constexpr (ends.program == Program::Trees) {
          for (std::size_t k = 0; k < in.num_rods; ++k) {
            (void)take(k, &u);
            eliminate_rod(part, ends, k, in, &largest);
            substitute_rod(part, ends, k, in);
          }
        }
        part.of(*in.right_side) = seen.value + seen.zero;
        part.of(in.found->largest_inverse) = largest;
      });
}

void accelerate_pieces(const Arrays& arrays, bool lambda_is_known, const Upcoming& upcoming, const Pack3<>* w0,
                       Vec3 uniform, Pack3<>* w, Pack<>* residual) {
  for_each_part(
      [ =, at = &arrays, upcoming_at = &upcoming ]<class Lanes>(const Lanes& part) __attribute__((always_inline)) {
        const Arrays in = *at;
        if (!lambda_is_known) substitute_piece_down(part, in);
        using Lane = typename Lanes::Lane;
        const typename Lanes::Vector everywhere{Lane{} + uniform.x, Lane{} + uniform.y, Lane{} + uniform.z};
        Seen<Lanes::width> seen;
        auto before = part.of(in.border->force_before), u_before = before, dw_before = before;
        const auto add = [&](std::size_t k, const auto& force) __attribute__((always_inline)) {
          const auto dw = part.of(in.inverse_mass[k]) * (before - force);
          part.write(dw, &in.dw[k]);
          if (w != nullptr) part.write((w0 != nullptr ? part.of(w0[k]) : everywhere) + dw, &w[k]);
          before = force;
          return dw;
        };
        for (std::size_t k = 0; k < in.num_rods; ++k) {
          const auto u = part.of(in.u[k]);
          const auto dw = add(k, part.of(in.z[k]) * u);
          upcoming_at->fetch(k);
          if (k > 0 && residual != nullptr) seen.see(magnitude(dot(u_before, dw - dw_before) + part.of(in.b[k - 1])));
          u_before = u;
          dw_before = dw;
        }
        (void)add(in.num_rods, typename Lanes::Vector{});
        if (residual != nullptr) part.of(*residual) = seen.value + seen.zero;
      });
}

// ---- joints ----

namespace {

/// Packs of each lane's joint, which begin at `first` in the first joint, or those of `others` where there is none.
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

/// Takes W, s or dw of joints at their places.
template <class Cell>
void take_from_joints(std::span<const JointPlace> places, const Joint* joints, Cell Joint::*what, Cell* to) {
  dispatch([=] {
    for (const JointPlace& each : places) {
      const OfJoints own(each, &(joints->*what), &to[each.place]);
      for (std::size_t k = 0; k < sizeof(Cell) / sizeof(Pack<>); ++k)
        reinterpret_cast<Pack<>*>(&to[each.place])[k] = own.get(k);
    }
  });
}

}  // namespace

}  // namespace tanor::detail::lanes

namespace tanor::detail {

// ---- groups ----

void LaneGroups::Group::take_mobilities() {
  if (!is_tree()) return;
  dispatch([in = in_] {
    const Pack<> nothing{};
    const Pack3<> none{};
    for (std::size_t i = 0; i < in.num_places; ++i) {
      lanes::Mobility& W = in.mobility[i];
      W.xx = W.yy = W.zz = in.inverse_mass[i];
      W.xy = W.xz = W.yz = nothing;
      none.write(&in.s[i]);
    }
  });
  lanes::take_from_joints(joints(), all_.joints_.data(), &Joint::mobility, in_.mobility);
}

void LaneGroups::Group::eliminate() {
  take_mobilities();
  for_group(
      in_, []<class Lanes>(const Lanes& part, auto ends, const Arrays& in) __attribute__((always_inline)) {
        typename Lanes::Lane largest = part.of(in.found->largest_inverse);
        if constexpr (ends.program == Program::Trees) {
          for (std::size_t k = 0; k < in.num_rods; ++k) eliminate_rod(part, ends, k, in, &largest);
        } else if constexpr (ends.program == Program::Paths) {
          const auto take = [&](std::size_t k, typename Lanes::Vector * u) __attribute__((always_inline)) {
            *u = part.of(in.u[k]);
            return typename Lanes::Lane{};
          };
          eliminate_piece(part, in, take, &largest);
        } else {
          eliminate_columns(part, in, &largest);
        }
        part.of(in.found->largest_inverse) = largest;
      });
  if (may_hang()) own_joint().mobility = in_.mobility[group_.num_rods];
}

void LaneGroups::Group::solve(const lanes::Motion& motion, const Vec3* uniform, FactorUse use, double* w) {
  const bool is_in_one_pass = use == FactorUse::Renew && is_tree();
  if (is_in_one_pass) {
    evaluate_and_eliminate(motion);
  } else {
    evaluate(motion);
    // It is made as elsewhere, so that its bits do not tell what was solved before.
    if (use == FactorUse::Renew) eliminate();
    if (is_tree()) std::memset(in_.s, 0, group_.num_places * sizeof(Pack3<>));
  }
  // It ends with lambda, unless z is there, and all that follows from it.
  for_group(
      in_, [
        is_in_one_pass, w0 = motion.w0, everywhere = uniform != nullptr ? *uniform : Vec3{},
        w = w != nullptr ? work_.w.data() : nullptr
      ](const auto& part, auto ends, const Arrays& in) __attribute__((always_inline)) {
        if (!is_in_one_pass) lanes::substitute_up(part, ends, in);
        lanes::substitute_down(part, ends, in, false, nullptr);
        lanes::add_dw(part, in, w0, everywhere, w);
        in.found->include(part, part.of(*in.right_side), lanes::largest_residual(part, ends, in, in.dw));
      });
  if (w != nullptr) lists_.points.write(work_.w.data(), w);
  if (next_ != nullptr) {
    const Pack<>* const factor = all_.factor_.data() + all_.plan_.groups[number_ + 1].first_factor;
    call_for(factor, static_cast<std::size_t>(factor - in_.factor));  // the next one is mostly as large
  }
}

void LaneGroups::Group::substitute_down(Pack3<>* points, const Pack3<>* known, bool lambda_is_known) {
  if (is_path() && points != nullptr) {
    lanes::accelerate_pieces(in_, lambda_is_known, {}, points, {}, points, nullptr);
    (points[0] + in_.border->r_joined).write(&points[0]);
    return points[0].write(&in_.border->r_of_first);
  }
  Pack3<> force = may_hang() ? own_joint().dw : Pack3<>{};
  for (std::size_t lane = 0; lane < num_lanes && may_hang(); ++lane) {
    const std::size_t own = std::min(lane, group_.num_members - 1);
    set_lane(&force, lane, group_.ends_tree[lane] ? Vec3{} : Vec3{force.x[own], force.y[own], force.z[own]});
  }
  const Pack3<>* const on_roots = may_hang() ? &force : nullptr;
  for_group(
      in_, [ lambda_is_known, on_roots, points ](const auto& part, auto ends, const Arrays& in)
               __attribute__((always_inline)) {
                 lanes::substitute_down(part, ends, in, lambda_is_known, on_roots);
                 for (std::size_t i = 0; points != nullptr && i < in.num_places; ++i)
                   part.write(part.of(points[i]) + part.of(in.inverse_mass[i]) * part.of(in.dw[i]), &points[i]);
               });
  if (group_.has_joints()) pull_joints(known);
  if (points != nullptr) hand_over_roots(points);
}

void LaneGroups::Group::substitute_down(const double* blocks, const Vec3* uniform, double* w) {
  const Vec3 everywhere = uniform != nullptr ? *uniform : Vec3{};
  if (is_path()) {
    read_directions(blocks);
    lanes::accelerate_pieces(in_, false, upcoming({w, nullptr, blocks}), nullptr, everywhere,
                             uniform != nullptr ? work_.w.data() : nullptr, in_.residual);
    in_.dw[0].write(&in_.border->dw_of_first);
    in_.dw[group_.num_rods - 1].write(&in_.border->dw_of_last);
    return uniform != nullptr ? lists_.points.write(work_.w.data(), w) : add_points(in_.dw, w);
  }
  if (uniform == nullptr) lists_.points.read(w, work_.w.data());
  substitute_down();
  for_group(
      in_, [
        w0 = uniform != nullptr ? nullptr : work_.w.data(), everywhere, w = work_.w.data(),
        has_joints = group_.has_joints()
      ](const auto& part, auto ends, const Arrays& in) __attribute__((always_inline)) {
        lanes::add_dw(part, in, w0, everywhere, w);
        if (!has_joints) part.of(*in.residual) = lanes::largest_residual(part, ends, in, in.dw);
      });
  hand_over_roots(in_.dw);
  if (group_.has_joints()) std::copy_n(in_.dw, group_.num_places, in_.points);
  lists_.points.write(work_.w.data(), w);
}

void LaneGroups::Group::find_directions(const double* r, Pack3<>* u) {
  lists_.points.read(r, work_.r.data());
  for_group(
      in_, [ u, r = work_.r.data() ]<class Lanes>(const Lanes& part, auto ends, const Arrays& in)
               __attribute__((always_inline)) {
                 typename Lanes::Lane inverse;
                 for (std::size_t k = 0; k < in.num_rods; ++k)
                   part.write(lanes::direction(part, ends, k, in, r, &inverse), &u[k]);
               });
}

void LaneGroups::Group::find_residual() {
  take_joints(in_.points);
  for_group(
      in_, [](const auto& part, auto ends, const Arrays& in) __attribute__((always_inline)) {
        part.of(*in.residual) = lanes::largest_residual(part, ends, in, in.points);
      });
}

void LaneGroups::Group::evaluate_values() {
  for_group(
      in_, [](const auto& part, auto ends, const Arrays& in) __attribute__((always_inline)) {
        part.of(*in.right_side) = lanes::largest_of(
            part, in.num_rods, [&](std::size_t k) __attribute__((always_inline)) {
              const auto apart = lanes::distance(part, ends, k, in, in.points);
              auto rho = dot(apart, apart);
              take_roots(&rho);
              const auto xi = rho - part.of(in.length[k]);
              part.of(in.b[k]) = xi;
              return xi / part.of(in.length[k]);
            });
      });
}

void LaneGroups::Group::evaluate_rates() {
  for_group(
      in_, [](const auto& part, auto ends, const Arrays& in) __attribute__((always_inline)) {
        part.of(*in.right_side) = lanes::largest_of(
            part, in.num_rods, [&](std::size_t k) __attribute__((always_inline)) {
              auto rate = dot(part.of(in.directions[k]), difference(part, ends, k, in.points));
              if (in.length_first != nullptr) rate -= part.of(in.length_first[k]);
              part.of(in.b[k]) = rate;
              return rate;
            });
      });
}

void LaneGroups::Group::take_joints(Pack3<>* points) {
  for (std::size_t lane = 0; is_path() && lane < group_.num_members; ++lane) {
    if (group_.behind[lane] < 0) continue;
    const auto slot = static_cast<std::size_t>(group_.behind[lane]);
    set_lane(&points[group_.num_rods], lane, lane_of(all_.borders_[slot / num_lanes].r_of_first, slot % num_lanes));
  }
  if (!group_.has_joints()) return;
  lanes::take_from_joints(joints(), all_.joints_.data(), &Joint::dw, points);
  hand_over_roots(points);  // one that is a joint itself has several pieces, one after the other
}

void LaneGroups::Group::answer_at_joints(const Pack3<>* force) {
  if (!group_.has_joints()) return;
  if (force == nullptr) return lanes::take_from_joints(joints(), all_.joints_.data(), &Joint::s, in_.s);
  static constexpr lanes::Mobility nothing{};
  dispatch([places = joints(), joints = all_.joints_.data(), s = in_.s, force] {
    for (const JointPlace& each : places) {
      const Pack3<> own = lanes::OfJoints(each, &joints->s, &s[each.place]).point();
      (own + lanes::OfJoints(each, &joints->mobility, &nothing).mobility() * force[each.place]).write(&s[each.place]);
    }
  });
}

/// Hands F of joints down, with the `known` forces [place] unless they are null.
void LaneGroups::Group::pull_joints(const Pack3<>* known) {
  dispatch([places = joints(), joints = all_.joints_.data(), F = in_.dw, known] {
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

}  // namespace tanor::detail
