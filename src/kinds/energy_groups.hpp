#pragma once

#include <optional>
#include <vector>

#include <tanor/user_kernel.hpp>

#include "system/law_numbers.hpp"

namespace tanor {

/// Members that share one energy.
struct EnergyGroup {
  PotentialKernel kernel;
  std::vector<Index> points;      ///< [member][p], the user's
  std::vector<double> constants;  ///< [member][c]
};

/// The energy of a kind that has a definition, as a user's kernel would say it.
template <HasEnergy Group>
EnergyGroup make_energy_group(const System& system, const Group& group) {
  constexpr int p = points_of_member<Group>(), c = KindOf<Group>::most_numbers;
  const auto energy = [group]<class T>(const std::array<std::array<T, 3>, p>& r, const std::array<T, c>& numbers,
                                       const T&) {
    std::array<TripleOf<T>, p> places;
    for (std::size_t i = 0; i < p; ++i) places[i] = {r[i][0], r[i][1], r[i][2]};
    return typename KindOf<Group>::template Definition<T>(group).energy(places, numbers);
  };
  EnergyGroup result{detail::make_energy_kernel<p, c>(energy, true), {}, {}};
  result.kernel.depends_on_time = false;
  for (std::size_t k = 0; k < num_members(group); ++k) {
    const std::span<const Index> points = member_points(group, k);
    const auto numbers = law_numbers_of(system, group, k);
    result.points.insert(result.points.end(), points.begin(), points.end());
    result.constants.insert(result.constants.end(), numbers.begin(), numbers.end());
  }
  return result;
}

inline EnergyGroup make_energy_group(const System&, const Potential& group) {
  EnergyGroup result{group.kernel, {}, {}};
  for (std::size_t k = 0; k < group.points.size(); ++k) {
    result.points.insert(result.points.end(), group.points[k].begin(), group.points[k].end());
    for (const std::vector<double>& each : group.constants) result.constants.push_back(each[each.size() == 1 ? 0 : k]);
  }
  return result;
}

}  // namespace tanor
