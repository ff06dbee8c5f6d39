#pragma once

#include <cstddef>
#include <span>
#include <type_traits>
#include <vector>

#include <tanor/system.hpp>

namespace tanor::report {

/// The points of a member at the positions that the scene gives.
struct StartingPlaces {
  const std::vector<double>& positions;
  std::span<const Index> points;

  TripleOf<double> operator[](std::size_t p) const {
    const std::size_t i = 3 * static_cast<std::size_t>(points[p]);
    return {positions[i], positions[i + 1], positions[i + 2]};
  }
};

/// Returns the number of a member that is "initial": what the definition of its kind measures at time t.
template <class Group>
double measure_initial(const System& system, const Group& group, double t, std::size_t k) {
  const auto& member = (group.*KindOf<Group>::members)[k];
  std::span<const Index> points;
  if constexpr (std::is_same_v<std::remove_cvref_t<decltype(member)>, Index>)
    points = {&member, 1};
  else
    points = member;
  const typename KindOf<Group>::template Definition<double> now(group, ClockOf<double>{t});
  return now.measure(StartingPlaces{system.positions, points}, k);
}

}  // namespace tanor::report
