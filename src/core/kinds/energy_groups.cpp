#include "kinds/energy_groups.hpp"

#include <algorithm>
#include <numeric>
#include <set>

namespace tanor::detail {

EnergyGroup make_pair_energies(const System& system, const PairForces& pairs) {
  constexpr std::size_t most_points = 200;  // 20,000 pairs, each with a 6 x 6 Hessian
  const bool is_smooth =
      pairs.law == PairLaw::Coulomb || ((pairs.law == PairLaw::Yukawa || pairs.law == PairLaw::Morse) && !pairs.cutoff);
  std::vector<Index> points = pairs.points;
  if (points.empty()) {
    points.resize(system.num_points());
    std::iota(points.begin(), points.end(), Index{0});
  }
  if (!is_smooth || points.size() > most_points) return {};
  const auto energy = [pairs]<class T>(const std::array<std::array<T, 3>, 2>& r, const std::array<T, 1>& charges,
                                       const T&) {
    const TripleOf<T> a{r[1][0] - r[0][0], r[1][1] - r[0][1], r[1][2] - r[0][2]};
    return KindOf<PairForces>::smooth_energy<T>(pairs, norm(a), charges[0]);
  };
  EnergyGroup result{.kernel = detail::make_energy_kernel<2, 1>(energy, true), .points = {}, .constants = {}};
  result.kernel.depends_on_time = false;
  const std::vector<char> stands = find_supports(system);
  std::set<std::pair<Index, Index>> excluded;
  for (const Constraint& constraint : system.constraints) {
    const auto* const rods = std::get_if<Rods>(&constraint);
    if (rods == nullptr || !pairs.exclude_rods) continue;
    for (const auto& [i, j] : rods->pairs) excluded.insert(std::minmax(i, j));
  }
  const auto charge = [&](std::size_t k) {
    return pairs.charges.empty() ? 1.0 : pairs.charges[pairs.charges.size() == 1 ? 0 : k];
  };
  for (std::size_t a = 0; a < points.size(); ++a) {
    for (std::size_t b = a + 1; b < points.size(); ++b) {
      const Index i = points[a], j = points[b];
      const bool stand = stands[static_cast<std::size_t>(i)] != 0 && stands[static_cast<std::size_t>(j)] != 0;
      if (stand || excluded.contains(std::minmax(i, j))) continue;
      result.points.insert(result.points.end(), {i, j});
      result.constants.push_back(charge(a) * charge(b));
    }
  }
  return result;
}

}  // namespace tanor::detail
