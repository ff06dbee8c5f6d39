#pragma once

#include "scene/context.hpp"
#include "scene/scene.hpp"

namespace tanor::scene {

/// Reads "motion": how and how far the scene moves, and what is written during it.
void read_motion(const Cursor& motion, const Context& context, const Overrides& overrides, Scene* scene);

/// Reads "solver": how each instant is solved.
void read_solver(const Cursor& solver, const Overrides& overrides, Scene* scene);

}  // namespace tanor::scene
