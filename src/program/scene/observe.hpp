#pragma once

#include <vector>

#include <tanor/motion.hpp>

#include "scene/context.hpp"

namespace tanor::scene {

/// Reads "units": the name of a system of units, or an object with letters of one's own. Those of the imported file
/// stand for a missing one.
Units read_units(const Cursor& units, const Units& imported);

/// Reads "observe": texts, or objects with more. The default observables stand for a missing one.
std::vector<Observable> read_observables(const Cursor& list, const System& system, const Constants& parameters);

/// Reads "events": conditions on observables, and what is done where they become true.
std::vector<Event> read_events(const Cursor& list, const System& system, const Constants& parameters);

}  // namespace tanor::scene
