#pragma once

#include <cstddef>
#include <numeric>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <tanor/system.hpp>

#include "system/members.hpp"

/// \file Groups with some of their members.
namespace tanor::detail {

/// Keeps the values of chosen members if there is one for each of `count`. Values shared by all stay.
template <class Value>
void choose(const std::vector<std::size_t>& members, std::size_t count, std::vector<Value>* values) {
  if (values->size() != count || count == 1) return;
  std::vector<Value> chosen;
  for (const std::size_t k : members) chosen.push_back((*values)[k]);
  *values = std::move(chosen);
}

/// Returns the numbers of chosen things, `width` for each; none if there are no numbers.
template <class Number>
std::vector<double> rows_of(const std::vector<double>& numbers, const std::vector<Number>& chosen, std::size_t width) {
  std::vector<double> rows;
  if (numbers.empty()) return rows;
  for (const Number k : chosen) {
    const auto first = numbers.begin() + static_cast<std::ptrdiff_t>(width * static_cast<std::size_t>(k));
    rows.insert(rows.end(), first, first + static_cast<std::ptrdiff_t>(width));
  }
  return rows;
}

/// Returns a group with some of its members and all that belongs to these.
template <class Group>
Group with_members(const Group& group, const std::vector<std::size_t>& members) {
  Group result = group;
  const std::size_t count = num_members(group);
  auto& list = result.*KindOf<Group>::members;
  list.clear();
  for (const std::size_t k : members) list.push_back(list_of(group)[k]);
  for_each_field<Group>([&](const auto& field) {
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(group.*field.value)>, Parameter>) {
      choose(members, count, &(result.*field.value).constants);
      choose(members, count, &(result.*field.value).functions);
    }
  });
  if constexpr (requires { result.offsets; }) choose(members, count, &result.offsets);
  if constexpr (requires { result.breaks_at; }) choose(members, count, &result.breaks_at);
  if constexpr (std::is_same_v<Group, Potential>) {
    for (std::vector<double>& constant : result.constants) choose(members, count, &constant);
  }
  if constexpr (std::is_same_v<Group, UserCoordinates>) {
    for (std::vector<double>* const numbers : {&result.q, &result.q_dot})
      *numbers = rows_of(*numbers, members, static_cast<std::size_t>(group.kernel.num_coordinates));
  }
  return result;
}

/// Returns a group with those of its members that keep(k) tells.
template <class Group, class Keep>
Group with_members_if(const Group& group, const Keep& keep) {
  std::vector<std::size_t> members;
  for (std::size_t k = 0; k < num_members(group); ++k)
    if (keep(k)) members.push_back(k);
  return with_members(group, members);
}

/// Returns the system without the constraints that are `open` [row of their first equation]. The others hold both
/// sides.
inline System without_open_rows(const System& system, const std::vector<bool>& open) {
  System result = system;
  std::size_t row = 0;
  for (Constraint& constraint : result.constraints) {
    const auto [members, rows] = shape_of(constraint);
    const std::size_t first = row, each = rows;
    std::visit(
        [&](auto& group) {
          group = with_members_if(group, [&](std::size_t k) { return !open[first + k * each]; });
          if constexpr (requires { group.side; }) group.side.reset();
        },
        constraint);
    row += members * rows;
  }
  return result;
}

/// Returns the points of pair forces, which are all points of the system if they name none.
inline std::vector<Index> points_of(const System& system, const PairForces& pairs) {
  if (!pairs.points.empty()) return pairs.points;
  std::vector<Index> all(system.num_points());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

}  // namespace tanor::detail
