#pragma once

#include <functional>
#include <vector>

#include "motion/scheme.hpp"

namespace tanor::detail {

/// Holds the memory of `solve_aside` between calls, so that a step allocates nothing.
struct AsideMemory {
  std::vector<double> known, accelerations;
};

/// Calls `work`, which may solve with the mechanics at any state, by any scheme of its own. Then returns the mechanics
/// to `state`, where it is linearised and solved last, and to all that it knew, to the last bit. A motion goes on from
/// there as if `work` had not been done. All processes must call this.
Outcome solve_aside(Mechanics& mechanics, const IntegrationOptions& options, const State& state,
                    const std::function<void()>& work, AsideMemory* memory);

}  // namespace tanor::detail
