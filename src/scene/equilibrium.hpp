#pragma once

#include "scene/cursor.hpp"
#include "scene/scene.hpp"

namespace tanor::scene {

/// "equilibrium": how it is searched and which ones are an answer.
void read_equilibrium(const Cursor& equilibrium, Scene* scene);

/// All that a scene says about it, the solver's part too.
EquilibriumOptions equilibrium_options(const Scene& scene);

}  // namespace tanor::scene
