#pragma once

/// \file
/// The lists of kinds. A kind is added by its file in tanor/kinds and its name in one of these lists.

#include <array>
#include <concepts>
#include <string_view>
#include <tuple>
#include <variant>

#include <tanor/forward.hpp>
#include <tanor/kinds/constraint/angle.hpp>
#include <tanor/kinds/constraint/circle.hpp>
#include <tanor/kinds/constraint/ellipsoid.hpp>
#include <tanor/kinds/constraint/formula.hpp>
#include <tanor/kinds/constraint/helix.hpp>
#include <tanor/kinds/constraint/line.hpp>
#include <tanor/kinds/constraint/linear.hpp>
#include <tanor/kinds/constraint/plane.hpp>
#include <tanor/kinds/constraint/pulley.hpp>
#include <tanor/kinds/constraint/rod.hpp>
#include <tanor/kinds/constraint/rope.hpp>
#include <tanor/kinds/constraint/sphere.hpp>
#include <tanor/kinds/coordinates/chain_angles.hpp>
#include <tanor/kinds/coordinates/circle.hpp>
#include <tanor/kinds/coordinates/formula.hpp>
#include <tanor/kinds/coordinates/free.hpp>
#include <tanor/kinds/coordinates/line.hpp>
#include <tanor/kinds/coordinates/plane.hpp>
#include <tanor/kinds/coordinates/rigid_body.hpp>
#include <tanor/kinds/coordinates/sphere.hpp>
#include <tanor/kinds/force/bending.hpp>
#include <tanor/kinds/force/bond.hpp>
#include <tanor/kinds/force/constant.hpp>
#include <tanor/kinds/force/drag.hpp>
#include <tanor/kinds/force/formula.hpp>
#include <tanor/kinds/force/gravity.hpp>
#include <tanor/kinds/force/pair.hpp>
#include <tanor/kinds/force/potential.hpp>
#include <tanor/kinds/force/spring.hpp>
#include <tanor/kinds/force/torsion.hpp>
#include <tanor/kinds/friction/coulomb.hpp>
#include <tanor/kinds/friction/formula.hpp>
#include <tanor/kinds/friction/viscous.hpp>

