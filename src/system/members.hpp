#pragma once

#include <span>
#include <type_traits>

#include <tanor/system.hpp>

namespace tanor {

/// Rows (scalar equations) of one member of a constraint group: a rod is 1, a point on a line 2.
template <class Group>
constexpr int rows_per_member() {
  return std::is_same_v<Group, Lines> || std::is_same_v<Group, Circles> ? 2 : 1;
}

// The members of a group, whatever it calls them: rods have pairs, planes have points, ...
inline std::size_t num_members(const Rods& group) {
  return group.pairs.size();
}
inline std::size_t num_members(const Angles& group) {
  return group.triples.size();
}
inline std::size_t num_members(const Pulleys& group) {
  return group.pairs.size();
}
inline std::size_t num_members(const Linears& group) {
  return group.tuples.size();
}
inline std::size_t num_members(const UserConstraints& group) {
  return group.tuples.size();
}
template <class Group>
std::size_t num_members(const Group& group) {
  return group.points.size();
}

inline std::span<const Index> member_points(const Rods& group, std::size_t k) {
  return group.pairs[k];
}
inline std::span<const Index> member_points(const Angles& group, std::size_t k) {
  return group.triples[k];
}
inline std::span<const Index> member_points(const Pulleys& group, std::size_t k) {
  return group.pairs[k];
}
inline std::span<const Index> member_points(const Linears& group, std::size_t k) {
  return group.tuples[k];
}
inline std::span<const Index> member_points(const UserConstraints& group, std::size_t k) {
  return group.tuples[k];
}
template <class Group>
std::span<const Index> member_points(const Group& group, std::size_t k) {
  return {&group.points[k], 1};
}

/// visit(points, rows) for every member, group by group: the user's order.
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

/// A group has so many members, each with so many equations.
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

}  // namespace tanor
