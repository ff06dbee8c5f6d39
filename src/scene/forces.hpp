#pragma once

#include <vector>

#include <tanor/system.hpp>

#include "scene/context.hpp"

namespace tanor::scene {

/// "forces": active forces, one an entry.
std::vector<Force> read_forces(const Cursor& list, const Context& context);

}  // namespace tanor::scene
