#pragma once

#include "scene/cursor.hpp"
#include "scene/scene.hpp"

namespace tanor::scene {

/// "modes": how many, and the loads whose buckling factor is asked for; they are names of the scene's forces.
void read_modes(const Cursor& modes, Scene* scene);

/// What a scene says about modes and buckling about one of its equilibria.
ModesOptions modes_options(const Scene& scene);
BucklingOptions buckling_options(const Scene& scene);

}  // namespace tanor::scene
