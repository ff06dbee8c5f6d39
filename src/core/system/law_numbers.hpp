#pragma once

#include <array>
#include <cstddef>

#include <tanor/system.hpp>

#include "base/vec3.hpp"
#include "system/members.hpp"

namespace tanor::detail {

/// Returns the places of a member's points at the start.
template <class Group>
auto start_places(const System& system, const Group& group, std::size_t k) {
  const std::span<const Index> points = member_points(group, k);
  std::array<TripleOf<double>, points_of_member<Group>()> places;  // NOLINT: filled below
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Vec3 r = load(system.positions.data(), points[i]);
    places[i] = {r.x, r.y, r.z};
  }
  return places;
}

/// Returns the numbers of member k that its law reads, then zeros.
template <class Group>
std::array<double, KindOf<Group>::most_numbers> law_numbers_of(const System& system, const Group& group,
                                                               std::size_t k) {
  std::array<double, KindOf<Group>::most_numbers> result{};
  std::size_t i = 0;
  for (const LawNumber& number : KindOf<Group>::law_numbers(group)) {
    const Parameter& given = *number.value;
    const auto pick = [k](const auto& each) { return each[each.size() == 1 ? 0 : k]; };
    double& to = result[i++];
    if (!given.constants.empty()) {
      to = pick(given.constants);
    } else if (!given.functions.empty()) {
      to = pick(given.functions)(0.0).value();
    } else {
      using Definition = typename KindOf<Group>::template Definition<double>;
      if constexpr (requires(Definition d) { d.measure(start_places(system, group, k)); })
        to = Definition(group).measure(start_places(system, group, k));
    }
  }
  return result;
}

}  // namespace tanor::detail
