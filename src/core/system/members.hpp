#pragma once

#include <span>
#include <type_traits>
#include <vector>

#include <tanor/system.hpp>

namespace tanor::detail {

/// The name of the supports that stand for points held rigid by prestress.
inline constexpr const char* rigid_points_name = "points held rigid by prestress";

/// Returns the rows (scalar equations) of one member of a constraint group: a rod has 1, a point on a line 2.
template <class Group>
constexpr int rows_per_member() {
  return KindOf<Group>::rows;
}

/// Returns the list of what a group holds: points, pairs, triples or tuples.
template <class Group>
const auto& list_of(const Group& group) {
  return group.*KindOf<Group>::members;
}

template <class Group>
std::size_t num_members(const Group& group) {
  return list_of(group).size();
}

/// Returns the number of coordinates of a group.
template <class Group>
std::size_t num_coordinates_of(const Group& group) {
  if constexpr (requires { KindOf<Group>::num_coordinates(group); })
    return KindOf<Group>::num_coordinates(group);
  else
    return static_cast<std::size_t>(KindOf<Group>::coordinates) * num_members(group);
}

/// Returns the points of a member of a kind whose members have a fixed number of them.
template <class Group>
constexpr int points_of_member() {
  if constexpr (has_single_points<Group>)
    return 1;
  else
    return static_cast<int>(
        std::tuple_size_v<
            typename std::remove_cvref_t<decltype(std::declval<Group>().*KindOf<Group>::members)>::value_type>);
}

/// Returns the user's points of member k.
template <class Group>
std::span<const Index> member_points(const Group& group, std::size_t k) {
  if constexpr (has_single_points<Group>)
    return {&list_of(group)[k], 1};
  else
    return list_of(group)[k];
}

/// The places of a member's points: r[p] is that of its p-th point. `at` returns the place of a point of the user.
template <class At>
struct MemberPlaces {
  std::span<const Index> points;
  const At& at;

  MemberPlaces(std::span<const Index> given, const At& place_of) : points(given), at(place_of) {}

  auto operator[](std::size_t p) const { return at(points[p]); }
};

/// The place of a point among positions r [3n].
struct PlacesIn {
  const double* r;

  TripleOf<double> operator()(Index point) const {
    const double* const place = r + 3 * static_cast<std::size_t>(point);
    return {place[0], place[1], place[2]};
  }
};

/// Returns the number of member k, which is initial() if the parameter is "initial".
template <class Initial>
ScalarFunction number_of(const Parameter& parameter, std::size_t k, const Initial& initial) {
  if (parameter.is_initial()) return initial();
  const auto pick = [k](const auto& each) { return each[each.size() == 1 ? 0 : k]; };
  return parameter.functions.empty() ? ScalarFunction(pick(parameter.constants)) : pick(parameter.functions);
}

inline ScalarFunction number_of(const Parameter& parameter, std::size_t k, double initial) {
  return number_of(parameter, k, [=] { return initial; });
}

/// Returns for each point whether it is a support.
inline std::vector<char> find_supports(const System& system) {
  std::vector<char> result(system.num_points(), 0);
  for (const Support& support : system.supports)
    for (const Index point : support.points) result[static_cast<std::size_t>(point)] = 1;
  return result;
}

/// The name of the last entry of supports where there are members of constraints that were taken out: these join points
/// of it, keep their numbers, and nothing of them is evaluated.
inline constexpr const char* outside_name = "\x1foutside";
/// Returns the first of these points; the number of points if there are none.
inline Index find_first_outside(const System& system) {
  const bool has_some = !system.supports.empty() && system.supports.back().name == outside_name;
  return has_some ? system.supports.back().points.front() : static_cast<Index>(system.num_points());
}

/// Calls visit(points, rows) for every member, group by group, in the user's order.
template <class Visit>
void for_each_member(const System& system, const Visit& visit) {
  for (const Constraint& constraint : system.constraints) {
    std::visit(
        [&]<class Group>(const Group& group) {
          for (std::size_t k = 0; k < num_members(group); ++k) visit(member_points(group, k), rows_per_member<Group>());
        },
        constraint);
  }
}

/// Returns the tuples of points that a force joins. Forces on single points have none.
template <class Force>
const auto& tuples_of(const Force& force) {
  if constexpr (requires { force.tuples; })
    return force.tuples;
  else
    return list_of(force);
}
template <class Force>
constexpr bool joins_points() {
  if constexpr (requires(const Force& force) { force.tuples; }) return true;
  if constexpr (requires { KindOf<Force>::members; }) return !has_single_points<Force>;
  return false;
}

/// Calls visit(points) for every tuple of points that a force joins, except pair forces.
template <class Visit>
void for_each_tuple(const System& system, const Visit& visit) {
  for (const Force& force : system.forces) {
    std::visit(
        [&]<class Group>(const Group& group) {
          if constexpr (joins_points<Group>()) {
            for (const auto& points : tuples_of(group)) visit(std::span<const Index>(points));
          }
        },
        force);
  }
}

/// True if friction acts somewhere. An entry without contacts has no effect.
inline bool has_contacts(const System& system) {
  for (std::size_t k = 0; k < system.friction.size(); ++k)
    if (num_contacts(system, k) > 0) return true;
  return false;
}

/// True if points that are far enough from each other are no pair.
inline bool has_cutoff(const PairForces& pairs) {
  return pairs.law == PairLaw::Wca || pairs.law == PairLaw::Lj || pairs.cutoff.has_value();
}

/// The number of members of a group and the number of equations of each.
struct GroupShape {
  std::size_t members, rows_per_member;
};

inline GroupShape shape_of(const Constraint& constraint) {
  return std::visit(
      []<class Group>(const Group& group) -> GroupShape {
        return {num_members(group), rows_per_member<Group>()};
      },
      constraint);
}

}  // namespace tanor::detail
