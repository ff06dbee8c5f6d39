#pragma once

#include <string>

#include <tanor/system.hpp>

namespace tanor {

/// How fast the stiffest spring or damper of a system responds, compared with its slow motion; found from the
/// description alone.
struct Stiffness {
  double rate = 0.0;       ///< 1/s, bound of the frequencies of springs and the decay rates of dampers
  std::string spring{};    ///< the spring that has it, "springs0[17]"
  double slow_rate = 0.0;  ///< 1/s, of falling and swinging over the shortest rod or spring; 0 if unknown
};

Stiffness measure_stiffness(const System& system);

}  // namespace tanor
