#pragma once

#include <vector>

#include <tanor/system.hpp>

#include "scene/context.hpp"

namespace tanor::scene {

/// "friction": laws at the points that constraints guide, one an entry.
std::vector<Friction> read_friction(const Cursor& list, const Context& context);

}  // namespace tanor::scene
