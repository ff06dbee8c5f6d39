#include "scene/modes.hpp"

#include <algorithm>
#include <string>

#include "scene/parts.hpp"

namespace tanor::scene {

namespace {

constexpr std::int64_t most_modes = 1'000'000;

std::string name_of_load(const Cursor& load, const System& system) {
  const std::string& wanted = load.string();
  for (std::size_t k = 0; k < system.forces.size(); ++k) {
    if (force_name(system, k) == wanted) return wanted;
  }
  load.fail("the name of a force of this scene");
}

}  // namespace

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
