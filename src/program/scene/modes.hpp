#pragma once

#include "scene/cursor.hpp"
#include "scene/scene.hpp"

namespace tanor::scene {

/// Reads "modes": their number, and the loads whose buckling factor is requested, which are names of the scene's
/// forces.
void read_modes(const Cursor& modes, Scene* scene);

/// Return the options for modes and buckling about an equilibrium of the scene.
ModesOptions modes_options(const Scene& scene);
BucklingOptions buckling_options(const Scene& scene);

}  // namespace tanor::scene
