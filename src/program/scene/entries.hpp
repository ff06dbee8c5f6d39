#pragma once

#include <string_view>
#include <vector>

#include "scene/context.hpp"

namespace tanor::scene {

/// Reads a list of constraints, coordinates, forces or friction laws, each entry of some kind; [] if it is missing.
/// `wanted` says what the list should be. Each list is instantiated in the file of its name, next to what its kinds
/// need.
template <class Entry>
std::vector<Entry> read_entries(const Cursor& list, std::string_view wanted, const Context& context);

/// Reads "supports": points with prescribed motion.
std::vector<Support> read_supports(const Cursor& list, const Context& context);

}  // namespace tanor::scene
