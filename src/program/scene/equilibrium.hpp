#pragma once

#include "scene/cursor.hpp"
#include "scene/scene.hpp"

namespace tanor::scene {

/// Reads "equilibrium": how it is searched and which ones are accepted.
void read_equilibrium(const Cursor& equilibrium, Scene* scene);

/// Returns all options of an equilibrium, including those of "solver".
EquilibriumOptions equilibrium_options(const Scene& scene);

}  // namespace tanor::scene
