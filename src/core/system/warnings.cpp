#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include <tanor/warnings.hpp>

#include "base/text.hpp"

namespace tanor {
using namespace detail;

std::vector<std::string> find_warnings(const System& system) {
  std::vector<std::string> result;
  std::map<std::string, std::size_t> entries;
  for (std::size_t k = 0; k < system.supports.size(); ++k) {
    const std::string& own = system.supports[k].name;
    const auto [first, is_new] = entries.emplace(own.empty() ? "support" + text(k) : own, k);
    if (!is_new)
      result.push_back("supports/" + text(k) + ": '" + first->first + "' is the name of supports/" +
                       text(first->second) + " too, so that their loads are not observed by themselves");
  }
  if (std::ranges::none_of(system.forces, [](const Force& force) { return std::holds_alternative<Bonds>(force); }))
    return result;
  std::set<std::pair<Index, Index>> rigid;
  for (const Constraint& constraint : system.constraints) {
    const auto* const rods = std::get_if<Rods>(&constraint);
    if (rods == nullptr || !std::ranges::all_of(rods->length.functions, &ScalarFunction::is_constant)) continue;
    for (const auto& [i, j] : rods->pairs) rigid.insert(std::minmax(i, j));
  }
  for (std::size_t g = 0; g < system.forces.size(); ++g) {
    const auto* const bonds = std::get_if<Bonds>(&system.forces[g]);
    if (bonds == nullptr) continue;
    const auto count = static_cast<std::size_t>(std::ranges::count_if(
        bonds->pairs, [&](const auto& pair) { return rigid.contains(std::minmax(pair[0], pair[1])); }));
    if (count > 0)
      result.push_back(force_name(system, g) + ": the energy of " + text_of_count(count, "bond") +
                       " along rods is constant");
  }
  return result;
}

}  // namespace tanor
