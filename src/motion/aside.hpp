#pragma once

#include <functional>

#include "motion/scheme.hpp"

namespace tanor {

/// Calls `work`, which may solve with the mechanics at any state, by any scheme of its own. Then returns the mechanics
/// to `state`, where it is linearised and solved last, and to all that it knew, to the last bit. A motion goes on from
/// there as if `work` had not been done. All processes must call this.
Outcome solve_aside(Mechanics& mechanics, const IntegrationOptions& options, const State& state,
                    const std::function<void()>& work);

}  // namespace tanor
