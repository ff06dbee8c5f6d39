#pragma once

#include <vector>

#include <tanor/system.hpp>

#include "scene/context.hpp"

namespace tanor::scene {

/// `coordinates`: [] when it is missing.
std::vector<Coordinates> read_coordinates(const Cursor& list, const Context& context);

}  // namespace tanor::scene
