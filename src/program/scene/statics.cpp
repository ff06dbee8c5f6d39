#include <algorithm>
#include <limits>
#include <string>

#include <tanor/statics_names.hpp>

#include "scene/entries.hpp"
#include "scene/parts.hpp"
#include "scene/scene.hpp"

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

constexpr std::int64_t most_modes = 1'000'000;

std::string name_of_load(const Cursor& load, const System& system) {
  const std::string& wanted = load.string();
  for (std::size_t k = 0; k < system.forces.size(); ++k) {
    if (force_name(system, k) == wanted) return wanted;
  }
  load.fail("the name of a force of this scene");
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
  const auto is_said = [&](const char* key, const char* word) {
    const Cursor given = equilibrium[key];
    if (given && !given.says(word)) given.fail(quote(word));
    return static_cast<bool>(given);
  };
  options.ignore_friction = is_said("friction", "ignore");
  options.freeze_time = is_said("time", "freeze");
  if (const Cursor sides = equilibrium["one_sided"]) options.one_sided = read_one_sided(sides, scene->system);
  if (const Cursor prestress = equilibrium["prestress"]) options.prestress = read_prestress(prestress, scene->system);
}

EquilibriumOptions equilibrium_options(const Scene& scene) {
  EquilibriumOptions options = scene.equilibrium;
  options.solver = scene.solver;
  return options;
}

void read_modes(const Cursor& modes, Scene* scene) {
  modes.object(keys_of("modes"));
  if (const Cursor count = modes["count"]; count.says("all")) {
    scene->modes.count = ModesOptions::all;
  } else if (count && !count.is_number()) {
    count.fail("a whole number > 0, or \"all\"");
  } else {
    scene->modes.count = static_cast<std::size_t>(count.integer(1, most_modes, 10));
  }
  scene->modes.damped = modes["damped"].boolean(false);
  const Cursor buckling = modes["buckling"];
  if (buckling.is_string()) {
    scene->buckling_loads = {name_of_load(buckling, scene->system)};
  } else {
    for (const Cursor& load : buckling.optional_list("the name of a force, or a list of names")) {
      const std::string name = name_of_load(load, scene->system);
      if (std::ranges::find(scene->buckling_loads, name) != scene->buckling_loads.end())
        load.complain("found \"" + name + "\" a second time, wanted each load once");
      scene->buckling_loads.push_back(name);
    }
  }
}

ModesOptions modes_options(const Scene& scene) {
  ModesOptions options = scene.modes;
  options.time = scene.equilibrium.at;
  options.prestress = scene.equilibrium.prestress;
  options.ignore_friction = scene.equilibrium.ignore_friction;
  options.freeze_time = scene.equilibrium.freeze_time;
  options.solver = scene.solver;
  return options;
}

BucklingOptions buckling_options(const Scene& scene) {
  BucklingOptions options;
  options.loads = scene.buckling_loads;
  options.time = scene.equilibrium.at;
  options.ignore_friction = scene.equilibrium.ignore_friction;
  options.freeze_time = scene.equilibrium.freeze_time;
  options.solver = scene.solver;
  return options;
}

}  // namespace tanor::scene
