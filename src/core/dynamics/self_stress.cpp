#include "dynamics/self_stress.hpp"

#include <algorithm>
#include <cmath>

namespace tanor::detail {

std::vector<double> find_self_stress(const Dependences& dependences, const Numbering& numbering) {
  if (!dependences.is_found()) return {};
  std::vector<double> stress(numbering.num_rows());
  for (std::size_t a = 0; a < stress.size(); ++a) stress[a] = std::cos(2.3 * static_cast<double>(a));
  std::vector<double> unique = stress;
  dependences.minimize_norm(unique.data());
  constexpr double rounding = 1e-9;
  for (std::size_t a = 0; a < stress.size(); ++a) {
    stress[a] -= unique[a];
    if (std::abs(stress[a]) <= rounding) stress[a] = 0.0;
  }
  for (std::size_t island = 0; island + 1 < numbering.island_start.size(); ++island) {
    const auto first = static_cast<std::size_t>(numbering.island_start[island]),
               end = static_cast<std::size_t>(numbering.island_start[island + 1]);
    bool is_of_friction = false;
    for (std::size_t a = first; a < end; ++a)
      is_of_friction = is_of_friction || (stress[a] != 0.0 && numbering.is_contact_row(a));
    if (is_of_friction) std::fill(stress.begin() + first, stress.begin() + end, 0.0);
  }
  const bool is_some = std::ranges::any_of(stress, [](double each) { return each != 0.0; });
  return is_some ? stress : std::vector<double>();
}

}  // namespace tanor::detail
