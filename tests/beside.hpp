#pragma once

/// \file Puts several systems into one, without joining them.

#include <array>
#include <variant>
#include <vector>

#include <tanor/system.hpp>

namespace tanor {

namespace beside {

inline void shift(Index by, Index* point) {
  *point += by;
}
template <class List>
void shift(Index by, List* list) {
  for (auto& each : *list) shift(by, &each);
}

/// Shifts the points of a group, whatever the name of its list of members.
template <class Group>
void shift_points(Index by, Group* group) {
  if constexpr (requires { group->points; }) shift(by, &group->points);
  if constexpr (requires { group->pairs; }) shift(by, &group->pairs);
  if constexpr (requires { group->triples; }) shift(by, &group->triples);
  if constexpr (requires { group->tuples; }) shift(by, &group->tuples);
}

}  // namespace beside

/// Appends the points, supports, constraints and forces of `other`, without their names, to those of `system`. Both
/// systems have velocities.
inline void put_beside(const System& other, System* system) {
  const auto by = static_cast<Index>(system->masses.size());
  const auto append = [](const auto& from, auto* to) { to->insert(to->end(), from.begin(), from.end()); };
  append(other.positions, &system->positions);
  append(other.velocities, &system->velocities);
  append(other.masses, &system->masses);
  for (Support support : other.supports) {
    beside::shift_points(by, &support);
    support.name.clear();
    system->supports.push_back(support);
  }
  const auto append_groups = [&](const auto& from, auto* to) {
    for (auto group : from) {
      std::visit(
          [&](auto& each) {
            beside::shift_points(by, &each);
            each.name.clear();
          },
          group);
      to->push_back(group);
    }
  };
  append_groups(other.constraints, &system->constraints);
  append_groups(other.forces, &system->forces);
}

}  // namespace tanor
