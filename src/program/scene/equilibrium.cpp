#include "scene/equilibrium.hpp"

#include <limits>

#include <tanor/statics_names.hpp>

#include "scene/parts.hpp"

namespace tanor::scene {

namespace {

/// Reads tensions by the names of rods: a number for all, or a list.
std::vector<Prestress> read_prestress(const Cursor& prestress, const System& system) {
  std::vector<Prestress> result;
  for (const auto& [name, value] : prestress.members("an object of tensions by the names of rods")) {
    std::size_t members = 0;
    bool is_found = false;
    for (std::size_t g = 0; g < system.constraints.size(); ++g) {
      const auto* rods = std::get_if<Rods>(&system.constraints[g]);
      if (rods == nullptr || constraint_name(system, g) != name) continue;
      is_found = true;
      members = rods->pairs.size();
    }
    if (!is_found) value.complain("no constraint of kind rod has the name \"" + std::string(name) + "\"");
    Prestress& each = result.emplace_back();
    each.rods = name;
    if (value.is_number()) {
      each.tensions = {value.number()};
      continue;
    }
    for (const Cursor& tension : value.list("a tension, N, or one for each rod"))
      each.tensions.push_back(tension.number());
    if (each.tensions.size() != members)
      value.complain(std::to_string(each.tensions.size()) + " tensions for " + std::to_string(members) +
                     " rods; one for each is right, or one number for all");
  }
  return result;
}

/// Reads sides by the names of constraints.
std::vector<OneSided> read_one_sided(const Cursor& sides, const System& system) {
  std::vector<OneSided> result;
  for (const auto& [name, side] : sides.members("an object of sides by the names of constraints")) {
    bool is_found = false;
    for (std::size_t g = 0; g < system.constraints.size(); ++g) is_found |= constraint_name(system, g) == name;
    if (!is_found) side.complain("no constraint has the name \"" + std::string(name) + "\"");
    result.push_back({std::string(name), side.choice<OneSide>()});
  }
  return result;
}

}  // namespace

void read_equilibrium(const Cursor& equilibrium, Scene* scene) {
  equilibrium.object(keys_of("equilibrium"));
  EquilibriumOptions& options = scene->equilibrium;
  options.method = equilibrium["method"].choice<EquilibriumMethod>(options.method);
  options.accept = equilibrium["accept"].choice<AcceptedEquilibria>(options.accept);
  options.force_tolerance = equilibrium["force_tolerance"].positive(options.force_tolerance);
  constexpr int most = std::numeric_limits<int>::max();
  options.max_iterations = static_cast<int>(equilibrium["max_iterations"].integer(1, most, options.max_iterations));
  options.load_steps = static_cast<int>(equilibrium["load_steps"].integer(1, most, options.load_steps));
  options.at = equilibrium["at"].number(options.at);
  if (const Cursor friction = equilibrium["friction"]) {
    if (!friction.says("ignore")) friction.fail(R"("ignore")");
    options.ignore_friction = true;
  }
  if (const Cursor time = equilibrium["time"]) {
    if (!time.says("freeze")) time.fail(R"("freeze")");
    options.freeze_time = true;
  }
  if (const Cursor sides = equilibrium["one_sided"]) options.one_sided = read_one_sided(sides, scene->system);
  if (const Cursor prestress = equilibrium["prestress"]) options.prestress = read_prestress(prestress, scene->system);
}

EquilibriumOptions equilibrium_options(const Scene& scene) {
  EquilibriumOptions options = scene.equilibrium;
  options.solver = scene.solver;
  return options;
}

}  // namespace tanor::scene
