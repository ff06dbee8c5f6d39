#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include <tanor/system.hpp>

#include "system/members.hpp"

namespace tanor::detail {

/// Returns the places of a member's points at the start.
template <class Group>
auto start_places(const System& system, const Group& group, std::size_t k) {
  const std::span<const Index> points = member_points(group, k);
  std::array<TripleOf<double>, points_of_member<Group>()> places;  // NOLINT: filled below
  std::ranges::transform(points, places.begin(), PlacesIn{system.positions.data()});
  return places;
}

/// Returns the numbers of member k that its law reads, then zeros.
template <class Group>
std::array<double, KindOf<Group>::most_numbers> law_numbers_of(const System& system, const Group& group,
                                                               std::size_t k) {
  std::array<double, KindOf<Group>::most_numbers> result{};
  std::size_t i = 0;
  for (const LawNumber& number : KindOf<Group>::law_numbers(group)) {
    const auto measure = [&] {
      using Definition = typename KindOf<Group>::template Definition<double>;
      if constexpr (requires(Definition d) { d.measure(start_places(system, group, k)); })
        return Definition(group).measure(start_places(system, group, k));
      return 0.0;
    };
    result[i++] = number_of(*number.value, k, measure)(0.0).value();
  }
  return result;
}

}  // namespace tanor::detail
