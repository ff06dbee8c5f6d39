#pragma once

/// \file What is inside the bytes that a Simulation saves.

#include "simulation/saved_state.hpp"
#include "system/fingerprint.hpp"

namespace tanor {

inline Snapshot open_saved(Simulation& simulation) {
  return unpack(simulation.save(), fingerprint_of(simulation.system()));
}

/// A snapshot that was changed, whole and sound again.
inline void restore(const Snapshot& snapshot, Simulation* simulation) {
  simulation->restore(pack(snapshot, fingerprint_of(simulation->system())));
}

}  // namespace tanor
