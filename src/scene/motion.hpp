#pragma once

#include "scene/context.hpp"
#include "scene/scene.hpp"

namespace tanor::scene {

/// "motion": how and how far the scene moves, and what is written on the way.
void read_motion(const Cursor& motion, const Context& context, const Overrides& overrides, Scene* scene);

/// "solver": how each instant is solved.
void read_solver(const Cursor& solver, const Overrides& overrides, Scene* scene);

}  // namespace tanor::scene
