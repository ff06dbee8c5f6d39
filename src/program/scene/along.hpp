#pragma once

#include <array>
#include <vector>

#include "scene/context.hpp"

namespace tanor::scene {

/// Reads the members along the rods that `along` names: three points of every two rods in sequence, four of every
/// three. Throws InputError if no rods have that name, if three of them meet, or if none are in sequence.
void read_along(const Cursor& along, const Context& context, std::vector<std::array<Index, 3>>* triples);
void read_along(const Cursor& along, const Context& context, std::vector<std::array<Index, 4>>* quadruples);

}  // namespace tanor::scene
