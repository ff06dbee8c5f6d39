#include "dynamics/prestress_rigidity.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include "system/members.hpp"

namespace tanor::detail {

namespace {

/// Lists the ends of each row that is a rod of constant length, [row].
std::vector<std::optional<std::array<Index, 2>>> list_constant_rods(const System& system) {
  std::vector<std::optional<std::array<Index, 2>>> result;
  for (const Constraint& constraint : system.constraints) {
    const auto* rods = std::get_if<Rods>(&constraint);
    const bool is_constant = rods != nullptr && rods->offsets.empty() &&
                             std::ranges::all_of(rods->length.functions, &ScalarFunction::is_constant);
    std::visit(
        [&]<class Group>(const Group& group) {
          for (std::size_t k = 0; k < num_members(group); ++k) {
            for (int part = 0; part < rows_per_member<Group>(); ++part) {
              is_constant ? result.emplace_back(rods->pairs[k]) : result.emplace_back();
            }
          }
        },
        constraint);
  }
  return result;
}

}  // namespace

std::vector<Index> find_prestress_rigid_points(const System& system, const std::vector<RowDependence>& dependences) {
  if (dependences.empty() || !system.coordinates.empty()) return {};
  const auto rods = list_constant_rods(system);
  enum class Place { Free, Fixed, Moving };
  std::vector<Place> places(system.num_points(), Place::Free);
  for (const Support& support : system.supports) {
    for (const Index point : support.points)
      places[static_cast<std::size_t>(point)] = support.displacement.is_constant() ? Place::Fixed : Place::Moving;
  }
  const auto stands = [&](Index point) {
    const auto i = 3 * static_cast<std::size_t>(point);
    return system.velocities.empty() ||
           std::all_of(&system.velocities[i], &system.velocities[i] + 3, [](double v) { return v == 0.0; });
  };

  std::vector<Index> rigid;
  for (const RowDependence& dependence : dependences) {
    // K_row is the sum of coefficient K_a, so omega is 1 for this row and -coefficient for the others.
    const bool has_one_sign = !dependence.terms.empty() &&
                              std::all_of(dependence.terms.begin(), dependence.terms.end(),
                                          [](const RowDependence::Term& term) { return term.coefficient < 0.0; });
    if (!has_one_sign) continue;
    std::vector<Index> found;
    bool is_held = true;
    const auto add_row = [&](std::size_t row) {
      is_held = is_held && rods[row].has_value();
      if (!is_held) return;
      for (const Index point : *rods[row]) {
        const Place place = places[static_cast<std::size_t>(point)];
        is_held = is_held && place != Place::Moving && (place == Place::Fixed || stands(point));
        if (place == Place::Free) found.push_back(point);
      }
    };
    add_row(dependence.row);
    for (const RowDependence::Term& term : dependence.terms) add_row(term.row);
    if (is_held) rigid.insert(rigid.end(), found.begin(), found.end());
  }
  std::sort(rigid.begin(), rigid.end());
  rigid.erase(std::unique(rigid.begin(), rigid.end()), rigid.end());
  return rigid;
}

std::vector<std::size_t> list_prestress_rigid_equations(const System& system, const std::vector<Index>& points) {
  std::vector<char> is_rigid(system.num_points(), 0), is_held(system.num_points(), 0);
  for (const Index point : points) is_rigid[static_cast<std::size_t>(point)] = 1;
  is_held = is_rigid;
  for (const Support& support : system.supports)
    for (const Index point : support.points) is_held[static_cast<std::size_t>(point)] = 1;
  const std::vector<std::optional<std::array<Index, 2>>> rods = list_constant_rods(system);
  std::vector<std::size_t> equations;
  for (std::size_t row = 0; row < rods.size(); ++row) {
    if (!rods[row]) continue;
    const auto i = static_cast<std::size_t>((*rods[row])[0]), j = static_cast<std::size_t>((*rods[row])[1]);
    if (is_held[i] && is_held[j] && (is_rigid[i] || is_rigid[j])) equations.push_back(row);
  }
  return equations;
}

}  // namespace tanor::detail