namespace tanor {

/// Constraints xi(r, t) = 0. The built-in ones are lengths (m) with unit gradients, so multipliers are forces (N).
using Constraint = std::variant<Rods, Planes, Spheres, Lines, Circles, Angles, Pulleys, Linears, Ellipsoids, Helices,
                                Ropes, UserConstraints>;

/// Active forces f(r, v, t), N.
using Force =
    std::variant<Gravity, ConstantForce, Springs, Drag, FormulaForce, PairForces, Potential, Bonds, Bendings, Torsions>;

/// Friction tau at points that constraints guide, N.
///
/// `at` names the guides, which are constraints of single points. Several guides of one point form one wire (or one
/// surface) together. v_rel is the velocity of the point along its guide and relative to it. The guide's own motion
/// across itself follows from xi_t, and `velocity` is its motion along itself.
using Friction = std::variant<Coulomb, Viscous, UserFriction>;

/// Generalized coordinates r = r(q, t) of the tangent form. Together they cover every moving point exactly once.
using Coordinates = std::variant<FreeCoordinates, LineCoordinates, PlaneCoordinates, CircleCoordinates,
                                 SphereCoordinates, ChainAngles, RigidBody, UserCoordinates>;

// ---- checks at compile time of what a kind must have ----

// clang-format off
template <class Group>
concept HasName = requires {
  { KindOf<Group>::name } -> std::convertible_to<std::string_view>;
};

template <class Group>
concept HasFields = requires {
  std::tuple_size<std::remove_cv_t<decltype(KindOf<Group>::fields)>>::value;
};

template <class Group>
concept HasRows = requires {
  { KindOf<Group>::rows } -> std::convertible_to<int>;
  KindOf<Group>::members;
};

/// Users' own constraints bring a kernel.
template <class Group>
concept HasDefinition =
    requires(const Group& group) { group.kernel; } ||
    requires(const Group& group, const TripleOf<Jet<2>> (&r)[3], Jet<2> number) {
      { typename KindOf<Group>::template Definition<Jet<2>>(group, ClockOf<Jet<2>>{}).xi(r, number, 0) }
          -> std::convertible_to<std::array<Jet<2>, static_cast<std::size_t>(KindOf<Group>::rows)>>;
    };

/// Holds for coordinates of single points. Those that tie points have a family by hand, and users' own bring a kernel.
template <class Group>
concept HasPlace =
    requires(const Group& group) { group.kernel; } ||
    requires(const Group& group) {
      KindOf<Group>::tied_points(group);
      sizeof(typename KindOf<Group>::template Definition<Jet<2>>);
    } ||
    requires(const Group& group, const NumbersOf<Group, Jet<2>>& q, const Jet<2>& number, const ChartOf<Group>& chart,
             typename KindOf<Group>::template Definition<Jet<2>> now) {
      { now.place(q, number, chart) } -> std::convertible_to<TripleOf<Jet<2>>>;
      { now.locate(TripleOf<Jet<2>>{}, number, chart) } -> std::convertible_to<NumbersOf<Group, Jet<2>>>;
    };

template <class Law>
concept HasMagnitude =
    requires(const Law& law) {
      { KindOf<Law>::magnitude(law, 0.0) } -> std::convertible_to<double>;
    } ||
    requires(const Law& law, const Forward<1>& normal) {
      { KindOf<Law>::magnitude(law, 0.0, normal) } -> std::convertible_to<Forward<1>>;
    } ||
    HasForceOfFriction<Law>;

/// A law that sticks has a limit, mu_s |N|, and reads |N| alone when it slides.
template <class Law>
concept HasLimitWhereItSticks =
    !requires(const Law& law) { KindOf<Law>::sticks(law); } ||
    (IsProportionalFriction<Law> && requires(const Law& law) {
      { KindOf<Law>::static_coefficient(law) } -> std::convertible_to<double>;
    });
// clang-format on

namespace detail {

/// Returns true if `holds` is true of each group of a list.
template <class Holds, class... Groups>
consteval bool all_of(const std::variant<Groups...>*, Holds holds) {
  return (holds.template operator()<Groups>() && ...);
}
template <class List, class Holds>
consteval bool all_of(Holds holds) {
  return all_of(static_cast<const List*>(nullptr), holds);
}

template <class List>
consteval bool are_kinds() {
  return all_of<List>([]<class Group>() { return HasName<Group> && HasFields<Group>; });
}
static_assert(are_kinds<Constraint>() && are_kinds<Force>() && are_kinds<Friction>() && are_kinds<Coordinates>(),
              "KindOf<Group> of each kind has a `name`, and `fields`, a std::tuple of FieldOf");
static_assert(all_of<Constraint>([]<class Group>() { return HasRows<Group>; }),
              "KindOf<Group> of each constraint has `members` and `rows`");
static_assert(all_of<Constraint>([]<class Group>() { return HasDefinition<Group>; }),
              "KindOf<Group> of each constraint has a Definition<T> with xi(r, number, k)");
static_assert(all_of<Coordinates>([]<class Group>() { return HasPlace<Group>; }),
              "KindOf<Group> of coordinates of single points has `coordinates` and a Definition<T> with "
              "place(q, number, chart) and locate(r, number, chart)");
static_assert(all_of<Friction>([]<class Law>() { return HasMagnitude<Law>; }),
              "KindOf<Law> of each law of friction has magnitude(law, speed), magnitude(law, speed, normal) or force");
static_assert(all_of<Friction>([]<class Law>() { return HasLimitWhereItSticks<Law>; }),
              "a law of friction that sticks is_proportional and has a static_coefficient(law)");

}  // namespace detail

}  // namespace tanor
