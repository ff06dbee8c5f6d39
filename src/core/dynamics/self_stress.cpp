#include "dynamics/self_stress.hpp"

#include <cmath>

namespace tanor::detail {

std::vector<double> find_self_stress(const Dependences& dependences, const Numbering& numbering) {
  if (!dependences.is_found()) return {};
  std::vector<double> stress(numbering.num_rows());
  for (std::size_t a = 0; a < stress.size(); ++a) stress[a] = std::cos(2.3 * static_cast<double>(a));
  std::vector<double> unique = stress;
  dependences.minimize_norm(unique.data());
  constexpr double rounding = 1e-9;
  bool is_some = false;
  for (std::size_t a = 0; a < stress.size(); ++a) {
    stress[a] -= unique[a];
    if (std::abs(stress[a]) <= rounding) stress[a] = 0.0;
    is_some = is_some || stress[a] != 0.0;
  }
  return is_some ? stress : std::vector<double>();
}

}  // namespace tanor::detail
