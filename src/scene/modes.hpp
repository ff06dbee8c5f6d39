#pragma once

#include "scene/cursor.hpp"
#include "scene/scene.hpp"

namespace tanor::scene {

/// "modes": how many, and the loads whose buckling factor is asked for; they are names of the scene's forces.
void read_modes(const Cursor& modes, Scene* scene);

}  // namespace tanor::scene
