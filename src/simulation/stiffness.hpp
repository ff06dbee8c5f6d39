#pragma once

#include <string>

#include <tanor/system.hpp>

namespace tanor {

/// How fast the stiffest spring or damper of a system answers, beside its slow motion; from its description alone.
struct Stiffness {
  double rate = 0.0;       ///< 1/s: bound of the frequencies of springs and the decay rates of dampers
  std::string spring{};    ///< that has it, "springs0[17]"
  double slow_rate = 0.0;  ///< 1/s, of falling and swinging over the shortest rod or spring; 0: nothing is known
};

Stiffness measure_stiffness(const System& system);

}  // namespace tanor
