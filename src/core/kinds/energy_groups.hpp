#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <tanor/user_kernel.hpp>

#include "kinds/energy_loop.hpp"
#include "system/law_numbers.hpp"

namespace tanor::detail {

/// Members that share one energy.
struct EnergyGroup {
  PotentialKernel kernel;
  std::vector<Index> points;       ///< [member][p], the user's
  std::vector<double> constants;   ///< [member][c]
  EnergyLoop by_hand{};            ///< empty if the kernel alone is known
  std::vector<double> prepared{};  ///< [member][number] as `by_hand` reads them
  std::string name{};              ///< the force as messages call it
  /// Returns what is wrong with a member whose points are at r [3p], or an empty string. The function is null if this
  /// is unknown.
  std::function<std::string(const double* r, const double* constants)> complaint{};
};

template <std::size_t p>
std::array<TripleOf<double>, p> places_of(const double* r) {
  std::array<TripleOf<double>, p> places;  // NOLINT: filled below
  for (std::size_t i = 0; i < p; ++i) places[i] = {r[3 * i], r[3 * i + 1], r[3 * i + 2]};
  return places;
}

/// Makes the energy of a kind that has a definition, in the form of a user's kernel.
template <HasEnergy Group>
EnergyGroup make_energy_group(const System& system, const Group& group) {
  constexpr int p = points_of_member<Group>(), c = KindOf<Group>::most_numbers;
  const auto energy = [group]<class T>(const std::array<std::array<T, 3>, p>& r, const std::array<T, c>& numbers,
                                       const T&) {
    std::array<TripleOf<T>, p> places;
    for (std::size_t i = 0; i < p; ++i) places[i] = {r[i][0], r[i][1], r[i][2]};
    return typename KindOf<Group>::template Definition<T>(group).energy(places, numbers);
  };
  EnergyGroup result{.kernel = detail::make_energy_kernel<p, c>(energy, true),
                     .points = {},
                     .constants = {},
                     .by_hand = make_energy_loop(group)};
  result.kernel.depends_on_time = false;
  result.complaint = [group](const double* r, const double* constants) {
    return KindOf<Group>::complaint(group, detail::places_of<p>(r), constants);
  };
  for (std::size_t k = 0; k < num_members(group); ++k) {
    const std::span<const Index> points = member_points(group, k);
    const auto numbers = law_numbers_of(system, group, k);
    const auto prepared = EnergyKernel<Group>::prepare(group, numbers);
    result.points.insert(result.points.end(), points.begin(), points.end());
    result.constants.insert(result.constants.end(), numbers.begin(), numbers.end());
    result.prepared.insert(result.prepared.end(), prepared.begin(), prepared.end());
  }
  return result;
}

inline EnergyGroup make_energy_group(const System&, const Potential& group) {
  EnergyGroup result{.kernel = group.kernel, .points = {}, .constants = {}};
  for (std::size_t k = 0; k < group.points.size(); ++k) {
    result.points.insert(result.points.end(), group.points[k].begin(), group.points[k].end());
    for (const std::vector<double>& each : group.constants) result.constants.push_back(each[each.size() == 1 ? 0 : k]);
  }
  return result;
}

/// Makes the energies of pairs whose law is smooth wherever they are apart, one by one, for series and stiffness, which
/// hand-written forces of pairs do not have. Returns an empty group if the law has a cutoff or there are too many
/// pairs.
EnergyGroup make_pair_energies(const System& system, const PairForces& pairs);

}  // namespace tanor::detail
