#include "statics/standing_corner.hpp"

#include <algorithm>
#include <cmath>
#include <variant>
#include <vector>

#include "base/text.hpp"
#include "system/corner_terms.hpp"
#include "system/formula_names.hpp"
#include "system/members.hpp"

namespace tanor::detail {

std::string find_standing_corner(const System& system, double t, std::span<const double> positions,
                                 std::span<const double> scene, double part) {
  double size = 0.0;
  for (const double each : scene) size = std::max(size, std::abs(each));
  const double distance = part * (size > 0.0 ? size : 1.0);
  for (std::size_t k = 0; k < system.constraints.size(); ++k) {
    const auto* const group = std::get_if<UserConstraints>(&system.constraints[k]);
    if (group == nullptr || group->kernel.expression == nullptr) continue;
    const CornerTerms terms(*group->kernel.expression);
    if (terms.empty()) continue;
    for (std::size_t member = 0; member < group->tuples.size(); ++member) {
      std::vector<double> variables;
      for (const Index point : group->tuples[member])
        for (std::size_t c = 0; c < 3; ++c) variables.push_back(positions[3 * static_cast<std::size_t>(point) + c]);
      variables.push_back(t);
      for (std::size_t term = 0; term < terms.size(); ++term) {
        if (!terms.is_bent(term, variables.data(), distance)) continue;
        std::vector<std::string> names = name_coordinates(group->kernel.num_points);
        names.emplace_back("t");
        return "the corner of " + terms.name(term, names) + " in " + constraint_name(system, k) +
               (group->tuples.size() > 1 ? "[" + text(member) + "]" : "");
      }
    }
  }
  return {};
}

EquilibriumResult refuse_standing_corner(const System& system, double t, EquilibriumResult result) {
  constexpr double at_rest = 1e-9, failed = 1e-4;
  const std::string corner =
      find_standing_corner(system, t, result.positions, system.positions, result.outcome.ok() ? at_rest : failed);
  if (!corner.empty())
    result.outcome = {Status::NoSolution, "the points come to rest in " + corner + ", where no side of it holds"};
  return result;
}

}  // namespace tanor::detail
