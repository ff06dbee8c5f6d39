#pragma once

#include <vector>

#include <tanor/system.hpp>

#include "scene/context.hpp"

namespace tanor::scene {

/// "constraints": the kinds of the contract, one group an entry.
std::vector<Constraint> read_constraints(const Cursor& list, const Context& context);

/// "supports": points with prescribed motion.
std::vector<Support> read_supports(const Cursor& list, const Context& context);

}  // namespace tanor::scene
