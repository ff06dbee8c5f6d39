#pragma once

#include <string_view>
#include <vector>

#include <tanor/motion.hpp>

#include "scene/context.hpp"

namespace tanor::scene {

struct Overrides;
struct Scene;

/// Reads a list of constraints, coordinates, forces or friction laws, each entry of some kind; [] if it is missing.
/// `wanted` says what the list should be. Each list is instantiated in the file of its name, next to what its kinds
/// need.
template <class Entry>
std::vector<Entry> read_entries(const Cursor& list, std::string_view wanted, const Context& context);

/// Reads "supports": points with prescribed motion.
std::vector<Support> read_supports(const Cursor& list, const Context& context);

/// Reads "units": the name of a system of units, or an object with letters of one's own. Those of the imported file
/// stand for a missing one.
Units read_units(const Cursor& units, const Units& imported);

/// Reads "observe": texts, or objects with more. The default observables stand for a missing one.
std::vector<Observable> read_observables(const Cursor& list, const System& system, const Constants& parameters);

/// Reads "events": conditions on observables, and what is done where they become true.
std::vector<Event> read_events(const Cursor& list, const System& system, const Constants& parameters);

/// Reads "motion": how and how far the scene moves, and what is written during it.
void read_motion(const Cursor& motion, const Context& context, const Overrides& overrides, Scene* scene);

/// Reads "solver": how each instant is solved.
void read_solver(const Cursor& solver, const Overrides& overrides, Scene* scene);

/// Reads "equilibrium": how it is searched and which ones are accepted.
void read_equilibrium(const Cursor& equilibrium, Scene* scene);

/// Reads "modes": their number, and the loads whose buckling factor is requested, which are names of the scene's
/// forces.
void read_modes(const Cursor& modes, Scene* scene);

}  // namespace tanor::scene
