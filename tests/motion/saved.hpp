#pragma once

/// \file Access to the contents of the bytes that a Simulation saves.

#include "simulation/saved_state.hpp"
#include "system/fingerprint.hpp"

namespace tanor {
using namespace detail;

inline Snapshot open_saved(Simulation& simulation) {
  return unpack(simulation.save(), fingerprint_of(simulation.system()));
}

/// Restores from a snapshot that was changed, packed whole and sound again.
inline void restore(const Snapshot& snapshot, Simulation* simulation) {
  simulation->restore(pack(snapshot, fingerprint_of(simulation->system())));
}

}  // namespace tanor
