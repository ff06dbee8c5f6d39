#pragma once

#include <array>
#include <vector>

#include "scene/context.hpp"

namespace tanor::scene {

/// Members along rods, which `along` names: three points of every two rods in sequence, four of every three. Throws
/// InputError where no rods have that name, where three of them meet, and where none are in sequence.
void read_along(const Cursor& along, const Context& context, std::vector<std::array<Index, 3>>* triples);
void read_along(const Cursor& along, const Context& context, std::vector<std::array<Index, 4>>* quadruples);

}  // namespace tanor::scene
